#include "app/simulate/given_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "app/import/material_fields.h"
#include "app/store/material.h"
#include "app/store/velocity.h"
#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/quantile.h"
#include "physics/simulate/simulator.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

bool is_uniform(const std::vector<float>& values) {
  return !values.empty() && std::equal(values.begin() + 1, values.end(), values.begin());
}

/// For each of `points`, the row of the file that counts for it.
std::vector<int> rows_for(const fs::path& file, const std::string& field, size_t rows, const std::vector<Vec3f>& places,
                          const std::vector<Vec3f>& points) {
  if (rows == points.size() && (places.empty() || places == points)) {
    std::vector<int> same(rows);
    std::iota(same.begin(), same.end(), 0);
    return same;
  }
  if (places.empty())
    throw input_error(
        file.string(), field,
        fmt::format("has {} rows, the object has {} points, and the file holds no positions to match them by", rows,
                    points.size()),
        "it was made before these particles were seeded: fit or simulate again, `seed` with the options "
        "of then, or add positions to the file");
  check_place(file, fs::path(field).replace_filename("position").string(), places, points);
  return k_nearest(places, points, 1);
}

/// Makes of a state what the nodes of the grid can represent.  Where a displacement and an F do not belong together, a
/// body would keep the difference for good.
void follow_nodes(const Particles& body, SimulationState& state) {
  Particles elastic = body;  // how a body can move does not depend on its law
  elastic.materials = {Material{}};
  elastic.material_index.clear();
  SimulateOptions options;
  options.grid = GridKind::kLagrangian;
  SimulateSummary ignored;
  Simulator<float> simulator(options, elastic, {}, ignored);
  simulator.begin_frame(state);
  simulator.solver().drop_undisplaced();
  simulator.solver().store(state);
  state.node_displacement.clear();
  state.node_velocity.clear();
  state.memory = initial_state(body).memory;
}

}  // namespace

ElasticSamples given_material(const fs::path& file, const std::vector<Vec3f>& positions, Progress* progress) {
  MaterialFile m;
  if (is_material_field(file)) {
    m = read_material_field(file);
    m.position = placed_in(file, m.position, positions);
  } else {
    m = read_material(file);
  }
  // A uniform material is that of any particles, wherever its own were.
  if (is_uniform(m.young) && is_uniform(m.poisson) && is_uniform(m.density) && m.branch.empty()) {
    if (progress && m.young.size() != positions.size())
      progress->say(
          fmt::format("{}: E, nu and rho are the same everywhere: those of its {} samples count for the {} of "
                      "this object",
                      file.string(), m.young.size(), positions.size()));
    return ElasticSamples::homogeneous(positions.size(), m.young[0], m.poisson[0], m.density[0]);
  }
  ElasticSamples solid;
  for (const int row : rows_for(file, "/solid/young", m.young.size(), m.position, positions)) {
    solid.young.push_back(m.young[row]);
    solid.poisson.push_back(m.poisson[row]);
    solid.density.push_back(m.density[row]);
    if (!m.branch.empty()) solid.branch.push_back(m.branch[row]);
  }
  return solid;
}

std::string unit_doubt(const ElasticSamples& solid) {
  constexpr float kSoftest = 1, kSoftestInGiga = 1e-3f, kLightest = 5;
  CHECK(!solid.young.empty() && !solid.density.empty());
  const float young = quantile(solid.young, 0.5), density = quantile(solid.density, 0.5);
  std::string doubt;
  if (young < kSoftest)
    doubt =
        fmt::format("has a median E of {:.3g} Pa: is it in {}?", young, young < kSoftestInGiga ? "GPa" : "MPa or GPa");
  if (density < kLightest)
    doubt +=
        fmt::format("{}has a median density of {:.3g} kg/m^3: is it in g/cm^3?", doubt.empty() ? "" : " It ", density);
  return doubt;
}

SimulationState given_start(const fs::path& file, const ParticleFile& particles, const Particles& body) {
  const VelocityFile v = read_velocity(file);
  const std::vector<int> rows =
      rows_for(file, "/driving/velocity", v.velocity.size(), v.position, particles.driving_position);
  CHECK(rows.size() == body.size());
  const bool moved = !v.position.empty() && v.position != particles.driving_position;
  const float metres = static_cast<float>(body.cell_size / particles.cell_size);
  SimulationState state = initial_state(body);
  for (size_t i = 0; i < state.size(); ++i) {
    const int row = rows[i];
    const Vec3f from = moved ? Vec3f(metres * (particles.driving_position[i] - v.position[row])) : Vec3f::Zero();
    state.x[i] += v.displacement[row] + (v.F[row] - Mat3f::Identity()) * from;
    state.v[i] = v.velocity[row] + v.C[row] * from;
    state.F[i] = v.F[row];
    state.C[i] = v.C[row];
  }
  if (moved) follow_nodes(body, state);
  // Nothing of the deformation is permanent.
  for (size_t i = 0; i < state.memory.size(); ++i) state.memory[i].F_total = state.F[i];
  return state;
}

}  // namespace pliant
