// The solver of a clip.html: the functions that its worker calls.  Numbers cross as arrays of float or double in the
// module's memory, in SI units.

#include <cstdlib>
#include <limits>
#include <memory>
#include <vector>

#include "app/page/interaction_numbers.h"
#include "app/page/material_numbers.h"
#include "app/page/most_substeps.h"
#include "gaussians/base/error.h"
#include "physics/simulate/session.h"

#define PLIANT_EXPORT(name) extern "C" __attribute__((export_name(#name))) auto name

namespace pliant {
namespace {

constexpr size_t kMemoryNumbers = 19;  // of a particle
constexpr int kMostSubsteps = 2000;    // of a frame, unless the body at rest needs as many

/// What the worker fills in before it starts a session, and the session.
struct Page {
  SimulateOptions options;
  Particles particles;
  SimulationState start;
  std::vector<Interaction> held;
  std::unique_ptr<Session> session;
  std::vector<float> gradients, memory;
};

Page& page() {
  static Page only;
  return only;
}

Vec3d vector_at(const double* from) { return {from[0], from[1], from[2]}; }

Mat3f matrix_at(const float* rows) {
  Mat3f out;
  for (int k = 0; k < 9; ++k) out(k / 3, k % 3) = rows[k];
  return out;
}
void put_matrix(const Mat3f& matrix, float* rows) {
  for (int k = 0; k < 9; ++k) rows[k] = matrix(k / 3, k % 3);
}

}  // namespace
}  // namespace pliant

using namespace pliant;

PLIANT_EXPORT(solver_allocate)(size_t bytes)->void* { return std::malloc(bytes); }
PLIANT_EXPORT(solver_free)(void* memory)->void { std::free(memory); }

/// numbers [11]: cell size m, frames per second, damping time s, gravity m/s^2 [3], largest share of a cell that waves
/// cross in a substep (0 = the solver's own), contact friction, kind of grid, FLIP time s, sleep speed m/s.
/// materials [kinds, 15] see numbers_of; material [count]: which of them.
PLIANT_EXPORT(solver_body)
(int count, int kinds, const double* numbers, const double* materials, const uint16_t* material, const float* position,
 const float* volume, const float* mass, const float* young, const float* poisson)
    ->void {
  Page& p = page();
  p.particles = {};
  p.particles.cell_size = static_cast<float>(numbers[0]);
  p.options = {};
  p.options.fps = numbers[1];
  p.options.damping_time = numbers[2];
  p.options.gravity = vector_at(numbers + 3);
  if (numbers[6] > 0) p.options.courant = numbers[6];
  p.options.object_friction = numbers[7];
  p.options.grid = static_cast<GridKind>(static_cast<int>(numbers[8]));
  p.options.flip_time = numbers[9];
  p.options.sleep_speed = numbers[10];
  p.particles.materials.clear();
  for (int k = 0; k < kinds; ++k)
    p.particles.materials.push_back(material_of({materials + kMaterialNumbers * k, kMaterialNumbers}));
  if (kinds > 1) p.particles.material_index.assign(material, material + count);
  for (const uint16_t k : p.particles.material_index) CHECK(k < kinds);
  for (int i = 0; i < count; ++i) p.particles.position.emplace_back(position + 3 * i);
  p.particles.volume.assign(volume, volume + count);
  p.particles.mass.assign(mass, mass + count);
  p.particles.young.assign(young, young + count);
  p.particles.poisson.assign(poisson, poisson + count);
  p.held.clear();
  p.session.reset();
}

/// Pairs [count, 2] of particles that hang together (see BasicParticles).
PLIANT_EXPORT(solver_link)(int count, const int* pairs)->void {
  Particles& particles = page().particles;
  for (int k = 0; k < count; ++k) {
    CHECK(pairs[2 * k] >= 0 && pairs[2 * k] < pairs[2 * k + 1] &&
          pairs[2 * k + 1] < static_cast<int>(particles.size()));
    particles.links.push_back({pairs[2 * k], pairs[2 * k + 1]});
  }
}

/// An interaction from the start on: pins, floor.
PLIANT_EXPORT(solver_hold)(const double* numbers)->void {
  page().held.push_back(interaction_of({numbers, kInteractionNumbers}));
}

/// Begins at these positions [N, 3], velocities [N, 3] and deformation gradients [N, 9] (rows); memory
/// [remembered] as solver_memory gives it, 19 per particle where the law has one, else none.  `held_as_captured`: a pin
/// held the body as it was captured, 1 or 0; -1 = where one is among the interactions from the start on.  Returns
/// which.
PLIANT_EXPORT(solver_start)
(int held_as_captured, int remembered, const float* x, const float* v, const float* F, const float* memory)->int {
  Page& p = page();
  if (held_as_captured >= 0) p.options.held_as_captured = held_as_captured != 0;
  p.start = initial_state(p.particles);
  if (static_cast<size_t>(remembered) != kMemoryNumbers * p.start.memory.size())
    throw input_error("clip.html", "memory", "is not what the law remembers", "export the page again");
  for (size_t i = 0; i < p.start.size(); ++i) {
    p.start.x[i] = Vec3f(x + 3 * i);
    p.start.v[i] = Vec3f(v + 3 * i);
    p.start.F[i] = matrix_at(F + 9 * i);
    if (p.start.memory.empty()) continue;
    const float* const row = memory + kMemoryNumbers * i;
    p.start.memory[i] = {p.start.F[i], matrix_at(row + 9), row[18]};
    p.start.F[i] = matrix_at(row);
  }
  p.options.max_substeps = most_substeps(p.options, p.particles, 1, kMostSubsteps);
  p.session = std::make_unique<Session>(p.options, p.particles, p.held, p.start);
  p.gradients.resize(9 * p.start.size());
  p.memory.resize(kMemoryNumbers * p.start.memory.size());
  return p.session->held_as_captured() ? 1 : 0;
}

PLIANT_EXPORT(solver_begin)(const double* numbers)->int {
  return page().session->begin(interaction_of({numbers, kInteractionNumbers}));
}
PLIANT_EXPORT(solver_move)(int number, double x, double y, double z)->void { page().session->move(number, {x, y, z}); }
PLIANT_EXPORT(solver_end)(int number)->void { page().session->end(number); }
PLIANT_EXPORT(solver_set)(double young_scale, double damping_time, double x, double y, double z)->void {
  Page& p = page();
  p.session->set(
      {young_scale, damping_time, {x, y, z}, most_substeps(p.options, p.particles, young_scale, kMostSubsteps)});
}
/// One frame; the number of its substeps.
PLIANT_EXPORT(solver_advance)()->int {
  page().session->advance();
  return page().session->substeps();
}
/// Positions [N, 3] m, velocities [N, 3] m/s and whole deformation gradients [N, 9] (rows) of now.
PLIANT_EXPORT(solver_positions)()->const float* { return page().session->state().x.data()->data(); }
PLIANT_EXPORT(solver_velocities)()->const float* { return page().session->state().v.data()->data(); }
PLIANT_EXPORT(solver_gradients)()->const float* {
  Page& p = page();
  const SimulationState& state = p.session->state();
  for (size_t i = 0; i < state.size(); ++i)
    put_matrix(state.memory.empty() ? state.F[i] : state.memory[i].F_total, &p.gradients[9 * i]);
  return p.gradients.data();
}
/// What the law remembers [N, 19]: elastic deformation gradients and those of the relaxing branch (rows), history; null
/// where it remembers nothing.
PLIANT_EXPORT(solver_memory)()->const float* {
  Page& p = page();
  const SimulationState& state = p.session->state();
  for (size_t i = 0; i < state.memory.size(); ++i) {
    float* const out = &p.memory[kMemoryNumbers * i];
    put_matrix(state.F[i], out);
    put_matrix(state.memory[i].F_viscous, out + 9);
    out[18] = state.memory[i].history;
  }
  return p.memory.empty() ? nullptr : p.memory.data();
}
/// Writes the mean force [N] of an interaction in the last frame.
PLIANT_EXPORT(solver_force)(int number, double* newtons)->void {
  const Vec3d force = page().session->force(number);
  for (int a = 0; a < 3; ++a) newtons[a] = force[a];
}
/// Writes the point [m] at which a grab that was begun takes hold.
PLIANT_EXPORT(solver_hold_point)(int number, double* point)->void {
  const Vec3d place = page().session->history()[number].path.front().position;
  for (int a = 0; a < 3; ++a) point[a] = place[a];
}
