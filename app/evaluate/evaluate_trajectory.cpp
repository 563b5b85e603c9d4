#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "app/evaluate/evaluate.h"
#include "app/evaluate/last_load.h"
#include "app/evaluate/metrics.h"
#include "app/evaluate/vibration.h"
#include "app/store/trajectory.h"
#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/nearest.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

constexpr double kNotable = 0.1;       // of the true travel of the tip, from which on a prediction moves at all
constexpr double kTipMoves = 1.0 / 3;  // of what moves most, that the top moves when it is the tip

/// A trajectory whose unit is the metre.
struct Moving : TrajectoryFile {
  fs::path file;
  double file_unit = 1;  ///< m
};

Moving read_moving(const fs::path& path) {
  std::error_code ignored;
  const fs::path file = fs::is_directory(path, ignored) ? path / "trajectory.h5" : path;
  Moving t;
  static_cast<TrajectoryFile&>(t) = read_trajectory(file);
  if (t.frames.size() < 2 || t.frames[0].position.empty()) {
    throw input_error(file.string(), "/particles/" + t.object, "has fewer than 2 frames or no particles",
                      "give a simulated trajectory");
  }
  for (auto& frame : t.frames)
    for (Vec3f& x : frame.position) x *= static_cast<float>(t.metres_per_unit);
  t.file = file;
  t.file_unit = t.metres_per_unit;
  t.metres_per_unit = 1;
  return t;
}

/// Displacement of particle `p` since frame 0.
Vec3d displacement(const TrajectoryFile& t, const TrajectoryFile::Frame& now, size_t p) {
  return now.position[p].cast<double>() - t.frames[0].position[p].cast<double>();
}

double extent(const std::vector<Vec3f>& position, const Vec3d& direction) {
  double low = INFINITY, high = -INFINITY;
  for (const Vec3f& x : position) {
    const double h = direction.dot(x.cast<double>());
    low = std::min(low, h);
    high = std::max(high, h);
  }
  return high - low;
}

/// The tenth with the highest rank.
std::vector<size_t> top_tenth(const std::vector<double>& rank) {
  std::vector<size_t> order(rank.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](size_t a, size_t b) { return rank[a] != rank[b] ? rank[a] > rank[b] : a < b; });
  order.resize(std::max<size_t>(1, rank.size() / 10));
  return order;
}

/// The tenth of the true particles that is highest; that moves most when up is unknown, or when the highest hardly
/// moves, as what hangs does.
std::vector<size_t> tip_of(const TrajectoryFile& truth) {
  const std::vector<Vec3f>& rest = truth.frames[0].position;
  std::vector<double> height, reach(rest.size(), 0.0);
  for (size_t p = 0; p < rest.size(); ++p) {
    height.push_back(truth.up.dot(rest[p].cast<double>()));
    for (const auto& frame : truth.frames) reach[p] = std::max<double>(reach[p], (frame.position[p] - rest[p]).norm());
  }
  const std::vector<size_t> farthest = top_tenth(reach);
  if (truth.up.isZero()) return farthest;
  const std::vector<size_t> highest = top_tenth(height);
  const auto reach_of = [&](const std::vector<size_t>& tenth) {
    double sum = 0;
    for (const size_t p : tenth) sum += reach[p];
    return sum;
  };
  return reach_of(highest) >= kTipMoves * reach_of(farthest) ? highest : farthest;
}

/// Unit direction in which the displacements vary most.
Vec3d main_direction(const std::vector<Vec3d>& displacement) {
  Mat3d second = Mat3d::Zero();
  for (const Vec3d& u : displacement) second += u * u.transpose();
  return symmetric_eigen3(second).vectors.col(2);
}

size_t largest_of(const std::vector<Vec3d>& displacement) {
  const auto less = [](const Vec3d& a, const Vec3d& b) { return a.norm() < b.norm(); };
  return static_cast<size_t>(std::max_element(displacement.begin(), displacement.end(), less) - displacement.begin());
}

/// The largest distance from where the tip is in frame `first` that it has in a later one.
double travel(const std::vector<Vec3d>& tip, size_t first) {
  double farthest = 0;
  for (size_t i = first; i < tip.size(); ++i) farthest = std::max(farthest, (tip[i] - tip[first]).norm());
  return farthest;
}

/// Numbers about the motion of a tip; displacements relative to the height.  Frequencies from frame `first` on, null
/// where nothing oscillates.
json describe_tip(const std::vector<Vec3d>& tip, const Vec3d& direction, double rate, size_t first) {
  json over_time = json::array();
  const size_t peak_frame = largest_of(tip);
  const double peak = tip[peak_frame].norm();
  std::vector<double> along;
  for (size_t i = 0; i < tip.size(); ++i) {
    over_time.push_back(tip[i].norm());
    if (i >= first) along.push_back(direction.dot(tip[i]));
  }
  json out = {{"peak", peak},
              {"peak_frame", peak_frame},
              {"final", tip.back().norm()},
              {"displacement", over_time},
              {"zero_crossing_frequency", zero_crossing_frequency(along, rate)}};
  const DampedOscillation swing = fit_oscillation(along, rate);
  out["dominant_frequency"] = swing.frequency > 0 ? json(swing.frequency) : json(nullptr);
  if (swing.slower_than > 0) out["frequency_below"] = swing.slower_than;
  out["final_over_peak"] = peak > 0 ? json(tip.back().norm() / peak) : json(nullptr);
  return out;
}

}  // namespace

json evaluate_trajectory(const fs::path& prediction, const fs::path& truth_path) {
  const Moving ours = read_moving(prediction);
  Moving truth = read_moving(truth_path);
  if (truth.up.isZero()) truth.up = ours.up;
  const std::vector<Vec3f>& rest = truth.frames[0].position;
  double height = truth.up.isZero() ? 0.0 : extent(rest, truth.up);
  if (truth.up.isZero()) {
    for (int axis = 0; axis < 3; ++axis) height = std::max(height, extent(rest, Vec3d::Unit(axis)));
  }
  if (!(height > 0))
    throw input_error(truth_path.string(), "/particles/" + truth.object, "has no extent", "give an object");
  std::vector<double> times;
  for (const auto& frame : truth.frames) {
    if (frame.time <= ours.frames.back().time * (1 + 1e-9)) times.push_back(frame.time);
  }
  if (times.size() < 2)
    throw input_error(prediction.string(), "time", "does not overlap with the truth", "simulate a longer time");

  const std::vector<int> partner = k_nearest(ours.frames[0].position, rest, 1);
  const std::vector<size_t> tip = tip_of(truth);
  std::vector<Vec3d> our_tip, true_tip;
  std::vector<double> error_of_frame;
  double sum = 0, squares = 0, moved = 0, largest = 0;
  for (double time : times) {
    double frame_sum = 0;
    std::vector<Vec3d> our_move(rest.size()), true_move(rest.size());
    const TrajectoryFile::Frame our_frame = ours.at(time), true_frame = truth.at(time);
    for (size_t p = 0; p < rest.size(); ++p) {
      our_move[p] = displacement(ours, our_frame, static_cast<size_t>(partner[p])) / height;
      true_move[p] = displacement(truth, true_frame, p) / height;
      const double error = (our_move[p] - true_move[p]).norm();
      frame_sum += error;
      squares += error * error;
      moved += true_move[p].squaredNorm();
      largest = std::max(largest, error);
    }
    sum += frame_sum;
    error_of_frame.push_back(frame_sum / static_cast<double>(rest.size()));
    our_tip.push_back(Vec3d::Zero());
    true_tip.push_back(Vec3d::Zero());
    for (size_t p : tip) {
      our_tip.back() += our_move[p] / static_cast<double>(tip.size());
      true_tip.back() += true_move[p] / static_cast<double>(tip.size());
    }
  }
  const size_t peak_frame = largest_of(true_tip);
  // The oscillation is free after the end of all loads; where that is unknown after the peak, unless it is so late that
  // little is left.
  size_t first = 2 * peak_frame > true_tip.size() ? 0 : peak_frame;
  const char* free_from_by = "largest motion";
  const double end = std::min(ours.frames.back().time, truth.frames.back().time);  // of the time both have
  const std::optional<double> our_release = release_of(ours.file, ours, end),
                              true_release = release_of(truth.file, truth, end);
  if (our_release || true_release) {
    const double release = times.front() + std::max(our_release.value_or(0), true_release.value_or(0));
    const auto from = static_cast<size_t>(std::lower_bound(times.begin(), times.end(), release - 1e-9) - times.begin());
    if (from + kLeastFree <= times.size()) {
      first = from;
      free_from_by = "interactions.json";
    }
  }
  const double rate = static_cast<double>(times.size() - 1) / (times.back() - times.front());
  const Vec3d direction = main_direction(true_tip);
  const auto samples = static_cast<double>(rest.size() * times.size());
  double tip_error = 0;
  for (size_t i = 0; i < times.size(); ++i)
    tip_error += (our_tip[i] - true_tip[i]).norm() / static_cast<double>(times.size());

  json out = {{"kind", "trajectory"},
              {"frames", times.size()},
              {"frames_in_truth", truth.frames.size()},
              {"particles", ours.frames[0].position.size()},
              {"particles_in_truth", rest.size()},
              {"height", height / truth.file_unit},
              {"height_metres", height},
              {"position_error_mean", sum / samples},
              {"position_error_rms", std::sqrt(squares / samples)},
              {"position_error_max", largest},
              {"error_of_frame", error_of_frame},
              {"tip_error_mean", tip_error},
              {"free_from_s", times[first] - times.front()},
              {"free_from_by", free_from_by},
              {"tip", describe_tip(our_tip, direction, rate, first)},
              {"tip_in_truth", describe_tip(true_tip, direction, rate, first)}};
  out["relative_error"] = moved > 0 ? json(std::sqrt(squares / moved)) : json(nullptr);
  // What may swing too slowly for the record is at least as wrong as its slowest frequency, if it moves notably, and
  // what does not oscillate where the truth does is as wrong as frequency 0.
  const json &f = out["tip"]["dominant_frequency"], &f_true = out["tip_in_truth"]["dominant_frequency"];
  const bool moves = travel(our_tip, first) > kNotable * travel(true_tip, first);
  const double known = f.is_number() ? f.get<double>() : moves ? out["tip"].value("frequency_below", 0.0) : 0.0;
  out["frequency_error"] = f_true.is_number() ? json(std::abs(known / f_true.get<double>() - 1)) : json(nullptr);
  const double peak = out["tip"]["peak"], peak_true = out["tip_in_truth"]["peak"];
  out["peak_error"] = peak_true > 0 ? json(std::abs(peak - peak_true) / peak_true) : json(nullptr);
  return out;
}

}  // namespace pliant
