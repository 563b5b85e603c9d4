#include "physics/body/pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "gaussians/base/disjoint_sets.h"
#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"
#include "physics/body/look.h"

namespace pliant {
namespace {

constexpr float kAlike = 0.3f;     // distance of colours in RGB
constexpr float kParallel = 0.5f;  // cosine of the angle between normals
constexpr float kAlong = 0.5f;     // sine of the angle between a gap and the surface

/// Samples on both sides of a gap.
struct Gap {
  int from = -1, to = -1;
  float length = 0;
  bool alike = false;  // in a surface that goes on behind it
};

/// Whether a gap along the unit vector `along` may be one in a surface that looks so on both sides.
bool belong_together(const Look& a, const Look& b, const Vec3f& along) {
  if ((a.color - b.color).norm() > kAlike) return false;
  const bool both = !a.normal.isZero(0) && !b.normal.isZero(0);
  return std::abs(a.normal.dot(along)) <= kAlong && std::abs(b.normal.dot(along)) <= kAlong &&
         (!both || std::abs(a.normal.dot(b.normal)) >= kParallel);
}

/// Finds the gaps between the pieces of samples and says which of them are bridged.
class Gaps {
 public:
  /// `shown` holds the centres of the object's Gaussians.
  Gaps(const BridgeOptions& options, const GaussianCloud& object, const NearestPoints& shown,
       const SolidSamples& samples)
      : options_(options),
        object_(object),
        shown_(shown),
        samples_(samples),
        pieces_(find_pieces(samples.position, samples.volume, options.step)),
        all_(samples.position) {}

  size_t pieces() const { return pieces_.size(); }

  /// The shortest gaps that are bridged of every piece but the largest, no two of one piece closer than a step.
  std::vector<Gap> bridged() const {
    std::vector<std::vector<int>> members(pieces_.size());
    for (size_t i = 0; i < samples_.size(); ++i)
      if (pieces_.piece[i] > 0) members[pieces_.piece[i]].push_back(static_cast<int>(i));
    std::vector<std::vector<Gap>> found(pieces_.size());
    parallel_for(
        static_cast<std::ptrdiff_t>(pieces_.size()) - 1,
        [&](std::ptrdiff_t p) { found[p + 1] = bridged_of(members[p + 1]); }, 1);
    std::vector<Gap> out;
    for (const std::vector<Gap>& gaps : found) out.insert(out.end(), gaps.begin(), gaps.end());
    return out;
  }

 private:
  /// The shortest gap from sample `i` to another piece, up to `most`.
  std::optional<Gap> gap_from(int i, float most, std::vector<NearestPoints::Hit>& hits) const {
    all_.within(samples_.position[i], most, hits);
    for (const NearestPoints::Hit& hit : hits)
      if (pieces_.piece[hit.index] != pieces_.piece[i]) {
        const Gap gap{i, hit.index, hit.distance, is_alike({i, hit.index, hit.distance})};
        if (gap.alike || gap.length <= options_.plain) return gap;
      }
    return std::nullopt;
  }

  bool is_alike(const Gap& gap) const {
    if (gap.length > options_.reach) return false;
    const Vec3f a = samples_.position[gap.from], b = samples_.position[gap.to];
    std::vector<NearestPoints::Hit> hit;
    const auto look_at = [&](const Vec3f& x) {
      shown_.query(x, 1, hit);
      return look_of(object_, hit[0].index);
    };
    return belong_together(look_at(a), look_at(b), (b - a) / gap.length);
  }

  std::vector<Gap> bridged_of(const std::vector<int>& members) const {
    std::vector<NearestPoints::Hit> hits;
    std::vector<Gap> gaps;
    float shortest = options_.reach;
    for (const int i : members)
      if (const std::optional<Gap> gap = gap_from(i, std::min(shortest + options_.step, options_.reach), hits)) {
        shortest = std::min(shortest, gap->length);
        gaps.push_back(*gap);
      }
    // A leaf goes on in its own surface, not in the next leaf.
    if (std::any_of(gaps.begin(), gaps.end(), [](const Gap& gap) { return gap.alike; }))
      std::erase_if(gaps, [](const Gap& gap) { return !gap.alike; });
    std::stable_sort(gaps.begin(), gaps.end(), [](const Gap& a, const Gap& b) { return a.length < b.length; });
    std::vector<Gap> apart;
    for (const Gap& gap : gaps) {
      const Vec3f x = samples_.position[gap.from];
      const auto near = [&](const Gap& g) { return (samples_.position[g.from] - x).norm() < options_.step; };
      if (gap.length <= shortest + options_.step && std::none_of(apart.begin(), apart.end(), near))
        apart.push_back(gap);
    }
    return apart;
  }

  const BridgeOptions& options_;
  const GaussianCloud& object_;
  const NearestPoints& shown_;
  const SolidSamples& samples_;
  Pieces pieces_;
  NearestPoints all_;
};

/// Whether `x` lies in a visible Gaussian, or within `tolerance` of it.
bool is_covered(const GaussianCloud& object, const NearestPoints& shown, const Vec3f& x, float tolerance) {
  constexpr int kNearest = 10;
  constexpr float kReach = 2, kVisible = 0.1f;  // standard deviations; opacity
  std::vector<NearestPoints::Hit> hits;
  shown.query(x, kNearest, hits);
  return std::any_of(hits.begin(), hits.end(), [&](const NearestPoints::Hit& hit) {
    const int g = hit.index;
    const Vec3f d = rotation_matrix<float>(object.rotation[g]).transpose() * (x - object.position[g]);
    const Vec3f radius = (kReach * object.log_scale[g].array().exp()).max(tolerance);
    return sigmoid(object.opacity_logit[g]) >= kVisible && (d.array() / radius.array()).matrix().squaredNorm() <= 1;
  });
}

/// Adds samples half of `step` apart across a gap.  What Gaussians cover of it the samples at its ends stand for, so
/// they share their volume with it; what they do not has the cross-section of the ends.
void bridge(const Gap& gap, const GaussianCloud& object, const NearestPoints& shown, float step,
            SolidSamples& samples) {
  const Vec3f a = samples.position[gap.from], b = samples.position[gap.to];
  const int count = static_cast<int>(gap.length / (0.5f * step));
  std::vector<uint8_t> covered;
  for (int k = 1; k <= count; ++k) {
    samples.position.push_back(a + (b - a) * static_cast<float>(k) / static_cast<float>(count + 1));
    covered.push_back(is_covered(object, shown, samples.position.back(), 0.5f * samples.spacing));
    if (samples.thickness.empty()) continue;
    const float one = samples.thickness[gap.from], other = samples.thickness[gap.to];
    samples.thickness.push_back(one > 0 && other > 0 ? std::min(one, other) : std::max(one, other));
  }
  const float mean = 0.5f * (samples.volume[gap.from] + samples.volume[gap.to]);
  const float kept = 2 / static_cast<float>(2 + std::count(covered.begin(), covered.end(), 1));
  const float missing = mean * gap.length / static_cast<float>(count + 1) / samples.spacing;
  samples.volume[gap.from] *= kept;
  samples.volume[gap.to] *= kept;
  for (const uint8_t there : covered) samples.volume.push_back(there ? kept * mean : missing);
}

/// Joins the points that are at most `reach` apart.  All points of a cell are, and of two cells that hang together no
/// pair needs to be looked at any more.
void join_near(std::span<const Vec3f> points, float reach, DisjointSets& sets) {
  using Cell = std::array<int64_t, 3>;
  const float side = 0.999f * reach / std::sqrt(3.0f);
  std::map<Cell, std::vector<int>> cells;
  for (size_t i = 0; i < points.size(); ++i) {
    Cell cell;
    for (int a = 0; a < 3; ++a) cell[a] = static_cast<int64_t>(std::floor(points[i][a] / side));
    cells[cell].push_back(static_cast<int>(i));
  }
  const auto touch = [&](const std::vector<int>& here, const std::vector<int>& there) {
    for (const int i : here)
      for (const int k : there)
        if ((points[i] - points[k]).squaredNorm() <= reach * reach) return true;
    return false;
  };
  for (const auto& [cell, members] : cells) {
    for (const int i : members) sets.join(members[0], i);
    // Half of the cells that are within reach; the others look back.
    for (int o = 0; o < 125 / 2; ++o) {
      const auto other = cells.find({cell[0] + o / 25 - 2, cell[1] + o / 5 % 5 - 2, cell[2] + o % 5 - 2});
      if (other == cells.end() || sets.find(members[0]) == sets.find(other->second[0])) continue;
      if (touch(members, other->second)) sets.join(members[0], other->second[0]);
    }
  }
}

}  // namespace

Pieces find_pieces(std::span<const Vec3f> points, std::span<const float> weight, float reach) {
  CHECK(points.size() == weight.size());
  const int n = static_cast<int>(points.size());
  DisjointSets sets(n);
  if (reach > 0) join_near(points, reach, sets);

  std::vector<double> sum(n, 0);
  for (int i = 0; i < n; ++i) sum[sets.find(i)] += weight[i];
  std::vector<int> roots;
  for (int i = 0; i < n; ++i)
    if (sets.find(i) == i) roots.push_back(i);
  std::stable_sort(roots.begin(), roots.end(), [&](int a, int b) { return sum[a] > sum[b]; });
  Pieces pieces;
  std::vector<int> number(n);
  for (const int r : roots) {
    number[r] = static_cast<int>(pieces.weight.size());
    pieces.weight.push_back(sum[r]);
  }
  for (int i = 0; i < n; ++i) pieces.piece.push_back(number[sets.find(i)]);
  return pieces;
}

BridgeSummary bridge_gaps(const BridgeOptions& options, const GaussianCloud& object, SolidSamples& samples) {
  CHECK(samples.spacing > 0);
  constexpr int kRounds = 8;  // each at least halves the pieces that can be joined
  BridgeSummary summary;
  const size_t before = samples.size();
  const NearestPoints shown(object.position);
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Gap> gaps = Gaps(options, object, shown, samples).bridged();
    if (gaps.empty()) break;
    for (const Gap& gap : gaps) bridge(gap, object, shown, options.step, samples);
    summary.bridges += static_cast<int>(gaps.size());
  }
  summary.samples = samples.size() - before;
  return summary;
}

}  // namespace pliant
