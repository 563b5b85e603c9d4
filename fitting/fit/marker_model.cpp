#include "fitting/fit/marker_model.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"

namespace pliant {
namespace {

std::vector<double> distances(std::span<const Vec3d> points, std::span<const Vec3f> particles) {
  const NearestPoints tree(particles);
  std::vector<double> out;
  std::vector<NearestPoints::Hit> hits;
  for (const Vec3d& x : points) {
    hits.clear();
    if (x.allFinite()) tree.query(x.cast<float>(), 1, hits);
    out.push_back(hits.empty() ? INFINITY : hits[0].distance);
  }
  return out;
}

std::vector<Vec3f> chosen(std::span<const Vec3d> points, std::span<const int> which) {
  std::vector<Vec3f> out;
  for (const int k : which) out.push_back(points[k].cast<float>());
  return out;
}

std::vector<int> within(std::span<const double> distance, double reach) {
  std::vector<int> out;
  for (size_t k = 0; k < distance.size(); ++k)
    if (distance[k] <= reach) out.push_back(static_cast<int>(k));
  return out;
}

}  // namespace

Vec3d MarkerMotion::at(double time, size_t marker) const {
  if (time <= 0) return Vec3d::Zero();
  const int last = static_cast<int>(displacement.size()) - 1, i = static_cast<int>(std::floor(time * fps));
  const auto y = [&](int k) -> const Vec3d& { return displacement[std::clamp(k, 0, last)][marker]; };
  if (i >= last) return y(last);
  const double f = time * fps - i;
  const Vec3d a = y(i - 1), b = y(i), c = y(i + 1), d = y(i + 2);
  return b + 0.5 * f * ((c - a) + f * ((2 * a - 5 * b + 4 * c - d) + f * (3 * (b - c) + d - a)));
}

MarkerModel::MarkerModel(const MarkerModelOptions& options, const Particles& particles,
                         const std::vector<Interaction>& interactions, std::span<const Vec3d> rest)
    : options_(options),
      particles_(particles),
      interactions_(interactions),
      bound_(within(distances(rest, particles.position), options.reach)),
      distance_(distances(rest, particles.position)),
      rest_(chosen(rest, bound_)),
      points_(rest_, particles.position, 1.0, INFINITY) {}

MarkerMotion MarkerModel::run(const MarkerParameters& parameters, double duration, int substeps) const {
  Particles particles = particles_;
  for (float& young : particles.young) young = static_cast<float>(young * parameters.young_factor);
  SimulateOptions options = options_.simulate;
  options.duration = duration;
  options.substeps = substeps;
  (options_.damping == DampingKind::kKelvinVoigt ? options.viscosity_time : options.damping_time) =
      parameters.damping_time;
  MarkerMotion motion;
  motion.fps = options.fps;
  const auto result =
      simulate<float>(options, particles, interactions_, initial_state(particles), [&](const SimulationState& state) {
        const std::vector<Vec3f> now = points_.positions(state);
        motion.displacement.emplace_back();
        for (size_t k = 0; k < now.size(); ++k)
          motion.displacement.back().push_back((now[k] - rest_[k]).cast<double>());
        return true;
      });
  substeps_ = 0;
  for (const int n : result.summary.substeps_of_frame) substeps_ = std::max(substeps_, n);
  return motion;
}

}  // namespace pliant
