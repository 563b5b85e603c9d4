#include "fitting/objective/clip_objective.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/vision/optical_flow.h"

namespace pliant {
namespace {

constexpr int kBorder = 6;          // px, half a window of SSIM
constexpr double kRoundTrip = 0.5;  // px off, at which a flow counts exp(-1/2)

/// Whether every frame has a weight of its own.
bool weighs_each(const SeenFrames<float>& seen) { return seen.weight.size() > 1; }

SeenFrames<float> on_rollout(const SeenFrames<float>& seen, const ClipFrames& frames) {
  SeenFrames<float> out;
  out.camera = seen.camera;
  out.frame = seen.frame;
  out.frames.resize(frames.count());
  out.weight = seen.weight;
  if (weighs_each(seen)) out.weight.assign(frames.count(), {});
  for (int f = frames.first; f <= frames.last; ++f) {
    out.frames[frames.of(f)] = seen.frames.at(f);
    if (weighs_each(seen)) out.weight[frames.of(f)] = seen.weight.at(f);
  }
  return out;
}

bool counts(const ImageF& weight) {
  return std::ranges::any_of(weight.data, [](float w) { return w > 0; });
}

ImageF cut(const ImageF& from, int x0, int y0, int width, int height) {
  ImageF part(width, height, from.channels);
  for (int y = 0; y < height; ++y)
    std::copy_n(&from.data[(static_cast<size_t>(y0 + y) * from.width + x0) * from.channels], width * from.channels,
                &part.data[static_cast<size_t>(y) * width * from.channels]);
  return part;
}

}  // namespace

SeenFrames<float> cut_to_weight(const Camera& camera, std::span<const ImageF> frames, std::span<const ImageF> weight) {
  CHECK(weight.size() == 1 || (weight.size() == frames.size() && !frames.empty()));
  const int width = weight[0].width, height = weight[0].height;
  int x0 = width, y0 = height, x1 = 0, y1 = 0;
  for (const ImageF& w : weight) {
    CHECK(w.width == width && w.height == height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        if (w(x, y) > 0) {
          x0 = std::min(x0, x);
          y0 = std::min(y0, y);
          x1 = std::max(x1, x + 1);
          y1 = std::max(y1, y + 1);
        }
  }
  if (x1 <= x0)
    throw input_error("fit", "video", "shows no motion that is compared",
                      "check the camera of the video, what is pinned, and --video-mask");
  x0 = std::max(0, x0 - kBorder);
  y0 = std::max(0, y0 - kBorder);
  x1 = std::min(width, x1 + kBorder);
  y1 = std::min(height, y1 + kBorder);
  SeenFrames<float> out;
  const PicturePart part = cropped(camera, x0, y0, x1 - x0, y1 - y0);
  out.camera = part.camera;
  out.frame = part.frame;
  for (const ImageF& w : weight) out.weight.push_back(cut(w, x0, y0, x1 - x0, y1 - y0));
  for (size_t f = 0; f < frames.size(); ++f)
    out.frames.push_back(counts(weight[weight.size() == 1 ? 0 : f]) ? cut(frames[f], x0, y0, x1 - x0, y1 - y0)
                                                                    : ImageF());
  return out;
}

SeenFlow<float> flow_of_clip(const SeenFrames<float>& seen, const ClipFrames& frames) {
  std::vector<std::pair<int, int>> pairs;
  for (int f = frames.first; f < frames.last; ++f) {
    if (seen.frames[f].empty() || seen.frames[f + 1].empty()) continue;
    pairs.push_back({f, f + 1});
    pairs.push_back({f + 1, f});
  }
  std::vector<ImageF> flows = dense_flows(seen.frames, pairs);
  SeenFlow<float> out;
  out.camera = seen.camera;
  out.frame = seen.frame;
  for (size_t k = 0; k < flows.size(); k += 2) {
    const int f = pairs[k].first;
    const ImageF& back = flows[k + 1];
    auto& pair = out.pairs.emplace_back();
    pair.from = frames.of(f);
    pair.to = frames.of(f + 1);
    pair.flow = std::move(flows[k]);
    pair.weight = seen.weight.empty() ? ImageF(seen.camera.width, seen.camera.height, 1, 1.0f)
                                      : seen.weight[weighs_each(seen) ? f : 0];
    const ImageF* later = weighs_each(seen) ? &seen.weight[f + 1] : nullptr;
    for (int y = 0; y < seen.camera.height; ++y)
      for (int x = 0; x < seen.camera.width; ++x) {
        const float u = pair.flow(x, y, 0), v = pair.flow(x, y, 1);
        if (later)
          pair.weight(x, y) =
              std::min({pair.weight(x, y), (*later)(x, y), sample(*later, x + 0.5 + u, y + 0.5 + v, 0)});
        const double du = u + sample(back, x + 0.5 + u, y + 0.5 + v, 0),
                     dv = v + sample(back, x + 0.5 + u, y + 0.5 + v, 1);
        pair.weight(x, y) *= static_cast<float>(std::exp(-0.5 * (du * du + dv * dv) / (kRoundTrip * kRoundTrip)));
      }
  }
  return out;
}

Objective<float> clip_objective(const ClipTerms& terms, const TrackLoss<float>* tracks, const ClipFrames& frames) {
  Objective<float> objective;
  if (tracks && terms.track_weight > 0)
    objective.terms.push_back({terms.track_weight, std::make_shared<TrackLoss<float>>(tracks->on_rollout(
                                                       frames.first, frames.last, frames.lead, frames.every))});
  const double cameras = static_cast<double>(terms.seen.size());
  for (const SeenFrames<float>& seen : terms.seen) {
    if (terms.picture_weight > 0)
      objective.terms.push_back(
          {terms.picture_weight / cameras,
           std::make_shared<PictureLoss<float>>(terms.picture, terms.drawn, on_rollout(seen, frames))});
    if (terms.flow_weight > 0)
      objective.whole.push_back(
          {terms.flow_weight / cameras,
           std::make_shared<FlowLoss<float>>(terms.drawn, flow_of_clip(seen, frames), terms.flow_outlier)});
  }
  if (terms.guide && terms.guide_weight > 0)
    objective.whole.push_back({terms.guide_weight, std::make_shared<GuidanceLoss>(
                                                       terms.guide, terms.drawn, terms.guide_camera,
                                                       GuidanceLoss::Frames{frames.lead, frames.every, frames.fps})});
  return objective;
}

}  // namespace pliant
