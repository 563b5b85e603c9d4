#include "fitting/modal/modes.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/portable.h"
#include "physics/laws/material.h"

namespace pliant {
namespace {

/// Displacement [3N], times sqrt(mass), and F - 1 [9N] of one moment, or a combination of some.
struct Snapshot {
  std::vector<double> u, G;
};

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

BasicParticles<double> in_double(const Particles& p) {
  BasicParticles<double> out;
  for (const Vec3f& x : p.position) out.position.push_back(x.cast<double>());
  out.volume.assign(p.volume.begin(), p.volume.end());
  out.mass.assign(p.mass.begin(), p.mass.end());
  out.young.assign(p.young.begin(), p.young.end());
  out.poisson.assign(p.poisson.begin(), p.poisson.end());
  out.object = p.object;
  out.links = p.links;
  out.cell_size = p.cell_size;
  return out;  // fixed corotated: all laws agree for small strains
}

class ModeFinder {
 public:
  ModeFinder(const ModesOptions& options, const Particles& particles, const std::vector<Interaction>& interactions)
      : options_(options), particles_(in_double(particles)) {
    for (const Interaction& it : interactions)
      if (it.type == InteractionType::kPin && it.start <= 0) pins_.push_back(it);
    if (pins_.empty())
      throw usage_error("fit", "pins", "fix nothing, and a body that is not pinned has no vibrations to identify",
                        "pin a part: \"pinned\" in scene.json, or `seed --pin-below`");
    const double whole = particles_.total_mass();
    for (size_t i = 0; i < particles_.size(); ++i) {
      const Lame<double> law = lame(particles_.young[i], particles_.poisson[i]);
      sound_ = std::max(sound_, std::sqrt((law.lambda + 2 * law.mu) * particles_.volume[i] / particles_.mass[i]));
      root_mass_.push_back(std::sqrt(particles_.mass[i]));
      centre_ += particles_.mass[i] * particles_.position[i] / whole;
    }
  }

  VibrationModes run() {
    for (int kind = 0; kind < 6; ++kind) swing(kind);
    const std::vector<Snapshot> trial = trial_shapes();
    return ritz(trial);
  }

 private:
  SimulateOptions undamped() const {
    SimulateOptions options;
    options.gravity.setZero();
    options.courant = 0.3;
    options.grid = options_.grid;
    return options;
  }

  /// Of every particle at rest, in a rigid motion.
  std::vector<Vec3d> rigid_velocities(int kind) const {
    Box box;
    for (const Vec3d& x : particles_.position) box.add(x.cast<float>());
    const double size = 0.5 * box.size().maxCoeff();
    Vec3d axis = Vec3d::Zero();
    axis[kind % 3] = 1;
    std::vector<Vec3d> velocity;
    for (const Vec3d& x : particles_.position) velocity.push_back(kind < 3 ? axis : axis.cross(x - centre_) / size);
    return velocity;
  }

  /// Free motion from a rigid velocity until the body has come back to where it was.
  void swing(int kind) {
    constexpr int kSubsteps = 8;
    SimulateOptions options = undamped();
    const double dt = options.courant * particles_.cell_size / sound_;
    options.substeps = kSubsteps;
    options.fps = 1 / (kSubsteps * dt);
    options.duration = options_.most_substeps * dt;
    BasicSimulationState<double> start = initial_state(particles_);
    const std::vector<Vec3d> velocity = rigid_velocities(kind);
    for (size_t i = 0; i < start.size(); ++i) start.v[i] = options_.speed * sound_ * velocity[i];
    std::vector<Snapshot> passed;
    int stride = 1;
    bool away = false;
    double farthest = 0;
    simulate<double>(options, particles_, pins_, start, [&](const BasicSimulationState<double>& state) {
      double along = 0;
      for (size_t i = 0; i < state.size(); ++i)
        along += particles_.mass[i] * velocity[i].dot(state.x[i] - particles_.position[i]);
      if (state.frame > 0 && state.frame % stride == 0) passed.push_back(snapshot(state));
      if (static_cast<int>(passed.size()) >= 2 * options_.snapshots) {  // keep every other one
        std::vector<Snapshot> kept;
        for (size_t k = 1; k < passed.size(); k += 2) kept.push_back(std::move(passed[k]));
        passed = std::move(kept);
        stride *= 2;
      }
      farthest = std::max(farthest, along);
      away = away || along < farthest;
      return !(away && along <= 0);
    });
    snapshots_.insert(snapshots_.end(), std::make_move_iterator(passed.begin()), std::make_move_iterator(passed.end()));
  }

  /// Frequency and decay of a mode as the solver lets it swing, by its first full period.
  void measure(VibrationModes& modes, size_t k) {
    constexpr int kFrames = 64;  // of the expected period
    SimulateOptions options = undamped();
    options.fps = kFrames * modes.omega[k] / (2 * std::numbers::pi);
    options.duration = 2 * kFrames / options.fps;
    BasicSimulationState<double> start = initial_state(particles_);
    double fastest = 0;
    for (const Vec3d& u : modes.shape[k]) fastest = std::max(fastest, u.norm());
    const double speed = options_.speed * sound_ / fastest;
    for (size_t i = 0; i < start.size(); ++i) {
      start.v[i] = speed * modes.shape[k][i];
      start.C[i] = speed * modes.gradient[k][i];
    }
    std::vector<double> passage, peak(1, 0.0);
    double before = 0, time_before = 0;
    simulate<double>(options, particles_, pins_, start, [&](const BasicSimulationState<double>& state) {
      double along = 0;
      for (size_t i = 0; i < state.size(); ++i)
        along += particles_.mass[i] * modes.shape[k][i].dot(state.x[i] - particles_.position[i]);
      if (state.frame > 1 && before * along <= 0) {
        passage.push_back(time_before + (state.time - time_before) * before / (before - along));
        peak.push_back(0.0);
      }
      peak.back() = std::max(peak.back(), std::abs(along));
      before = along;
      time_before = state.time;
      return passage.size() < 2;
    });
    if (passage.size() < 2) return;  // too strongly damped: the estimate stays
    modes.omega[k] = std::numbers::pi / (passage[1] - passage[0]);
    modes.decay[k] = std::log(peak[0] / peak[1]) / (passage[1] - passage[0]);
  }

  Snapshot snapshot(const BasicSimulationState<double>& state) const {
    Snapshot s;
    for (size_t i = 0; i < state.size(); ++i) {
      const Vec3d u = root_mass_[i] * (state.x[i] - particles_.position[i]);
      const Mat3d G = state.F[i] - Mat3d::Identity();
      s.u.insert(s.u.end(), u.data(), u.data() + 3);
      s.G.insert(s.G.end(), G.data(), G.data() + 9);
    }
    return s;
  }

  static Snapshot combination(const std::vector<Snapshot>& of, const Eigen::VectorXd& weight) {
    Snapshot out;
    out.u.assign(of[0].u.size(), 0.0);
    out.G.assign(of[0].G.size(), 0.0);
    for (size_t s = 0; s < of.size(); ++s) {
      for (size_t k = 0; k < out.u.size(); ++k) out.u[k] += weight[s] * of[s].u[k];
      for (size_t k = 0; k < out.G.size(); ++k) out.G[k] += weight[s] * of[s].G[k];
    }
    return out;
  }

  /// Principal components of all snapshots, of unit length.
  std::vector<Snapshot> trial_shapes() const {
    const int n = static_cast<int>(snapshots_.size());
    Eigen::MatrixXd gram(n, n);
    parallel_for(
        n,
        [&](std::ptrdiff_t a) {
          for (int b = 0; b <= a; ++b) gram(a, b) = gram(b, a) = dot(snapshots_[a].u, snapshots_[b].u);
        },
        1);
    const SymmetricEigen eigen = symmetric_eigen(gram);
    std::vector<Snapshot> trial;
    const double largest = eigen.values[n - 1];
    for (int k = n - 1; k >= 0 && static_cast<int>(trial.size()) < 2 * options_.most + 4; --k) {
      if (!(eigen.values[k] > 1e-9 * largest)) break;
      trial.push_back(combination(snapshots_, eigen.vectors.col(k) / std::sqrt(eigen.values[k])));
    }
    return trial;
  }

  /// Twice the strain energy that two shapes share, of linear elasticity.
  double shared_energy(const Snapshot& a, const Snapshot& b) const {
    double sum = 0;
    for (size_t i = 0; i < particles_.size(); ++i) {
      const Mat3d A = Eigen::Map<const Mat3d>(a.G.data() + 9 * i), B = Eigen::Map<const Mat3d>(b.G.data() + 9 * i);
      const Lame<double> law = lame(particles_.young[i], particles_.poisson[i]);
      const Mat3d strain = 0.5 * (A + A.transpose());
      sum += particles_.volume[i] * (2 * law.mu * strain.cwiseProduct(B).sum() + law.lambda * A.trace() * B.trace());
    }
    return sum;
  }

  VibrationModes ritz(const std::vector<Snapshot>& trial) {
    const int n = static_cast<int>(trial.size());
    Eigen::MatrixXd stiffness(n, n);
    parallel_for(
        n,
        [&](std::ptrdiff_t a) {
          for (int b = 0; b <= a; ++b) stiffness(a, b) = stiffness(b, a) = shared_energy(trial[a], trial[b]);
        },
        1);
    const SymmetricEigen eigen = symmetric_eigen(stiffness);
    VibrationModes modes;
    for (int k = 0; k < n && static_cast<int>(modes.size()) < options_.most; ++k) {
      const double square = eigen.values[k];
      if (!(square > 0)) continue;
      if (!modes.omega.empty() && std::sqrt(square) > options_.highest * modes.omega[0]) break;
      modes.omega.push_back(std::sqrt(square));
      const Snapshot s = combination(trial, eigen.vectors.col(k));
      modes.shape.emplace_back();
      modes.gradient.emplace_back();
      for (size_t i = 0; i < particles_.size(); ++i) {
        modes.shape.back().push_back(Eigen::Map<const Vec3d>(s.u.data() + 3 * i) / root_mass_[i]);
        modes.gradient.back().push_back(Eigen::Map<const Mat3d>(s.G.data() + 9 * i));
      }
    }
    modes.decay.assign(modes.size(), 0.0);
    for (size_t k = 0; k < modes.size(); ++k) measure(modes, k);
    return modes;
  }

  const ModesOptions& options_;
  BasicParticles<double> particles_;
  std::vector<Interaction> pins_;
  std::vector<double> root_mass_;
  Vec3d centre_ = Vec3d::Zero();
  double sound_ = 0;  // fastest, m/s
  std::vector<Snapshot> snapshots_;
};

}  // namespace

VibrationModes VibrationModes::stiffer(double factor) const {
  VibrationModes out = *this;
  const double root = std::sqrt(factor);
  for (double& w : out.omega) w *= root;
  for (double& rate : out.decay) rate *= root;
  out.seconds = 0;
  return out;
}

VibrationModes vibration_modes(const ModesOptions& options, const Particles& particles,
                               const std::vector<Interaction>& interactions) {
  const auto begin = std::chrono::steady_clock::now();
  VibrationModes modes = ModeFinder(options, particles, interactions).run();
  modes.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return modes;
}

}  // namespace pliant
