// The solver of a clip.html: the functions that its worker calls.  Numbers cross as arrays of float or double in the
// module's memory, in SI units.

#include <cstdlib>
#include <limits>
#include <memory>
#include <vector>

#include "app/page/interaction_numbers.h"
#include "app/page/most_substeps.h"
#include "gaussians/base/error.h"
#include "physics/simulate/session.h"

#define PLIANT_EXPORT(name) extern "C" __attribute__((export_name(#name))) auto name

namespace pliant {
namespace {

constexpr int kMostSubsteps = 2000;  // of a frame, unless the body at rest needs as many

/// What the worker fills in before it starts a session, and the session.
struct Page {
  SimulateOptions options;
  Particles particles;
  SimulationState start;
  std::vector<Interaction> held;
  std::unique_ptr<Session> session;
  std::vector<float> gradients;
};

Page& page() {
  static Page only;
  return only;
}

Vec3d vector_at(const double* from) { return {from[0], from[1], from[2]}; }

}  // namespace
}  // namespace pliant

using namespace pliant;

PLIANT_EXPORT(solver_allocate)(size_t bytes)->void* { return std::malloc(bytes); }
PLIANT_EXPORT(solver_free)(void* memory)->void { std::free(memory); }

/// numbers [13]: cell size m, frames per second, damping time s, gravity m/s^2 [3], largest share of a cell that waves
/// cross in a substep (0 = the solver's own), contact friction, law, viscosity time of the material s, kind of grid,
/// FLIP time s, sleep speed m/s.
PLIANT_EXPORT(solver_body)
(int count, const double* numbers, const float* position, const float* volume, const float* mass, const float* young,
 const float* poisson)
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
  p.particles.materials[0].law = static_cast<Law>(static_cast<int>(numbers[8]));
  p.particles.materials[0].viscosity_time = numbers[9];
  p.options.grid = static_cast<GridKind>(static_cast<int>(numbers[10]));
  p.options.flip_time = numbers[11];
  p.options.sleep_speed = numbers[12];
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

/// Begins at these positions [N, 3], velocities [N, 3] and deformation gradients [N, 9] (rows).  `held_as_captured`: a
/// pin held the body as it was captured, 1 or 0; -1 = where one is among the interactions from the start on.  Returns
/// which.
PLIANT_EXPORT(solver_start)(int held_as_captured, const float* x, const float* v, const float* F)->int {
  Page& p = page();
  if (held_as_captured >= 0) p.options.held_as_captured = held_as_captured != 0;
  p.start = initial_state(p.particles);
  for (size_t i = 0; i < p.start.size(); ++i) {
    p.start.x[i] = Vec3f(x + 3 * i);
    p.start.v[i] = Vec3f(v + 3 * i);
    for (int k = 0; k < 9; ++k) p.start.F[i](k / 3, k % 3) = F[9 * i + k];
  }
  p.options.max_substeps = most_substeps(p.options, p.particles, 1, kMostSubsteps);
  p.session = std::make_unique<Session>(p.options, p.particles, p.held, p.start);
  p.gradients.resize(9 * p.start.size());
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
/// Positions [N, 3] m, velocities [N, 3] m/s and deformation gradients [N, 9] (rows) of now.
PLIANT_EXPORT(solver_positions)()->const float* { return page().session->state().x.data()->data(); }
PLIANT_EXPORT(solver_velocities)()->const float* { return page().session->state().v.data()->data(); }
PLIANT_EXPORT(solver_gradients)()->const float* {
  Page& p = page();
  for (size_t i = 0; i < p.start.size(); ++i)
    for (int k = 0; k < 9; ++k) p.gradients[9 * i + k] = p.session->state().F[i](k / 3, k % 3);
  return p.gradients.data();
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
