#include "segmentation/labels/agreement.h"

#include <algorithm>
#include <set>

#include "gaussians/base/error.h"

namespace pliant {

std::vector<uint8_t> contour_bands(const IdImage& ids, int band) {
  // Erosion of all ids by a square of 2 band + 1 pixels, along rows and then along columns; outside of the picture is
  // none of them.  `same(i)`: pixel i goes on with what pixel i - 1 belongs to; `inside(i)`: it is still there.
  const int width = ids.width, height = ids.height;
  const auto eroded_line = [band](int n, auto&& inside, auto&& same, auto&& write) {
    int run = 0;  // pixels of one mask that end here
    for (int i = 0; i < n + band; ++i) {
      run = i >= n || !inside(i) ? 0 : i > 0 && same(i) ? run + 1 : 1;
      if (i >= band) write(i - band, run >= 2 * band + 1);
    }
  };
  std::vector<uint8_t> rows(ids.data.size()), ring(ids.data.size());
  for (int y = 0; y < height; ++y)
    eroded_line(
        width, [](int) { return true; }, [&](int x) { return ids(x, y) == ids(x - 1, y); },
        [&](int x, bool in) { rows[static_cast<size_t>(y) * width + x] = in; });
  for (int x = 0; x < width; ++x)
    eroded_line(
        height, [&](int y) { return rows[static_cast<size_t>(y) * width + x] != 0; },
        [&](int y) { return ids(x, y) == ids(x, y - 1); },
        [&](int y, bool in) { ring[static_cast<size_t>(y) * width + x] = !in; });
  return ring;
}

void count_boundaries(const IdImage& predicted, const IdImage& truth, int band,
                      std::map<uint32_t, OverlapCount>& overlap) {
  CHECK(predicted.width == truth.width && predicted.height == truth.height);
  const std::vector<uint8_t> ours = contour_bands(predicted, band), theirs = contour_bands(truth, band);
  std::map<uint32_t, OverlapCount> here;
  for (size_t i = 0; i < truth.data.size(); ++i) {
    const uint32_t p = predicted.data[i], t = truth.data[i];
    if (t == 0 || !(ours[i] || theirs[i])) continue;
    if (theirs[i]) ++here[t].either;
    if (!ours[i]) continue;
    if (p == t && theirs[i])
      ++here[t].both;
    else if (p != 0)
      ++here[p].either;
  }
  for (const auto& [id, count] : here) {
    overlap[id].both += count.both;
    overlap[id].either += count.either;
  }
}

IdAgreement boundary_agreement(std::span<const IdImage> predicted, std::span<const IdImage> truth, int band) {
  CHECK(predicted.size() == truth.size());
  std::map<uint32_t, OverlapCount> overlap;
  std::set<uint32_t> ids;
  for (size_t v = 0; v < truth.size(); ++v) {
    count_boundaries(predicted[v], truth[v], band, overlap);
    ids.insert(truth[v].data.begin(), truth[v].data.end());
  }
  ids.erase(0);
  IdAgreement agreement;
  for (const uint32_t id : ids) {
    agreement.iou[id] = overlap[id].iou();
    agreement.mean += agreement.iou[id] / static_cast<double>(ids.size());
  }
  return agreement;
}

void OverlapMatch::add(std::span<const uint32_t> predicted, std::span<const uint32_t> truth) {
  CHECK(predicted.size() == truth.size());
  for (size_t i = 0, next = 0; i < truth.size(); i = next) {
    for (next = i + 1; next < truth.size() && truth[next] == truth[i] && predicted[next] == predicted[i];) ++next;
    if (truth[i] == 0 || predicted[i] == 0) continue;
    const size_t run = next - i;
    both_[{predicted[i], truth[i]}] += run;
    predicted_[predicted[i]] += run;
    truth_[truth[i]] += run;
  }
}

std::map<uint32_t, uint32_t> OverlapMatch::match() const {
  struct Pair {
    double iou;
    uint32_t predicted, truth;
  };
  std::vector<Pair> order;
  for (const auto& [pair, both] : both_)
    order.push_back(
        {static_cast<double>(both) / static_cast<double>(predicted_.at(pair.first) + truth_.at(pair.second) - both),
         pair.first, pair.second});
  std::stable_sort(order.begin(), order.end(), [](const Pair& a, const Pair& b) { return a.iou > b.iou; });
  std::map<uint32_t, uint32_t> match;
  std::set<uint32_t> taken;
  for (const Pair& pair : order)
    if (!match.count(pair.predicted) && taken.insert(pair.truth).second) match[pair.predicted] = pair.truth;
  return match;
}

}  // namespace pliant
