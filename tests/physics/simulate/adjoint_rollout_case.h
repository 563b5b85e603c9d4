#pragma once

// A small body with everything that acts on it, and a random functional of its frames.

#include <string>
#include <vector>

#include "gaussians/base/random.h"
#include "physics/simulate/rollout.h"
#include "tests/physics/shapes.h"

namespace pliant::fixture {

/// Input `kind` of a roll-out as a list of numbers of order one.
enum class Input { kX, kV, kC, kF, kYoung, kPoisson, kMass, kForces, kWeights, kGravity, kDamping, kMemory, kBranch };
inline const std::vector<std::pair<Input, std::string>> kInputs = {
    {Input::kX, "x"},           {Input::kV, "v"},
    {Input::kC, "C"},           {Input::kF, "F"},
    {Input::kYoung, "E"},       {Input::kPoisson, "nu"},
    {Input::kMass, "mass"},     {Input::kForces, "forces"},
    {Input::kGravity, "g"},     {Input::kDamping, "damping"},
    {Input::kMemory, "memory"}, {Input::kWeights, "weights"},
    {Input::kBranch, "branch"}};

template <class T>
struct RolloutCase {
  BasicParticles<T> particles;
  BasicSimulationState<T> start;
  std::vector<Interaction> interactions;
  RolloutOptions options;

  /// Numbers of one kind, scaled to order one.
  std::vector<double> get(Input kind) const { return const_cast<RolloutCase*>(this)->walk(kind, nullptr); }
  RolloutCase with(Input kind, const std::vector<double>& values) const {
    RolloutCase other = *this;
    other.walk(kind, &values);
    return other;
  }

  /// L = sum over frames and particles of fixed random numbers times what moves.
  FrameCotangent<T> cotangent() const {
    return [dx = double(particles.cell_size), memory = particles.has_memory()](int frame, StateGradient<T>& g) {
      if (memory) g.memory.resize(g.x.size());
      for (size_t i = 0; i < g.x.size(); ++i) {
        Random random(11, i, frame);
        for (int a = 0; a < 3; ++a) {
          g.x[i][a] += T(random.normal() / dx);
          g.v[i][a] += T(random.normal());
        }
        for (int k = 0; k < 9; ++k) {
          g.C[i](k / 3, k % 3) += T(random.normal() * dx);
          g.F[i](k / 3, k % 3) += T(random.normal());
        }
        if (!memory) continue;
        for (int k = 0; k < 9; ++k) g.memory[i].F_total(k / 3, k % 3) += T(random.normal());
        for (int k = 0; k < 9; ++k) g.memory[i].F_viscous(k / 3, k % 3) += T(random.normal());
        g.memory[i].history += T(random.normal());
      }
    };
  }
  double functional(const Rollout<T>& rollout) const {
    double L = 0;
    for (size_t f = 0; f < rollout.frames.size(); ++f) {
      StateGradient<T> g = StateGradient<T>::zero(particles.size());
      cotangent()(static_cast<int>(f), g);
      const BasicSimulationState<T>& s = rollout.frames[f];
      for (size_t i = 0; i < g.x.size(); ++i)
        L += g.x[i].dot(s.x[i] - particles.position[i]) + g.v[i].dot(s.v[i]) + g.C[i].cwiseProduct(s.C[i]).sum() +
             g.F[i].cwiseProduct(s.F[i]).sum();
      for (size_t i = 0; i < g.memory.size(); ++i)
        L += g.memory[i].F_total.cwiseProduct(s.memory[i].F_total).sum() +
             g.memory[i].F_viscous.cwiseProduct(s.memory[i].F_viscous).sum() +
             g.memory[i].history * s.memory[i].history;
    }
    return L;
  }
  double value() const { return functional(rollout(options, particles, interactions, start)); }
  RolloutGradient<T> gradient() const {
    return rollout_adjoint<T>(options, particles, interactions, rollout(options, particles, interactions, start),
                              cotangent());
  }
  /// The part of a gradient that belongs to get(kind).
  std::vector<double> part(const RolloutGradient<T>& g, Input kind) const {
    RolloutCase by = *this;  // derivatives in the places of the values
    by.start.x = g.start.x;
    by.start.v = g.start.v;
    by.start.C = g.start.C;
    by.start.F = g.start.F;
    for (size_t i = 0; i < g.start.memory.size(); ++i)
      by.start.memory[i] = {g.start.memory[i].F_total, g.start.memory[i].F_viscous, g.start.memory[i].history};
    by.particles.young = g.young;
    by.particles.poisson = g.poisson;
    by.particles.mass = g.mass;
    for (size_t k = 0; k < interactions.size(); ++k) {
      by.interactions[k].vector = g.interaction[k];
      by.interactions[k].mass = g.weight[k];
    }
    by.options.simulate.gravity = g.gravity;
    by.options.simulate.damping_time = g.damping_time;
    by.options.simulate.viscosity_time = g.viscosity_time;
    for (size_t m = 0; m < particles.materials.size(); ++m) {
      by.particles.materials[m].damping_time = g.material[m].damping_time;
      by.particles.materials[m].viscosity_time = g.material[m].viscosity_time;
      by.particles.materials[m].branch_shear = g.material[m].branch.shear;
      by.particles.materials[m].branch_lambda = g.material[m].branch.lambda;
      by.particles.materials[m].branch_viscosity = g.material[m].branch.viscosity;
    }
    const std::vector<double> scaled = by.get(kind);  // value / scale; the derivative wants times scale
    std::vector<double> result = scaled;
    for (size_t k = 0; k < result.size(); ++k) result[k] *= by.scales_[k] * by.scales_[k];
    return result;
  }

 private:
  mutable std::vector<double> scales_;

  std::vector<double> walk(Input kind, const std::vector<double>* values) {
    std::vector<double> numbers;
    scales_.clear();
    const auto visit = [&](auto& field, double scale) {
      if (values) field = static_cast<std::decay_t<decltype(field)>>((*values)[numbers.size()] * scale);
      numbers.push_back(static_cast<double>(field) / scale);
      scales_.push_back(scale);
    };
    const double dx = particles.cell_size;
    for (size_t i = 0; i < particles.size(); ++i) {
      for (int k = 0; k < 9; ++k) {
        if (kind == Input::kX && k < 3) visit(start.x[i][k], dx);
        if (kind == Input::kV && k < 3) visit(start.v[i][k], 1);
        if (kind == Input::kC) visit(start.C[i](k / 3, k % 3), 1 / dx);
        if (kind == Input::kF) visit(start.F[i](k / 3, k % 3), 1);
      }
      if (kind == Input::kMemory && !start.memory.empty() && has_memory(particles.material(i).law)) {
        for (int k = 0; k < 9; ++k) visit(start.memory[i].F_viscous(k / 3, k % 3), 1);
        for (int k = 0; k < 9; ++k) visit(start.memory[i].F_total(k / 3, k % 3), 1);
        visit(start.memory[i].history, 1);
      }
      if (kind == Input::kYoung) visit(particles.young[i], 1e4);
      if (kind == Input::kPoisson) visit(particles.poisson[i], 1);
      if (kind == Input::kMass) visit(particles.mass[i], 125 * dx * dx * dx);
    }
    if (kind == Input::kForces)
      for (Interaction& it : interactions)
        for (int a = 0; a < 3; ++a) visit(it.vector[a], it.type == InteractionType::kImpulse ? 1e-2 : 1);
    if (kind == Input::kWeights)
      for (Interaction& it : interactions)
        if (it.type == InteractionType::kWeight) visit(it.mass, 1e-3);
    if (kind == Input::kGravity)
      for (int a = 0; a < 3; ++a) visit(options.simulate.gravity[a], 10);
    if (kind == Input::kDamping) {
      visit(options.simulate.damping_time, 1);
      visit(options.simulate.viscosity_time, 1e-3);
      Material& damped = particles.materials.back();
      visit(damped.damping_time, 1);
      visit(damped.viscosity_time, 1e-3);
    }
    if (kind == Input::kBranch && particles.materials.back().law == Law::kViscoelastic) {
      Material& relaxing = particles.materials.back();
      visit(relaxing.branch_shear, 1e4);
      visit(relaxing.branch_lambda, 1e4);
      visit(relaxing.branch_viscosity, 10);
    }
    return numbers;
  }
};

/// A jittered block of n^3 cells, 8 particles each, that moves and is strained, with forces of all kinds.
template <class T>
RolloutCase<T> moving_block(double cells = 2.5) {
  RolloutCase<T> c;
  const double dx = 0.01;
  c.particles = block<T>(Vec3d::Constant(cells * dx), dx, 0.7, 2e4, 0.3, 1000);
  // Two laws that the kernels know, one with damping of its own.
  Material rubber;
  rubber.law = Law::kNeoHookean;
  rubber.damping_time = 0.3;
  rubber.viscosity_time = 3e-4;
  c.particles.materials = {Material{}, rubber};
  for (size_t i = 0; i < c.particles.size(); ++i) c.particles.material_index.push_back(i % 3 == 0);
  c.start = initial_state(c.particles);
  for (size_t i = 0; i < c.particles.size(); ++i) {
    Random random(3, i);
    c.particles.young[i] *= T(random.uniform(0.7, 1.4));
    c.particles.poisson[i] = T(random.uniform(0.2, 0.4));
    c.particles.mass[i] *= T(random.uniform(0.8, 1.2));
    for (int a = 0; a < 3; ++a) c.start.v[i][a] = T(0.1 * random.normal());
    for (int k = 0; k < 9; ++k) {
      c.start.C[i](k / 3, k % 3) = T(3 * random.normal());
      c.start.F[i](k / 3, k % 3) += T(0.03 * random.normal());
    }
  }
  c.options.simulate.fps = 200;
  c.options.simulate.duration = 0.015;
  c.options.simulate.substeps = 20;
  c.options.simulate.damping_time = 0.4;
  c.options.simulate.viscosity_time = 2e-4;

  const double size = cells * dx;
  Interaction it;
  it.type = InteractionType::kPointForce;
  it.vector = {0.03, -0.02, 0.05};
  it.duration = 0.00705;
  it.region = Region::sphere({size, size, size}, 0.6 * size);
  c.interactions.push_back(it);
  it.type = InteractionType::kImpulse;
  it.vector = {2e-3, 3e-3, -1e-3};
  it.start = 0.00615;
  it.region = Region::sphere({0, 0, size}, 0.5 * size);
  c.interactions.push_back(it);
  it.type = InteractionType::kGust;
  it.vector = {1, 2, -0.5};
  it.start = 0.002;
  it.rate = 5;
  it.region = Region::all();
  c.interactions.push_back(it);
  it.vector = {-2, 1, 1};
  it.start = 0;
  it.rate = 0;
  it.region = Region::sphere({size, 0, size}, 0.5 * size);
  c.interactions.push_back(it);
  it = {};
  it.type = InteractionType::kGrab;
  it.region = Region::sphere({0, size, size}, 0.5 * size);
  it.path = {{0, {0, size, size}}, {0.01, {-0.3 * size, size, 1.2 * size}}, {1, {0, size, size}}};
  c.interactions.push_back(it);
  it.path[1].position[0] = size;
  it.max_force = 0.02;
  it.stiffness = 100;
  it.damping = 1;
  it.region = Region::sphere({0, 0, size}, 0.4 * size);
  c.interactions.push_back(it);
  // Asks for more than the touched material gives.
  it.max_force = 0;
  it.stiffness = 1e7;
  it.region = Region::sphere({size, size, size}, 0.4 * size);
  it.path[1].position[0] = 3 * size;
  it.start = 0.001;
  it.duration = 0.0005;
  c.interactions.push_back(it);
  return c;
}

inline Interaction ground(double z, double friction) {
  Interaction it;
  it.type = InteractionType::kGround;
  it.friction = friction;
  it.region = Region::half_space(Vec3d(0, 0, z), Vec3d(0, 0, 1));
  return it;
}

inline Interaction pin_below(double z) {
  Interaction it;
  it.type = InteractionType::kPin;
  it.region = Region::half_space(Vec3d(0, 0, z), Vec3d(0, 0, 1));
  return it;
}

}  // namespace pliant::fixture
