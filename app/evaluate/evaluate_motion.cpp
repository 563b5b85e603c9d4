#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/evaluate/clip.h"
#include "app/evaluate/evaluate.h"
#include "app/evaluate/flow_comparison.h"
#include "app/evaluate/last_load.h"
#include "app/evaluate/vibration.h"
#include "app/store/trajectory.h"
#include "fitting/observe/track_pixels.h"
#include "gaussians/base/error.h"
#include "gaussians/base/quantile.h"
#include "gaussians/vision/optical_flow.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

constexpr double kLeastMotion = 0.3;           // px, below which a video shows nothing that moves
constexpr int kMostPoints = 120, kRadius = 8;  // points that are followed, and px of their patches

bool is_trajectory(const fs::path& path) {
  std::error_code ignored;
  return path.extension() == ".h5" || fs::exists(path / "trajectory.h5", ignored);
}

std::vector<ImageF> flows_from_first(const ReferenceVideo& video, int count) {
  std::vector<std::pair<int, int>> pairs;
  const int frames = static_cast<int>(video.frames.size());
  for (int k = 1; k <= count; ++k)
    pairs.push_back({0, static_cast<int>(std::lround(static_cast<double>(k) * (frames - 1) / count))});
  return dense_flows(video.frames, pairs);
}

/// [H, W, 1] where the video moves: pixels of the first frame that get at least a tenth as far as what gets farthest.
ImageU8 moving_region(const ReferenceVideo& video) {
  const ImageF& first = video.frames[0];
  ImageF reach(first.width, first.height, 1);
  for (const ImageF& flow : flows_from_first(video, std::min<int>(12, static_cast<int>(video.frames.size()) - 1)))
    for (int y = 0; y < reach.height; ++y)
      for (int x = 0; x < reach.width; ++x)
        reach(x, y) = std::max(reach(x, y), std::hypot(flow(x, y, 0), flow(x, y, 1)));
  const float limit = std::max(static_cast<float>(kLeastMotion), 0.1f * quantile(reach.data, 0.995));
  ImageU8 mask(first.width, first.height, 1);
  for (size_t i = 0; i < mask.data.size(); ++i) mask.data[i] = reach.data[i] > limit ? 255 : 0;
  return mask;
}

/// Points of the moving region followed through the video; none when nothing moves.
PointMotion follow(const ReferenceVideo& video, const ImageU8& region) {
  const auto inside = static_cast<double>(std::count(region.data.begin(), region.data.end(), 255));
  PointMotion motion;
  motion.rate = video.fps;
  if (inside < 20) return motion;
  const double step = std::max(2.0, std::sqrt(inside / kMostPoints));
  std::vector<Eigen::Vector2d> points;
  for (double y = step / 2; y < region.height; y += step)
    for (double x = step / 2; x < region.width; x += step)
      if (region(static_cast<int>(x), static_cast<int>(y)) != 0) points.push_back({x, y});
  TrackOptions options;
  options.patch.radius = kRadius;
  // The patches find what quick flow leaves, and few points are lost for long.
  options.step_flow = FlowQuality::kQuick;
  options.look_again = 2;
  const PixelTracks tracks = track_pixels(options, video, points, region);
  // A point counts by the frame in which it is seen worst; without any such, by the mean.
  std::vector<size_t> kept;
  std::vector<double> weight;
  for (const bool strict : {true, false}) {
    for (size_t k = 0; k < points.size(); ++k) {
      double least = 1, mean = 0;
      for (const auto& frame : tracks.weight) {
        least = std::min(least, frame[k]);
        mean += frame[k] / static_cast<double>(tracks.weight.size());
      }
      const double w = strict ? least : mean;
      if (w > (strict ? 0.05 : 0.2)) {
        kept.push_back(k);
        weight.push_back(w);
      }
    }
    if (kept.size() >= 10) break;
    if (strict) {
      kept.clear();
      weight.clear();
    }
  }
  motion.weight = weight;
  for (const auto& frame : tracks.pixel) {
    motion.displacement.emplace_back();
    for (const size_t k : kept) {
      const Eigen::Vector2d d = frame[k] - points[k];
      motion.displacement.back().push_back(d.x());
      motion.displacement.back().push_back(d.y());
    }
  }
  return motion;
}

/// A trajectory, cut to the time that another one has too.
struct Simulated {
  fs::path file;
  TrajectoryFile trajectory;

  explicit Simulated(const fs::path& path) {
    std::error_code ignored;
    file = fs::is_directory(path, ignored) ? path / "trajectory.h5" : path;
    trajectory = read_trajectory(file);
    if (trajectory.frames.size() < 2 || trajectory.frames[0].position.empty())
      throw input_error(file.string(), "/particles/" + trajectory.object, "has fewer than 2 frames or no particles",
                        "give a simulated trajectory");
  }
  double duration() const { return trajectory.frames.back().time - trajectory.frames.front().time; }
  /// `duration`: s from the first frame.
  void cut(double duration) {
    auto& frames = trajectory.frames;
    const double end = frames.front().time + duration * (1 + 1e-9);
    while (frames.back().time > end) frames.pop_back();
    if (frames.size() < 2)
      throw input_error(file.string(), "time", "has fewer than 2 frames in the time that both trajectories have",
                        "simulate a longer time");
  }
  std::optional<double> release(double duration) const {
    return release_of(file, trajectory, trajectory.frames.front().time + duration);
  }
};

/// Displacements of the particles of a trajectory from its first frame in m.
PointMotion particles_of(const TrajectoryFile& t) {
  PointMotion motion;
  motion.dims = 3;
  motion.rate = static_cast<double>(t.frames.size() - 1) / (t.frames.back().time - t.frames.front().time);
  const size_t n = t.frames[0].position.size(), step = std::max<size_t>(1, n / 2000);
  for (const auto& frame : t.frames) {
    motion.displacement.emplace_back();
    for (size_t p = 0; p < n; p += step)
      for (int a = 0; a < 3; ++a)
        motion.displacement.back().push_back(t.metres_per_unit * (frame.position[p][a] - t.frames[0].position[p][a]));
  }
  motion.weight.assign(motion.displacement[0].size() / 3, 1.0);
  return motion;
}

json to_json(const PointMotion& motion, const Vibration& v, const char* unit) {
  const DampedOscillation& o = v.oscillation;
  const bool found = o.frequency > 0;
  json out = {{"fps", motion.rate},
              {"frames", motion.frames()},
              {"points", motion.points()},
              {std::string("amplitude_") + unit, v.amplitude},
              {"first_component_share", v.share}};
  out["frequency_hz"] = found ? json(o.frequency) : json();
  out["decay_per_s"] = found ? json(o.decay) : json();
  out["damping_time_s"] = found && o.decay > 0 ? json(1 / o.decay) : json();
  out["log_decrement"] = found ? json(o.decay / o.frequency) : json();
  out["explained"] = o.explained;
  out["frequency_small_hz"] = v.small.frequency > 0 ? json(v.small.frequency) : json();
  return out;
}

/// |a / b - 1|, or null where either is unknown.
json relative_error(const json& a, const json& b) {
  if (!a.is_number() || !b.is_number() || b.get<double>() == 0) return nullptr;
  return std::abs(a.get<double>() / b.get<double>() - 1);
}

}  // namespace

json evaluate_motion(const fs::path& prediction, const fs::path& truth_path, const MotionScore& score) {
  const bool particles = is_trajectory(truth_path);
  if (particles != is_trajectory(prediction))
    throw input_error(prediction.string(), "", "and the truth are a video and a trajectory",
                      "compare two videos or two trajectory.h5");
  json out = {{"kind", "motion"}, {"warnings", json::array()}};
  PointMotion ours, truth;
  std::optional<double> our_release, true_release;
  if (particles) {
    const auto refuse = [&](const char* option, double value, double usual) {
      if (value != usual)
        throw usage_error("evaluate", option, "does nothing for trajectories, which have their own times",
                          "leave it out");
    };
    refuse("--fps", score.fps, MotionScore().fps);
    refuse("--from", score.from, MotionScore().from);
    refuse("--until", score.until, MotionScore().until);
    Simulated predicted(prediction), simulated(truth_path);
    const double duration = std::min(predicted.duration(), simulated.duration());
    for (Simulated* each : {&predicted, &simulated}) each->cut(duration);
    our_release = predicted.release(duration);
    true_release = simulated.release(duration);
    ours = particles_of(predicted.trajectory);
    truth = particles_of(simulated.trajectory);
  } else {
    // Each at its own rate: what moves fast is doubled in frames that are blends of two, and lost to tracking.
    const fs::path both[] = {prediction, truth_path};
    check_fps(score, both);
    const ClipSize compared = compared_size(truth_path, score);
    const ReferenceVideo true_video = read_clip(truth_path, score, 0, compared.camera);
    const ReferenceVideo video = read_clip(prediction, score, 0, compared.camera);
    truth = follow(true_video, moving_region(true_video));
    ours = follow(video, moving_region(video));
    out["fps"] = true_video.fps;
    out["width"] = compared.camera.width;
    out["height"] = compared.camera.height;
    for (const auto& warnings : {compared.warnings, true_video.warnings, video.warnings})
      for (const std::string& warning : warnings) out["warnings"].push_back(warning);
    if (const std::string scaled = other_size(prediction, score, compared); !scaled.empty())
      out["warnings"].push_back(scaled);
    out.update(compare_flow(video, true_video));
  }
  const char* unit = particles ? "m" : "px";
  if (truth.points() == 0)
    throw input_error(truth_path.string(), "", "shows no motion", "check the file and the compared interval");
  int first = -1, our_first = -1;  // frames from which on the motion is free
  out["free_from_by"] = "largest motion";
  if (score.free_from >= 0) {
    const auto check = [&](const PointMotion& motion, const char* name) {
      const double last = (static_cast<double>(motion.frames()) - static_cast<double>(kLeastFree)) / motion.rate;
      if (score.free_from > last + 1e-6)
        throw usage_error("evaluate", "--free-from",
                          fmt::format("is {} s, of a {} that lasts {:.4g} s", score.free_from, name,
                                      static_cast<double>(motion.frames()) / motion.rate),
                          last >= 0 ? fmt::format("give at most {:.4g}: the fit needs {} frames", last, kLeastFree)
                                    : fmt::format("the fit needs {} frames: give a longer clip", kLeastFree));
    };
    if (ours.points() > 0) check(ours, "prediction");
    check(truth, "truth");
    first = static_cast<int>(std::lround(score.free_from * truth.rate));
    out["free_from_by"] = "--free-from";
  } else if (our_release || true_release) {
    const double release = std::max(our_release.value_or(0), true_release.value_or(0));
    const auto begin = [&](const PointMotion& motion) {
      return static_cast<size_t>(std::ceil(release * motion.rate - 1e-6));
    };
    if (begin(truth) + kLeastFree <= truth.frames() && begin(ours) + kLeastFree <= ours.frames()) {
      first = static_cast<int>(begin(truth));
      our_first = static_cast<int>(begin(ours));
      out["free_from_by"] = "interactions.json";
    }
  }
  const Vibration true_vibration = describe_vibration(truth, first);
  if (particles ? !(true_vibration.amplitude > 0) : true_vibration.amplitude < kLeastMotion)
    throw input_error(truth_path.string(), "", "shows no motion", "check the file and the compared interval");
  out["free_from_s"] = first / truth.rate;
  out["truth"] = to_json(truth, true_vibration, unit);
  Vibration vibration;
  if (ours.points() > 0) {
    if (our_first < 0) {
      const double free_from = score.free_from >= 0 ? score.free_from : first / truth.rate;
      our_first = static_cast<int>(std::lround(free_from * ours.rate));
    }
    vibration = describe_vibration(ours, our_first);
  }
  if (!particles && vibration.amplitude < kLeastMotion) vibration.oscillation = vibration.small = {};
  out["prediction"] = to_json(ours, vibration, unit);
  const std::string amplitude = std::string("amplitude_") + unit;
  out["frequency_error"] = relative_error(out["prediction"]["frequency_hz"], out["truth"]["frequency_hz"]);
  out["damping_error"] = relative_error(out["prediction"]["decay_per_s"], out["truth"]["decay_per_s"]);
  out["amplitude_error"] = relative_error(out["prediction"][amplitude], out["truth"][amplitude]);
  return out;
}

}  // namespace pliant
