#include "fitting/observe/track_pixels.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"

namespace pliant {
namespace {

using Eigen::Matrix2d, Eigen::Vector2d;

Vector2d flow_at(const ImageF& flow, const Vector2d& p) {
  return {sample(flow, p.x(), p.y(), 0), sample(flow, p.x(), p.y(), 1)};
}

/// The affine map nearest to the flow around p.
PatchWarp warp_of_flow(const ImageF& flow, const Vector2d& p, int radius) {
  PatchWarp warp;
  warp.position = p + flow_at(flow, p);
  const double r = 0.5 * radius;
  warp.linear.col(0) += (flow_at(flow, p + Vector2d(r, 0)) - flow_at(flow, p - Vector2d(r, 0))) / (2 * r);
  warp.linear.col(1) += (flow_at(flow, p + Vector2d(0, r)) - flow_at(flow, p - Vector2d(0, r))) / (2 * r);
  const double size = warp.linear.determinant();
  if (!(size > 0.4 && size < 2.5)) warp.linear.setIdentity();
  return warp;
}

bool sound(const PatchFit& fit) {
  const double size = fit.warp.linear.determinant();
  return fit.inside && fit.warp.position.allFinite() && size > 0.25 && size < 4;
}

constexpr double kBlockBytes = 1.5e8;  // of what is made ahead of the frames that are followed

/// What following frames `begin` to `end` needs and no frame owes to the one before: made side by side.
struct Block {
  size_t begin;
  std::vector<ImageF> flow;  // from the frame before to each, and back
  std::vector<std::unique_ptr<GradientPicture>> picture;

  Block(std::span<const ImageF> video, size_t begin, size_t end, FlowQuality quality) : begin(begin) {
    std::vector<std::pair<int, int>> pairs;
    for (int t = static_cast<int>(begin); t < static_cast<int>(end); ++t) {
      pairs.push_back({t - 1, t});
      pairs.push_back({t, t - 1});
    }
    flow = dense_flows(video, pairs, quality);
    picture.resize(end - begin);
    parallel_for(static_cast<std::ptrdiff_t>(picture.size()),
                 [&](std::ptrdiff_t i) { picture[i] = std::make_unique<GradientPicture>(video[begin + i]); });
  }
  const ImageF& forward(size_t t) const { return flow[2 * (t - begin)]; }
  const ImageF& backward(size_t t) const { return flow[2 * (t - begin) + 1]; }
};

/// Frames of a block: as many as the memory allows.
size_t block_length(const ImageF& frame) {
  const double of_frame = static_cast<double>(frame.pixels()) * sizeof(float) * (9 + 2 * 2);
  return static_cast<size_t>(std::clamp(kBlockBytes / of_frame, 1.0, 16.0));
}

double smooth_step(double low, double high, double x) {
  const double s = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

}  // namespace

PixelTracks track_pixels(const TrackOptions& options, std::span<const ImageF> video, std::span<const Vector2d> points,
                         const ImageU8& object) {
  const size_t frames = video.size(), count = points.size();
  CHECK(frames > 0 && options.look_again > 0);
  CHECK(object.empty() || (object.width == video[0].width && object.height == video[0].height && object.channels == 1));
  PixelTracks tracks;
  tracks.pixel.assign(frames, std::vector<Vector2d>(points.begin(), points.end()));
  tracks.weight.assign(frames, std::vector<double>(count, 0.0));
  tracks.sigma.assign(frames, std::vector<double>(count, 0.0));

  const GradientPicture first(video[0]);
  std::vector<Patch> patches;
  std::vector<PatchWarp> last(count);
  for (size_t i = 0; i < count; ++i) {
    patches.emplace_back(options.patch, first, object, points[i]);
    last[i].position = points[i];
    const PatchFit fit = patches[i].align(first, last[i]);
    tracks.sigma[0][i] = fit.sigma;
    tracks.weight[0][i] = fit.inside ? 1 / (1 + std::pow(fit.sigma / options.blur, 2)) : 0;
  }

  const size_t length = block_length(video[0]);
  std::optional<Block> block;
  for (size_t t = 1; t < frames; ++t) {
    if ((t - 1) % length == 0) block.emplace(video, t, std::min(frames, t + length), options.step_flow);
    const int now = static_cast<int>(t);
    const GradientPicture& picture = *block->picture[t - block->begin];
    // From the frame before, with the turn that the patch had there.
    std::vector<PatchWarp> chained(count);
    std::vector<PatchFit> best(count);
    parallel_for(static_cast<std::ptrdiff_t>(count), [&](std::ptrdiff_t i) {
      chained[i] = {last[i].position + flow_at(block->forward(t), last[i].position), last[i].linear};
      best[i] = patches[i].align(picture, chained[i]);
    });

    // From the first frame, which finds what was hidden for a while.
    const auto doubtful = [&](const PatchFit& fit) {
      return !sound(fit) || fit.correlation < options.high_correlation;
    };
    std::vector<ImageF> whole;
    if (now % options.look_again == 0 && std::any_of(best.begin(), best.end(), doubtful)) {
      const std::vector<std::pair<int, int>> pairs = {{0, now}, {now, 0}};
      whole = dense_flows(video, pairs, FlowQuality::kQuick);
      parallel_for(static_cast<std::ptrdiff_t>(count), [&](std::ptrdiff_t i) {
        if (!doubtful(best[i])) return;
        const PatchFit direct = patches[i].align(picture, warp_of_flow(whole[0], points[i], options.patch.radius));
        if (sound(direct) && (!sound(best[i]) || direct.correlation > best[i].correlation)) best[i] = direct;
      });
    }

    for (size_t i = 0; i < count; ++i) {
      if (!sound(best[i])) {
        last[i].position = tracks.pixel[t][i] = chained[i].position;
        tracks.sigma[t][i] = std::numeric_limits<double>::infinity();
        continue;
      }
      const Vector2d p = best[i].warp.position;
      double round_trip = (p + flow_at(block->backward(t), p) - last[i].position).norm();
      if (!whole.empty()) round_trip = std::min(round_trip, (p + flow_at(whole[1], p) - points[i]).norm());
      tracks.weight[t][i] = std::exp(-0.5 * std::pow(round_trip / options.round_trip, 2)) *
                            smooth_step(options.low_correlation, options.high_correlation, best[i].correlation) /
                            (1 + std::pow(best[i].sigma / options.blur, 2));
      tracks.pixel[t][i] = p;
      tracks.sigma[t][i] = best[i].sigma;
      last[i] = best[i].warp;
    }
  }
  double sum = 0;
  for (const auto& row : tracks.weight)
    for (const double w : row) sum += w;
  tracks.kept = count > 0 ? sum / static_cast<double>(frames * count) : 0;
  return tracks;
}

}  // namespace pliant
