#include "app/evaluate/flow_comparison.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "gaussians/vision/optical_flow.h"

using nlohmann::json;

namespace pliant {
namespace {

constexpr double kMoves = 0.25;         // px per frame, from which on a pixel counts
constexpr double kSameInstant = 0.02;   // of a step
constexpr double kDelayPixels = 2000;   // that the delay is sought with
constexpr double kLeastMatch = 0.7;     // correlation, below which no shift makes the motions alike
constexpr double kClearlyBetter = 0.9;  // correlation without a shift, relative to the best one
constexpr double kAsGood = 0.98;        // relative to the best correlation

using Flows = std::vector<ImageF>;

/// Motion from one frame to another, of which only the time from `begin` to `end` counts: 0 at one, 1 at the other.
struct Part {
  int from, to;
  double begin = 0, end = 1;
};

/// What a time from `begin` to `end`, in frames, consists of: whole frames at once, and parts of those at both ends.
std::vector<Part> parts_of(double begin, double end) {
  const auto snapped = [](double at) { return std::abs(at - std::round(at)) < kSameInstant ? std::round(at) : at; };
  begin = snapped(begin);
  end = snapped(end);
  const int before = static_cast<int>(std::floor(begin)), first = static_cast<int>(std::ceil(begin)),
            last = static_cast<int>(std::floor(end));
  if (last < first) return {{before, first, begin - before, end - before}};
  std::vector<Part> parts;
  if (before < first) parts.push_back({before, first, begin - before, 1});
  if (first < last) parts.push_back({first, last});
  if (last < end) parts.push_back({last, last + 1, 0, end - last});
  return parts;
}

/// Where the parts, one after the other, with a flow [H, W, 2] for each, carry what is at each pixel in the beginning.
ImageF flow_along(const Part* part, const ImageF* flow, size_t parts) {
  ImageF out(flow->width, flow->height, 2);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const Eigen::Vector2d pixel(x + 0.5, y + 0.5);
      Eigen::Vector2d moved = Eigen::Vector2d::Zero();
      for (size_t k = 0; k < parts; ++k) {
        const auto flow_at = [&](const Eigen::Vector2d& at) {
          return Eigen::Vector2d(sample(flow[k], at.x(), at.y(), 0), sample(flow[k], at.x(), at.y(), 1));
        };
        // The place in the frame that the flow starts from.
        Eigen::Vector2d origin = pixel + moved;
        for (int i = 0; i < 2 && part[k].begin > 0; ++i) origin = pixel + moved - part[k].begin * flow_at(origin);
        moved += (part[k].end - part[k].begin) * flow_at(origin);
      }
      out(x, y, 0) = static_cast<float>(moved.x());
      out(x, y, 1) = static_cast<float>(moved.y());
    }
  return out;
}

/// Flows of a video in the steps of the truth, from f / fps to (f + 1) / fps after its first frame; empty in those
/// that begin before the video.
Flows flows_in_steps_of(const ReferenceVideo& truth, const ReferenceVideo& video) {
  const double late = video.start - truth.start, frames_per_step = video.fps / truth.fps;
  std::vector<Part> parts;
  std::vector<size_t> first;  // part of each step
  for (int f = 0;; ++f) {
    const double begin = f * frames_per_step - late * video.fps, end = begin + frames_per_step;
    if (end > static_cast<double>(video.frames.size() - 1) + kSameInstant) break;
    first.push_back(parts.size());
    if (begin < -kSameInstant) continue;
    for (const Part& part : parts_of(begin, end)) parts.push_back(part);
  }
  std::vector<std::pair<int, int>> pairs;
  for (const Part& part : parts) pairs.push_back({part.from, part.to});
  Flows flows = dense_flows(video.frames, pairs, FlowQuality::kQuick), out(first.size());
  for (size_t f = 0; f < first.size(); ++f) {
    const size_t k = first[f], count = (f + 1 < first.size() ? first[f + 1] : parts.size()) - k;
    if (count == 1 && parts[k].begin == 0 && parts[k].end == 1)
      out[f] = std::move(flows[k]);
    else if (count > 0)
      out[f] = flow_along(&parts[k], &flows[k], count);
  }
  return out;
}

/// visit(p, t): flows of the video, `shift` steps later, and of the truth, at every stride-th pixel of a row and row.
template <class F>
void for_each_pixel(const Flows& video, const Flows& truth, int shift, int stride, F&& visit) {
  for (int f = std::max(0, -shift); f < static_cast<int>(truth.size()); ++f) {
    if (f + shift >= static_cast<int>(video.size())) break;
    const ImageF &a = video[f + shift], &b = truth[f];
    if (a.data.empty()) continue;
    for (int y = stride / 2; y < b.height; y += stride)
      for (int x = stride / 2; x < b.width; x += stride)
        visit(Eigen::Vector2d(a(x, y, 0), a(x, y, 1)), Eigen::Vector2d(b(x, y, 0), b(x, y, 1)));
  }
}

/// Correlation of the flows in the steps that both have; 0 where either is still.
double correlation(const Flows& video, const Flows& truth, int shift, int stride) {
  double both = 0, ours = 0, theirs = 0;
  for_each_pixel(video, truth, shift, stride, [&](const Eigen::Vector2d& p, const Eigen::Vector2d& t) {
    both += p.dot(t);
    ours += p.squaredNorm();
    theirs += t.squaredNorm();
  });
  return ours > 0 && theirs > 0 ? both / std::sqrt(ours * theirs) : 0;
}

/// Steps by which the video runs late.  At least half of the shorter one is compared.
int delay_of(const Flows& video, const Flows& truth) {
  if (video.empty() || truth.empty()) return 0;
  const int ours = static_cast<int>(video.size()), theirs = static_cast<int>(truth.size()),
            least = (std::min(ours, theirs) + 1) / 2;
  const int stride =
      std::max(1, static_cast<int>(std::sqrt(truth[0].width * static_cast<double>(truth[0].height) / kDelayPixels)));
  const int first = least - theirs, last = ours - least;
  std::vector<double> match;
  for (int shift = first; shift <= last; ++shift) match.push_back(correlation(video, truth, shift, stride));
  const double best = *std::max_element(match.begin(), match.end());
  if (best < kLeastMatch || match[-first] >= kClearlyBetter * best) return 0;
  // What swings regularly matches after each period, too: the shortest of the shifts that are as good.
  int delay = last + theirs;
  for (int shift = first; shift <= last; ++shift) {
    const int i = shift - first;
    const bool peak = (shift == first || match[i] >= match[i - 1]) && (shift == last || match[i] >= match[i + 1]);
    if (peak && match[i] >= kAsGood * best && std::abs(shift) < std::abs(delay)) delay = shift;
  }
  return delay;
}

struct FlowError {
  double error = 0, magnitude = 0, pixels = 0;  ///< sums

  json relative() const { return magnitude > 0 ? json(error / magnitude) : json(); }
};

FlowError error_of(const Flows& video, const Flows& truth, int shift) {
  FlowError out;
  for_each_pixel(video, truth, shift, 1, [&](const Eigen::Vector2d& p, const Eigen::Vector2d& t) {
    if (std::max(p.squaredNorm(), t.squaredNorm()) < kMoves * kMoves) return;
    out.error += (p - t).norm();
    out.magnitude += t.norm();
    ++out.pixels;
  });
  return out;
}

}  // namespace

json compare_flow(const ReferenceVideo& video, const ReferenceVideo& truth) {
  const Flows theirs = flows_in_steps_of(truth, truth), ours = flows_in_steps_of(truth, video);
  const FlowError found = error_of(ours, theirs, 0);
  const int delay = delay_of(ours, theirs);
  return {{"flow_error_px", found.pixels > 0 ? json(found.error / found.pixels) : json()},
          {"flow_in_truth_px", found.pixels > 0 ? json(found.magnitude / found.pixels) : json()},
          {"flow_error", found.relative()},
          {"delay_s", delay / truth.fps},
          {"flow_error_without_delay", error_of(ours, theirs, delay).relative()}};
}

}  // namespace pliant
