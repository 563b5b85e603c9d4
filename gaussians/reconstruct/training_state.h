#pragma once

#include <span>
#include <string>
#include <vector>

#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

/// First and second moments of Adam for one array, of the array's shape.
struct Moments {
  std::vector<float> first, second;
  void resize(size_t n) {
    first.resize(n, 0.0f);
    second.resize(n, 0.0f);
  }
};

/// Quality on the held-out photos at some point of a training.
struct CurvePoint {
  int iteration = 0;
  double seconds = 0;
  size_t gaussians = 0;
  double psnr = 0, ssim = 0;  ///< means over held-out photos, at most kMostInCurve
};

/// Everything that a training goes on from.
struct TrainingState {
  int iteration = 0;
  double seconds = 0;       ///< wall time spent
  size_t started_with = 0;  ///< Gaussians at iteration 0
  GaussianCloud cloud;
  std::vector<float> attribute;  ///< [N, A] of an AttributeTerm; empty without one
  std::vector<float> shared;     ///< what the term shares among all views
  std::vector<float> exposure;   ///< [photos, 3, 4] see exposure.h; empty unless trained
  Moments position, rotation, log_scale, opacity_logit, sh, attribute_moments, shared_moments, exposure_moments;
  std::vector<float> screen_gradient;  ///< [N] sum of |dL/d(u, v)| in half image sizes since the last densification ...
  std::vector<float> times_seen;       ///< [N] ... over so many pictures; both empty unless the strategy needs them
  std::vector<CurvePoint> curve;

  int attribute_channels() const { return cloud.size() == 0 ? 0 : static_cast<int>(attribute.size() / cloud.size()); }
};

/// The numbers of an array of small vectors.
template <class Vector>
std::span<float> flat(std::vector<Vector>& rows) {
  return {reinterpret_cast<float*>(rows.data()), rows.size() * sizeof(Vector) / sizeof(float)};
}
template <class Vector>
std::span<const float> flat(const std::vector<Vector>& rows) {
  return {reinterpret_cast<const float*>(rows.data()), rows.size() * sizeof(Vector) / sizeof(float)};
}

/// Calls visit(name, array) for every array with one row per Gaussian; arrays of an unused part are empty.
template <class State, class Visit>
void visit_gaussian_arrays(State& s, Visit&& visit) {
  visit("position", s.cloud.position);
  visit("rotation", s.cloud.rotation);
  visit("log_scale", s.cloud.log_scale);
  visit("opacity_logit", s.cloud.opacity_logit);
  visit("sh", s.cloud.sh);
  visit("attribute", s.attribute);
  const auto moments = [&](const std::string& name, auto& of) {
    visit(name + "_first", of.first);
    visit(name + "_second", of.second);
  };
  moments("position", s.position);
  moments("rotation", s.rotation);
  moments("log_scale", s.log_scale);
  moments("opacity_logit", s.opacity_logit);
  moments("sh", s.sh);
  moments("attribute", s.attribute_moments);
  visit("screen_gradient", s.screen_gradient);
  visit("times_seen", s.times_seen);
}

/// Gives the moments the sizes of their arrays; new ones are zero.
void fit_moments(TrainingState& state);

/// Keeps the Gaussians at `indices`, in that order, with all that belongs to them.  One that is named twice is copied.
void keep_gaussians(TrainingState& state, std::span<const int> indices);

/// Row `to` becomes a copy of row `from`.
void copy_gaussian(TrainingState& state, size_t from, size_t to);

/// Forgets what Adam knows about a Gaussian.
void clear_moments(TrainingState& state, size_t i);

/// Raises the degree of the spherical harmonics; new coefficients and their moments are zero.
void raise_sh_degree(TrainingState& state, int degree);

}  // namespace pliant
