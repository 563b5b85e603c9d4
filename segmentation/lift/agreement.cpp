#include "segmentation/lift/agreement.h"

#include <algorithm>
#include <set>

#include "gaussians/base/error.h"

namespace pliant {

std::vector<uint8_t> contour_band(const IdImage& ids, uint32_t id, int band) {
  // Erosion by a square of 2 band + 1 pixels, along rows and then along columns; outside of the picture is not `id`.
  const int width = ids.width, height = ids.height;
  const auto eroded_line = [band](int n, auto&& inside, auto&& write) {
    int run = 0;  // pixels of the mask that end here
    for (int i = 0; i < n + band; ++i) {
      run = i < n && inside(i) ? run + 1 : 0;
      if (i >= band) write(i - band, run >= 2 * band + 1);
    }
  };
  std::vector<uint8_t> rows(ids.data.size()), inner(ids.data.size());
  for (int y = 0; y < height; ++y)
    eroded_line(width, [&](int x) { return ids(x, y) == id; }, [&](int x, bool in) { rows[static_cast<size_t>(y) * width + x] = in; });
  for (int x = 0; x < width; ++x)
    eroded_line(height, [&](int y) { return rows[static_cast<size_t>(y) * width + x] != 0; },
                [&](int y, bool in) { inner[static_cast<size_t>(y) * width + x] = in; });
  for (size_t i = 0; i < inner.size(); ++i) inner[i] = ids.data[i] == id && !inner[i];
  return inner;
}

IdAgreement boundary_agreement(std::span<const IdImage> predicted, std::span<const IdImage> truth, int band) {
  CHECK(predicted.size() == truth.size());
  std::map<uint32_t, std::pair<size_t, size_t>> overlap;  // intersection, union
  for (size_t v = 0; v < truth.size(); ++v) {
    CHECK(predicted[v].width == truth[v].width && predicted[v].height == truth[v].height);
    for (uint32_t id : std::set<uint32_t>(truth[v].data.begin(), truth[v].data.end())) {
      if (id == 0) continue;
      const std::vector<uint8_t> ours = contour_band(predicted[v], id, band), theirs = contour_band(truth[v], id, band);
      for (size_t i = 0; i < ours.size(); ++i) {
        if (truth[v].data[i] == 0) continue;
        overlap[id].first += ours[i] && theirs[i], overlap[id].second += ours[i] || theirs[i];
      }
    }
  }
  IdAgreement agreement;
  for (const auto& [id, counts] : overlap) {
    agreement.iou[id] = counts.second > 0 ? static_cast<double>(counts.first) / static_cast<double>(counts.second) : 1.0;
    agreement.mean += agreement.iou[id] / static_cast<double>(overlap.size());
  }
  return agreement;
}

void OverlapMatch::add(std::span<const uint32_t> predicted, std::span<const uint32_t> truth) {
  CHECK(predicted.size() == truth.size());
  for (size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] == 0 || predicted[i] == 0) continue;
    ++both_[{predicted[i], truth[i]}], ++predicted_[predicted[i]], ++truth_[truth[i]];
  }
}

std::map<uint32_t, uint32_t> OverlapMatch::match() const {
  struct Pair {
    double iou;
    uint32_t predicted, truth;
  };
  std::vector<Pair> order;
  for (const auto& [pair, both] : both_)
    order.push_back({static_cast<double>(both) / static_cast<double>(predicted_.at(pair.first) + truth_.at(pair.second) - both),
                     pair.first, pair.second});
  std::stable_sort(order.begin(), order.end(), [](const Pair& a, const Pair& b) { return a.iou > b.iou; });
  std::map<uint32_t, uint32_t> match;
  std::set<uint32_t> taken;
  for (const Pair& pair : order)
    if (!match.count(pair.predicted) && taken.insert(pair.truth).second) match[pair.predicted] = pair.truth;
  return match;
}

}  // namespace pliant
