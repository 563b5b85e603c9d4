#include "segmentation/repair/exemplar.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <opencv2/photo.hpp>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/quantile.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

/// One scale of the pyramid.
struct Level {
  ImageF picture;
  ImageU8 known, target;

  int width() const { return picture.width; }
  int height() const { return picture.height; }
  bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < width() && y < height(); }
};

/// Half the size: a block is a target if it holds one, else known if half of it is.
Level halved(const Level& fine) {
  const int width = (fine.width() + 1) / 2, height = (fine.height() + 1) / 2;
  Level coarse{ImageF(width, height, 3), ImageU8(width, height, 1), ImageU8(width, height, 1)};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      int known = 0, all = 0;
      float sum[3] = {0, 0, 0};
      for (int j = 2 * y; j < std::min(2 * y + 2, fine.height()); ++j)
        for (int i = 2 * x; i < std::min(2 * x + 2, fine.width()); ++i) {
          ++all;
          coarse.target(x, y) |= fine.target(i, j);
          if (!fine.known(i, j)) continue;
          ++known;
          for (int k = 0; k < 3; ++k) sum[k] += fine.picture(i, j, k);
        }
      coarse.known(x, y) = !coarse.target(x, y) && 2 * known >= all;
      if (known)
        for (int k = 0; k < 3; ++k) coarse.picture(x, y, k) = sum[k] / static_cast<float>(known);
    }
  return coarse;
}

cv::Mat distance_to(const ImageU8& mask) {
  cv::Mat inverse(mask.height, mask.width, CV_8U), distance;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) inverse.at<uint8_t>(y, x) = !mask(x, y);
  cv::distanceTransform(inverse, distance, cv::DIST_L2, 5);
  return distance;
}

/// Translations under which known pixels near the target repeat, best first.
std::vector<Offset> offsets_around(const Level& level, int count) {
  const cv::Mat distance = distance_to(level.target);
  const float band = std::max(6.0f, 0.12f * static_cast<float>(std::min(level.width(), level.height())));
  ImageU8 probes = level.known;
  for (int y = 0; y < level.height(); ++y)
    for (int x = 0; x < level.width(); ++x) probes(x, y) &= distance.at<float>(y, x) <= band;
  return repeated_offsets(level.picture, level.known, probes, count);
}

/// First guess at the coarsest scale: the best translation that lands on a known pixel, else Telea's.
void first_guess(Level& level, const std::vector<Offset>& offsets) {
  cv::Mat bytes(level.height(), level.width(), CV_8UC3), mask(level.height(), level.width(), CV_8U), filled;
  for (int y = 0; y < level.height(); ++y)
    for (int x = 0; x < level.width(); ++x) {
      mask.at<uint8_t>(y, x) = level.known(x, y) ? 0 : 255;
      for (int k = 0; k < 3; ++k)
        bytes.at<cv::Vec3b>(y, x)[k] = cv::saturate_cast<uint8_t>(255 * level.picture(x, y, k));
    }
  // OpenCV reads the second line of a picture in the place of the outermost one, though it may be unknown.
  cv::copyMakeBorder(bytes, bytes, 1, 1, 1, 1, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(mask, mask, 1, 1, 1, 1, cv::BORDER_REPLICATE);
  cv::inpaint(bytes, mask, filled, 3, cv::INPAINT_TELEA);
  filled = filled(cv::Rect(1, 1, level.width(), level.height()));
  const ImageF original = level.picture;
  for (int y = 0; y < level.height(); ++y)
    for (int x = 0; x < level.width(); ++x) {
      if (!level.target(x, y)) continue;
      for (int k = 0; k < 3; ++k) level.picture(x, y, k) = static_cast<float>(filled.at<cv::Vec3b>(y, x)[k]) / 255;
      for (const Offset& o : offsets) {
        if (!level.inside(x + o.x, y + o.y) || !level.known(x + o.x, y + o.y)) continue;
        std::copy_n(original.at(x + o.x, y + o.y), 3, level.picture.at(x, y));
        break;
      }
    }
}

/// Search and vote at one scale.
class Completion {
 public:
  Completion(const ExemplarOptions& options, Level& level, const std::vector<Offset>& offsets, uint64_t scale)
      : options_(options), level_(level), offsets_(offsets), scale_(scale), r_(options.patch_radius) {
    index_.assign(static_cast<size_t>(level.width()) * level.height(), -1);
    source_.assign(index_.size(), 0);
    const cv::Mat distance = distance_to(level.target);
    for (int y = 0; y < level.height(); ++y)
      for (int x = 0; x < level.width(); ++x) {
        if (whole_source(x, y)) {
          sources_.push_back({x, y});
          source_[static_cast<size_t>(y) * level.width() + x] = 1;
        }
        if (distance.at<float>(y, x) > 1.5f * static_cast<float>(r_)) continue;
        if (!near_target(x, y)) continue;
        index_[static_cast<size_t>(y) * level.width() + x] = static_cast<int>(patches_.size());
        patches_.push_back({{x, y}, {0, 0}, INFINITY});
      }
    // Depth inside the target: voters near known pixels are trusted more.
    ImageU8 not_target(level.width(), level.height(), 1);
    for (size_t i = 0; i < not_target.data.size(); ++i) not_target.data[i] = !level.target.data[i];
    depth_ = distance_to(not_target);
  }

  bool possible() const { return !sources_.empty() && !patches_.empty(); }

  /// Nearest-neighbour field from the coarser scale.
  void start(const Completion* coarser) {
    for (Patch& p : patches_) {
      if (coarser) {
        const int i = coarser->patch_index(p.at.x / 2, p.at.y / 2);
        if (i >= 0) {
          const Patch& c = coarser->patches_[i];
          p.source = {2 * c.source.x + p.at.x % 2, 2 * c.source.y + p.at.y % 2};
          if (is_source(p.source.x, p.source.y)) continue;
        }
      }
      p.source = sources_[Random(options_.seed, p.at.y * 65536ull + p.at.x, scale_ * 1000).below(sources_.size())];
    }
    if (coarser) vote(false);
  }

  void run() {
    for (int round = 0; round < options_.rounds; ++round) {
      for (Patch& p : patches_) p.cost = cost(p.at, p.source, INFINITY);
      search(2 * round, false);
      search(2 * round + 1, true);
      vote(round + 1 == options_.rounds);
    }
  }

 private:
  struct Patch {
    Offset at, source;  ///< centres
    float cost;
  };

  int patch_index(int x, int y) const {
    return level_.inside(x, y) ? index_[static_cast<size_t>(y) * level_.width() + x] : -1;
  }
  bool whole_source(int x, int y) const {
    for (int j = -r_; j <= r_; ++j)
      for (int i = -r_; i <= r_; ++i)
        if (!level_.inside(x + i, y + j) || !level_.known(x + i, y + j)) return false;
    return true;
  }
  bool is_source(int x, int y) const {
    return level_.inside(x, y) && source_[static_cast<size_t>(y) * level_.width() + x];
  }
  bool near_target(int x, int y) const {
    for (int j = -r_; j <= r_; ++j)
      for (int i = -r_; i <= r_; ++i)
        if (level_.inside(x + i, y + j) && level_.target(x + i, y + j)) return true;
    return false;
  }

  /// Mean squared difference over the patch's usable pixels; stops above `limit`.
  float cost(const Offset& at, const Offset& source, float limit) const {
    float sum = 0, weight = 0;
    const float stop = limit * static_cast<float>((2 * r_ + 1) * (2 * r_ + 1));
    for (int j = -r_; j <= r_; ++j) {
      for (int i = -r_; i <= r_; ++i) {
        const int x = at.x + i, y = at.y + j;
        if (!level_.inside(x, y)) continue;
        const bool known = level_.known(x, y);
        if (!known && !level_.target(x, y)) continue;
        const float *a = level_.picture.at(x, y), *b = level_.picture.at(source.x + i, source.y + j);
        const float w = known ? 2.0f : 1.0f;
        sum += w * ((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
        weight += w;
      }
      if (sum > 2 * stop) return INFINITY;
    }
    return sum / weight;
  }

  void improve(Patch& p, int x, int y) const {
    if (!is_source(x, y)) return;
    const float c = cost(p.at, {x, y}, p.cost);
    if (c < p.cost) {
      p.cost = c;
      p.source = {x, y};
    }
  }

  void search(int pass, bool backwards) {
    const int n = static_cast<int>(patches_.size()), step = backwards ? 1 : -1;
    const int reach = std::max(level_.width(), level_.height());
    for (int k = 0; k < n; ++k) {
      Patch& p = patches_[backwards ? n - 1 - k : k];
      if (const int i = patch_index(p.at.x + step, p.at.y); i >= 0)
        improve(p, patches_[i].source.x - step, patches_[i].source.y);
      if (const int i = patch_index(p.at.x, p.at.y + step); i >= 0)
        improve(p, patches_[i].source.x, patches_[i].source.y - step);
      for (const Offset& o : offsets_) improve(p, p.at.x + o.x, p.at.y + o.y);
      Random random(options_.seed, p.at.y * 65536ull + p.at.x, scale_ * 1000 + pass + 1);
      for (int radius = reach; radius >= 1; radius /= 2) {
        const int x = p.source.x + static_cast<int>(random.below(2 * radius + 1)) - radius;
        const int y = p.source.y + static_cast<int>(random.below(2 * radius + 1)) - radius;
        improve(p, x, y);
      }
    }
  }

  /// Every target pixel becomes the weighted mean of what the patches around it copy there; in the last round only
  /// the best of them speaks, which keeps the texture sharp.
  void vote(bool last) {
    std::vector<float> costs;
    for (const Patch& p : patches_)
      if (std::isfinite(p.cost)) costs.push_back(p.cost);
    const float spread = costs.empty() ? 1.0f : std::max(quantile(std::move(costs), 0.75), 1e-6f);
    const ImageF before = level_.picture;
    for (int y = 0; y < level_.height(); ++y)
      for (int x = 0; x < level_.width(); ++x) {
        if (!level_.target(x, y)) continue;
        float sum[3] = {0, 0, 0}, total = 0;
        for (int j = -r_; j <= r_; ++j)
          for (int i = -r_; i <= r_; ++i) {
            const int k = patch_index(x - i, y - j);
            if (k < 0) continue;
            const Patch& p = patches_[k];
            const float* color = before.at(p.source.x + i, p.source.y + j);
            const float distance = level_.inside(p.at.x, p.at.y) ? depth_.at<float>(p.at.y, p.at.x) : 0.0f;
            float w = std::pow(1.3f, -distance) * std::exp(-(std::isfinite(p.cost) ? p.cost / (2 * spread) : 0.0f));
            if (last) w = w * w * w * std::exp(-static_cast<float>(i * i + j * j) / 4.0f);
            for (int c = 0; c < 3; ++c) sum[c] += w * color[c];
            total += w;
          }
        if (total > 0)
          for (int c = 0; c < 3; ++c) level_.picture(x, y, c) = sum[c] / total;
      }
  }

  const ExemplarOptions& options_;
  Level& level_;
  const std::vector<Offset>& offsets_;
  uint64_t scale_;
  int r_;
  std::vector<Offset> sources_;
  std::vector<Patch> patches_;
  std::vector<int> index_;       ///< patch centred at a pixel, -1 = none
  std::vector<uint8_t> source_;  ///< whether the patch at a pixel may be copied
  cv::Mat depth_;
};

}  // namespace

std::vector<Offset> repeated_offsets(const ImageF& picture, const ImageU8& known, const ImageU8& chosen, int count) {
  const int width = picture.width, height = picture.height;
  std::vector<Offset> probes;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (chosen(x, y)) probes.push_back({x, y});
  if (probes.empty()) return {};
  const size_t step = std::max<size_t>(1, probes.size() / 300);
  const int reach_x = width * 3 / 4, reach_y = height * 3 / 4;
  const int columns = 2 * reach_x + 1;
  std::vector<float> cost(static_cast<size_t>(columns) * (2 * reach_y + 1), INFINITY);
  parallel_for(
      2 * reach_y + 1,
      [&](std::ptrdiff_t row) {
        const int dy = static_cast<int>(row) - reach_y;
        for (int dx = -reach_x; dx <= reach_x; ++dx) {
          if (dx * dx + dy * dy < 9) continue;
          size_t tried = 0, met = 0;
          float sum = 0;
          for (size_t i = 0; i < probes.size(); i += step, ++tried) {
            const int x = probes[i].x + dx, y = probes[i].y + dy;
            if (x < 0 || y < 0 || x >= width || y >= height || !known(x, y)) continue;
            ++met;
            for (int k = 0; k < 3; ++k) {
              const float d = picture(x, y, k) - picture(probes[i].x, probes[i].y, k);
              sum += d * d;
            }
          }
          if (5 * met >= 2 * tried) cost[row * columns + dx + reach_x] = sum / static_cast<float>(met);
        }
      },
      4);
  struct Candidate {
    float cost;
    Offset offset;
  };
  std::vector<Candidate> minima;
  for (int row = 0; row <= 2 * reach_y; ++row)
    for (int column = 0; column < columns; ++column) {
      const float here = cost[static_cast<size_t>(row) * columns + column];
      bool lowest = std::isfinite(here);
      for (int j = std::max(0, row - 1); j <= std::min(2 * reach_y, row + 1) && lowest; ++j)
        for (int i = std::max(0, column - 1); i <= std::min(columns - 1, column + 1); ++i)
          lowest = lowest && here <= cost[static_cast<size_t>(j) * columns + i];
      if (lowest) minima.push_back({here, {column - reach_x, row - reach_y}});
    }
  std::stable_sort(minima.begin(), minima.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
  std::vector<Offset> offsets;
  for (size_t i = 0; i < minima.size() && static_cast<int>(i) < count; ++i) offsets.push_back(minima[i].offset);
  return offsets;
}

ImageF exemplar_fill(const ExemplarOptions& options, const ImageF& picture, const ImageU8& known,
                     const ImageU8& target) {
  CHECK(picture.channels == 3 && known.pixels() == picture.pixels() && target.pixels() == picture.pixels());
  std::vector<Level> levels = {{picture, known, target}};
  for (size_t i = 0; i < known.data.size(); ++i) levels[0].known.data[i] = known.data[i] && !target.data[i];
  if (std::count(target.data.begin(), target.data.end(), 1) == 0) return picture;
  while (std::min(levels.back().width(), levels.back().height()) >= 40 && levels.size() < 5) {
    const Level next = halved(levels.back());
    const int patch = 2 * options.patch_radius + 1;
    if (std::count(next.known.data.begin(), next.known.data.end(), 1) < 8 * patch * patch) break;
    levels.push_back(next);
  }

  // Repeats are looked for at the second finest scale, which is cheap and exact enough, and carried to the others.
  const size_t probe = std::min<size_t>(1, levels.size() - 1);
  std::vector<std::vector<Offset>> offsets(levels.size());
  offsets[probe] = offsets_around(levels[probe], options.offsets);
  for (size_t s = probe + 1; s < levels.size(); ++s)
    for (const Offset& o : offsets[s - 1])
      offsets[s].push_back({static_cast<int>(std::lround(o.x / 2.0)), static_cast<int>(std::lround(o.y / 2.0))});
  if (probe == 1)
    for (const Offset& o : offsets[1])
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) offsets[0].push_back({2 * o.x + i, 2 * o.y + j});

  first_guess(levels.back(), offsets.back());
  std::unique_ptr<Completion> coarser;
  for (size_t s = levels.size(); s-- > 0;) {
    auto completion = std::make_unique<Completion>(options, levels[s], offsets[s], s + 1);
    if (!completion->possible()) {
      // Nothing to copy from at this scale: the first guess stays.
      if (s + 1 < levels.size() || levels.size() == 1) first_guess(levels[s], offsets[s]);
      coarser.reset();
      continue;
    }
    if (s + 1 < levels.size() && !coarser) first_guess(levels[s], offsets[s]);
    completion->start(coarser.get());
    completion->run();
    coarser = std::move(completion);
  }
  return levels[0].picture;
}

}  // namespace pliant
