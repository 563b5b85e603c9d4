#include "fitting/modal/start_shapes.h"

#include <algorithm>
#include <cmath>

#include "fitting/fields/smooth_field.h"
#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"

namespace pliant {
namespace {

std::vector<double> at_time(const ModalMotion& motion, double t, bool velocity) {
  std::vector<double> out;
  for (size_t k = 0; k < motion.omega.size(); ++k)
    out.push_back(velocity ? motion.velocity(k, t) : motion.displacement(k, t));
  return out;
}

}  // namespace

StartShapes StartShapes::of_modes(const VibrationModes& modes, const ModalMotion& motion, const Particles& particles,
                                  int most) {
  std::vector<std::pair<double, size_t>> strength;
  std::vector<double> unit;  // the mode moves nothing farther than a cell
  for (size_t k = 0; k < modes.size(); ++k) {
    double largest = 0;
    for (const Vec3d& u : modes.shape[k]) largest = std::max(largest, u.norm());
    unit.push_back(particles.cell_size / largest);
    strength.push_back({std::hypot(motion.cosine[k], motion.sine[k]) / unit[k], k});
  }
  std::stable_sort(strength.begin(), strength.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<size_t> chosen;
  for (size_t j = 0; j < strength.size() && static_cast<int>(j) < most; ++j)
    if (strength[j].first > 0.01 * strength[0].first) chosen.push_back(strength[j].second);
  std::sort(chosen.begin(), chosen.end());
  StartShapes out;
  for (const size_t k : chosen) {
    Shape shape;
    shape.rate = motion.omega[k];
    for (size_t i = 0; i < particles.size(); ++i) {
      shape.u.push_back((unit[k] * modes.shape[k][i]).cast<float>());
      shape.G.push_back((unit[k] * modes.gradient[k][i]).cast<float>());
    }
    out.shape_.push_back(std::move(shape));
  }
  return out;
}

StartShapes StartShapes::smooth(const Particles& particles, int most, double rate, double length) {
  SmoothFieldOptions options;
  Box box;
  for (const Vec3f& x : particles.position) box.add(x);
  options.sigma = particles.cell_size;
  options.modes = most;
  options.least = 1e-5;
  options.length = length > 0 ? length : 0.35 * double(box.size().norm());
  const SmoothField field(options, particles.position);
  const Eigen::MatrixXd slope[3] = {field.slopes(particles.position, 0), field.slopes(particles.position, 1),
                                    field.slopes(particles.position, 2)};
  StartShapes out;
  for (int axis = 0; axis < 3; ++axis)
    for (Eigen::Index k = 0; k < field.modes().cols(); ++k) {
      Shape shape;
      shape.rate = rate;
      for (Eigen::Index i = 0; i < field.modes().rows(); ++i) {
        shape.u.push_back(Vec3f::Zero());
        shape.G.push_back(Mat3f::Zero());
        shape.u.back()[axis] = static_cast<float>(field.modes()(i, k));
        for (int b = 0; b < 3; ++b) shape.G.back()(axis, b) = static_cast<float>(slope[b](i, k));
      }
      out.shape_.push_back(std::move(shape));
    }
  return out;
}

std::vector<double> StartShapes::displacement_of(const VibrationModes& modes, const ModalMotion& motion,
                                                 const Particles& particles, double t) const {
  return amplitudes_of(modal_state(modes, particles, at_time(motion, t, false), std::vector<double>(modes.size(), 0.0)),
                       particles, false);
}

std::vector<double> StartShapes::velocity_of(const VibrationModes& modes, const ModalMotion& motion,
                                             const Particles& particles, double t) const {
  return amplitudes_of(modal_state(modes, particles, std::vector<double>(modes.size(), 0.0), at_time(motion, t, true)),
                       particles, true);
}

std::vector<double> StartShapes::amplitudes_of(const SimulationState& state, const Particles& particles,
                                               bool velocity) const {
  const Eigen::Index n = static_cast<Eigen::Index>(size());
  Eigen::MatrixXd products(n, n);
  Eigen::VectorXd right(n);
  const auto scale = [&](Eigen::Index k) { return velocity ? shape_[k].rate : 1.0; };
  for (Eigen::Index a = 0; a < n; ++a) {
    right[a] = 0;
    for (size_t i = 0; i < particles.size(); ++i) {
      const Vec3f moved = velocity ? state.v[i] : Vec3f(state.x[i] - particles.position[i]);
      right[a] += particles.mass[i] * scale(a) * double(shape_[a].u[i].dot(moved));
    }
    for (Eigen::Index b = 0; b <= a; ++b) {
      double sum = 0;
      for (size_t i = 0; i < particles.size(); ++i)
        sum += double(particles.mass[i]) * double(shape_[a].u[i].dot(shape_[b].u[i]));
      products(a, b) = products(b, a) = scale(a) * scale(b) * sum;
    }
  }
  // Shapes that are nearly alike share what they explain.
  products.diagonal() *= 1 + 1e-6;
  const Eigen::VectorXd x = solve_symmetric(products, right);
  return {x.begin(), x.end()};
}

SimulationState StartShapes::state(const Particles& particles, std::span<const double> displacement,
                                   std::span<const double> velocity) const {
  SimulationState state = initial_state(particles);
  const auto add = [&](std::span<const double> amplitude, bool moving) {
    CHECK(amplitude.empty() || amplitude.size() == size());
    for (size_t k = 0; k < amplitude.size(); ++k) {
      const float a = static_cast<float>(amplitude[k] * (moving ? shape_[k].rate : 1));
      for (size_t i = 0; i < state.size(); ++i) {
        (moving ? state.v[i] : state.x[i]) += a * shape_[k].u[i];
        (moving ? state.C[i] : state.F[i]) += a * shape_[k].G[i];
      }
    }
  };
  add(displacement, false);
  add(velocity, true);
  return state;
}

}  // namespace pliant
