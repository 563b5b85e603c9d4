#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/evaluate/evaluate.h"
#include "app/evaluate/metrics.h"
#include "app/store/trajectory.h"
#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/nearest.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

/// Its positions in metres.
TrajectoryFile read_moving(const fs::path& path) {
  std::error_code ignored;
  const fs::path file = fs::is_directory(path, ignored) ? path / "trajectory.h5" : path;
  TrajectoryFile t = read_trajectory(file);
  if (t.frames.size() < 2 || t.frames[0].position.empty()) {
    throw input_error(file.string(), "/particles/" + t.object, "has fewer than 2 frames or no particles",
                      "give a simulated trajectory");
  }
  for (auto& frame : t.frames)
    for (Vec3f& x : frame.position) x *= static_cast<float>(t.metres_per_unit);
  return t;
}

/// A time between two frames.
struct Between {
  const TrajectoryFile::Frame *a, *b;
  double s;  ///< 0 at a, 1 at b
};
Between frames_around(const TrajectoryFile& t, double time) {
  size_t next = 1;
  while (next + 1 < t.frames.size() && t.frames[next].time < time) ++next;
  const TrajectoryFile::Frame &a = t.frames[next - 1], &b = t.frames[next];
  return {&a, &b, std::clamp((time - a.time) / (b.time - a.time), 0.0, 1.0)};
}

/// Displacement of particle `p` since frame 0, linear between frames.
Vec3d displacement(const TrajectoryFile& t, const Between& at, size_t p) {
  const Vec3d x = (1 - at.s) * at.a->position[p].cast<double>() + at.s * at.b->position[p].cast<double>();
  return x - t.frames[0].position[p].cast<double>();
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

/// The tenth of the true particles that is highest, or that moves most when up is unknown.
std::vector<size_t> tip_of(const TrajectoryFile& truth) {
  const size_t n = truth.frames[0].position.size();
  std::vector<double> rank(n, 0.0);
  for (size_t p = 0; p < n; ++p) {
    if (!truth.up.isZero()) {
      rank[p] = truth.up.dot(truth.frames[0].position[p].cast<double>());
    } else {
      for (const auto& frame : truth.frames)
        rank[p] = std::max<double>(rank[p], (frame.position[p] - truth.frames[0].position[p]).norm());
    }
  }
  std::vector<size_t> order(n);
  for (size_t p = 0; p < n; ++p) order[p] = p;
  std::sort(order.begin(), order.end(),
            [&](size_t a, size_t b) { return rank[a] != rank[b] ? rank[a] > rank[b] : a < b; });
  order.resize(std::max<size_t>(1, n / 10));
  return order;
}

/// Unit direction in which the displacements vary most.
Vec3d main_direction(const std::vector<Vec3d>& displacement) {
  Mat3d second = Mat3d::Zero();
  for (const Vec3d& u : displacement) second += u * u.transpose();
  return symmetric_eigen3(second).vectors.col(2);
}

/// Numbers about the motion of a tip; displacements relative to the height.  Frequencies from frame `first` on.
json describe_tip(const std::vector<Vec3d>& tip, const Vec3d& direction, double rate, size_t first) {
  json over_time = json::array();
  double peak = 0;
  size_t peak_frame = 0;
  std::vector<double> along;
  for (size_t i = 0; i < tip.size(); ++i) {
    over_time.push_back(tip[i].norm());
    if (tip[i].norm() > peak) {
      peak = tip[i].norm();
      peak_frame = i;
    }
    if (i >= first) along.push_back(direction.dot(tip[i]));
  }
  json out = {{"peak", peak},
              {"peak_frame", peak_frame},
              {"final", tip.back().norm()},
              {"displacement", over_time},
              {"dominant_frequency", dominant_frequency(along, rate)},
              {"zero_crossing_frequency", zero_crossing_frequency(along, rate)}};
  out["final_over_peak"] = peak > 0 ? json(tip.back().norm() / peak) : json(nullptr);
  return out;
}

}  // namespace

json evaluate_trajectory(const fs::path& prediction, const fs::path& truth_path) {
  const TrajectoryFile ours = read_moving(prediction), truth = read_moving(truth_path);
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
    const Between our_frames = frames_around(ours, time), true_frames = frames_around(truth, time);
    for (size_t p = 0; p < rest.size(); ++p) {
      our_move[p] = displacement(ours, our_frames, static_cast<size_t>(partner[p])) / height;
      true_move[p] = displacement(truth, true_frames, p) / height;
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
  // The oscillation is free after the peak, unless the peak is so late that little is left.
  size_t first = 0;
  for (size_t i = 0; i < true_tip.size(); ++i) {
    if (true_tip[i].norm() > true_tip[first].norm()) first = i;
  }
  if (2 * first > true_tip.size()) first = 0;
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
              {"height", height / truth.metres_per_unit},
              {"height_metres", height},
              {"position_error_mean", sum / samples},
              {"position_error_rms", std::sqrt(squares / samples)},
              {"position_error_max", largest},
              {"error_of_frame", error_of_frame},
              {"tip_error_mean", tip_error},
              {"tip", describe_tip(our_tip, direction, rate, first)},
              {"tip_in_truth", describe_tip(true_tip, direction, rate, first)}};
  out["relative_error"] = moved > 0 ? json(std::sqrt(squares / moved)) : json(nullptr);
  const double f = out["tip"]["dominant_frequency"], f_true = out["tip_in_truth"]["dominant_frequency"];
  out["frequency_error"] = f_true > 0 ? json(std::abs(f - f_true) / f_true) : json(nullptr);
  const double peak = out["tip"]["peak"], peak_true = out["tip_in_truth"]["peak"];
  out["peak_error"] = peak_true > 0 ? json(std::abs(peak - peak_true) / peak_true) : json(nullptr);
  return out;
}

}  // namespace pliant
