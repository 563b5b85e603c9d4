#include "app/simulate/session_body.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "app/import/interactions.h"
#include "app/run/attach_scene.h"
#include "app/simulate/given_fields.h"
#include "app/simulate/object_material.h"
#include "app/simulate/simulation_plan.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "physics/simulate/loads.h"
#include "physics/simulate/settle.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// Empty where the material is the same everywhere.
fs::path file_of_material(const RunDirectory& run, const json& session) {
  return session.contains("uniform") ? fs::path() : run / session["material_file"].get<std::string>();
}

/// Whether an interaction is a finger that stays where it is.
bool is_standing_finger(const Interaction& it) {
  return it.type == InteractionType::kPoke &&
         std::all_of(it.path.begin(), it.path.end(),
                     [&](const Interaction::PathPoint& p) { return p.position == it.path.front().position; });
}

/// Adds what of the script acts from the start to the end of the simulation: holds, weights and gravity.  `rows` are
/// those of the script's file.
void add_lasting(const std::vector<Interaction>& script, const json& rows, double duration, SessionSetup& setup) {
  const Vec3d captured = setup.options.gravity;
  const auto add_row = [&](size_t k, const json& held) {
    json row = rows[k];
    row.erase("duration");
    setup.script.push_back({{"row", row}, {"held", held}});
  };
  for (size_t k = 0; k < script.size(); ++k) {
    const Interaction& it = script[k];
    if (it.start != 0 || end_of(it) < duration) continue;
    if (it.type == InteractionType::kGravity) {
      setup.options.gravity = it.vector;
      add_row(k, nullptr);
    }
    if (it.type == InteractionType::kCollider && (moves(it) || it.container))
      setup.refused = "an obstacle of the interactions moves or is a container";
    if (moves(it) && !is_standing_finger(it)) continue;
    const std::vector<Interaction> resting = resting_interactions({it});
    if (!resting.empty()) add_row(k, setup.held.size());
    setup.held.insert(setup.held.end(), resting.begin(), resting.end());
  }
  // A session cancels all of its gravity while a pin holds the body.
  const bool pinned = std::any_of(setup.held.begin(), setup.held.end(),
                                  [](const Interaction& it) { return it.type == InteractionType::kPin; });
  if (pinned && setup.options.gravity != captured)
    setup.refused = "the interactions change the gravity of a body that is pinned";
}

}  // namespace

ElasticSamples simulated_material(const RunDirectory& run, const json& session, const std::vector<Vec3f>& positions) {
  if (!session.contains("uniform")) return given_material(file_of_material(run, session), positions);
  const json& all = session["uniform"];
  return ElasticSamples::homogeneous(positions.size(), all["young"], all["poisson"], all["density"]);
}

json record_of_motion(const RunDirectory& run) {
  const json& all = run.manifest()["stages"]["simulate"];
  json out = {{"seed", all.value("seed", json())}};
  for (const char* part : {"options", "scene", "found", "inputs"}) out[part] = all.value(part, json::object());
  out["options"].erase("duration");
  return out;
}

SessionSetup session_setup(const RunDirectory& run, const Scene& scene, const MovingScene& moving) {
  constexpr double kFps = 60;
  SessionSetup setup;
  check_simulated_with(run, scene);
  const json& simulated = run.summary("simulate", "run `pliant simulate` first");
  if (!simulated.contains("session")) {
    setup.refused = "this motion was simulated by an earlier version";
    return setup;
  }
  const json& session = simulated["session"];
  if (session["physgaussian"]) {
    setup.refused = "the motion follows a configuration of PhysGaussian";
    return setup;
  }
  if (session.value("obstacles", false)) {
    setup.refused = "the rest of the scene is an obstacle (--collide-scene)";
    return setup;
  }
  // Earlier versions recorded less.
  setup.material = law_of_record(session.value(
      "material", json{{"law", session["law"]}, {"viscosity_time", session.value("viscosity_time_s", 0.0)}}));
  setup.remembers = has_memory(setup.material.law);
  if (setup.remembers && !moving.trajectory.memory) {
    setup.refused = "this motion was simulated by an earlier version";
    return setup;
  }
  if (const fs::path file = file_of_material(run, session); !file.empty() && !fs::exists(file)) {
    setup.refused = "the material " + file.filename().string() + " is gone";
    return setup;
  }
  setup.solid = simulated_material(run, session, moving.particles.solid_position);
  if (setup.material.law != Law::kViscoelastic) setup.solid.branch.clear();  // that of the file did not count
  setup.options.fps = kFps;
  setup.options.damping_time = simulated["damping_time_s"];
  for (int a = 0; a < 3; ++a) setup.options.gravity[a] = session["gravity_m_s2"][a];
  setup.options.object_friction = session["contact_friction"];
  setup.options.grid = grid_kind(session.value("solver", "auto"));
  setup.options.flip_time = session.value("flip_time_s", 0.0);
  setup.options.sleep_speed = session.value("sleep_speed_m_s", 0.0);
  const json found = extracted(run, {"height", "contact"});
  setup.height = found["height"].get<double>() * scene.metres_per_unit;
  setup.held = pins_of(moving.particles.pinned_json, scene);
  if (simulated["floor"].get<bool>())
    if (const auto floor = floor_of(found, {}, scene)) setup.held.push_back(*floor);
  const fs::path script = run / "interactions.json";
  if (fs::exists(script)) {
    const std::string text = read_text(script);
    const auto interactions = parse_interactions(text, {scene.metres_per_unit, scene.up}, script.string());
    add_lasting(interactions, json::parse(text), session.value("duration_s", std::numeric_limits<double>::infinity()),
                setup);
  }
  return setup;
}

SimulationState state_of(const std::vector<DriverFrame>& motion, size_t f, double fps, double metres_per_unit,
                         const Particles& particles, const std::optional<TrajectoryFile::Memory>& memory) {
  CHECK(f < motion.size() && particles.has_memory() == memory.has_value());
  SimulationState state = initial_state(particles);
  const size_t before = f > 0 ? f - 1 : f, after = std::min(f + 1, motion.size() - 1);
  const float metres = static_cast<float>(metres_per_unit);
  const float rate = after > before ? metres * static_cast<float>(fps / static_cast<double>(after - before)) : 0;
  for (size_t i = 0; i < state.size(); ++i) {
    state.x[i] = metres * motion[f].position[i];
    state.v[i] = rate * (motion[after].position[i] - motion[before].position[i]);
    state.F[i] = memory ? memory->F[i] : motion[f].F[i];
    if (memory) state.memory[i] = {motion[f].F[i], memory->F_viscous[i], memory->history[i]};
  }
  return state;
}

}  // namespace pliant
