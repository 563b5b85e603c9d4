#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "app/pipeline/clip_camera.h"
#include "app/pipeline/default_push.h"
#include "app/pipeline/interactions.h"
#include "app/pipeline/motion.h"
#include "app/pipeline/stages.h"
#include "app/store/frames.h"
#include "app/store/material.h"
#include "app/store/particles.h"
#include "app/store/trajectory.h"
#include "fitting/fields/uniform_field.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files.h"
#include "gaussians/io/ply.h"
#include "physics/simulate/simulate.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kPushStart = 0.3, kPushDuration = 0.3;  // s

struct Body {
  ParticleFile file;
  SolidSamples samples;  // simulated ones, scene units
  DrivingParticles drivers;
  ElasticSamples material;
  Particles particles;  // SI
  std::vector<Interaction> pins;
};

/// Reads the body, gives it its material and stores that on /solid.
Body make_body(const RunDirectory& run, const std::string& folder, const Scene& scene, const ObjectMaterial& material,
               const std::string& provenance) {
  Body body;
  body.file = read_particles(run / (folder + "/particles.h5"));
  const ElasticSamples solid = uniform_field(body.file.solid_position.size(), material.young, material.poisson, material.density);
  MaterialFile stored;
  stored.young = solid.young, stored.poisson = solid.poisson, stored.density = solid.density, stored.source = "homogeneous";
  write_material(run / (folder + "/material.h5"), stored, provenance);

  for (size_t s = 0; s < body.file.solid_position.size(); ++s) {
    if (body.file.solid_driver[s] < 0) continue;
    body.samples.position.push_back(body.file.solid_position[s]);
    body.samples.volume.push_back(body.file.solid_volume[s]);
    body.drivers.sample_driver.push_back(body.file.solid_driver[s]);
    body.material.young.push_back(solid.young[s]);
    body.material.poisson.push_back(solid.poisson[s]);
    body.material.density.push_back(solid.density[s]);
  }
  body.drivers.position = body.file.driving_position, body.drivers.volume = body.file.driving_volume;
  body.drivers.thickness = body.file.driving_thickness, body.drivers.rod = body.file.driving_rod;
  body.drivers.cell_size = body.file.cell_size;
  body.particles = make_particles<float>(body.drivers, body.samples, body.material, scene.metres_per_unit);
  body.particles.materials = {material.material};

  const InteractionFrame frame{scene.metres_per_unit, scene.up};
  for (const json& row : json::parse(body.file.pinned_json)) {
    Interaction pin;
    pin.type = InteractionType::kPin;
    pin.region = parse_region(row, frame, "particles.h5").scaled(scene.metres_per_unit);
    body.pins.push_back(pin);
  }
  return body;
}

/// The plane that the object rests on, as a floor that nothing passes: the support's plane that `extract` found, where
/// the interactions name no ground of their own.
std::optional<Interaction> floor_of(const json& extract, const std::vector<Interaction>& interactions,
                                    const Scene& scene) {
  constexpr double kFriction = 0.5;
  for (const Interaction& it : interactions)
    if (it.type == InteractionType::kGround) return std::nullopt;
  if (!extract.contains("contact")) return std::nullopt;
  const json& contact = extract["contact"];
  const auto vector = [&](const char* key) {
    return Vec3d(contact[key][0].get<double>(), contact[key][1].get<double>(), contact[key][2].get<double>());
  };
  Interaction floor;
  floor.type = InteractionType::kGround, floor.friction = kFriction;
  floor.region = Region::half_space(vector("point"), vector("normal")).scaled(scene.metres_per_unit);
  return floor;
}

/// Streams frames to DIR.partial and picks up after the last whole one when the same computation was interrupted.
class FrameStore {
 public:
  FrameStore(const fs::path& folder, const std::string& key) : folder_(folder) {
    const fs::path record = folder / "key.json";
    if (fs::exists(folder) && !(fs::exists(record) && read_text(record) == key)) fs::remove_all(folder);
    fs::create_directories(folder);
    if (!fs::exists(record)) write_text(record, key);
  }

  /// State of the last whole frame, or `otherwise`.
  SimulationState resume(const SimulationState& otherwise) const {
    const int last = last_frame(folder_);
    return last < 0 ? otherwise : read_frame(folder_, last);
  }
  void add(const SimulationState& state) { write_frame(folder_, state); }
  SimulationState frame(int index) const { return read_frame(folder_, index); }
  void remove() { fs::remove_all(folder_); }

 private:
  fs::path folder_;
};

/// What Gaussians follow: the whole deformation, the permanent part included.
std::vector<Mat3f> drawn_deformation(const SimulationState& state) {
  if (state.memory.empty()) return state.F;
  std::vector<Mat3f> F;
  for (const LawMemory<float>& memory : state.memory) F.push_back(memory.F_total);
  return F;
}

TrajectoryFile assemble(const FrameStore& frames, int count, const Body& body, const std::string& object,
                        const SimulateStage& stage, const Scene& scene) {
  TrajectoryFile out;
  out.object = object, out.fps = stage.fps, out.metres_per_unit = scene.metres_per_unit, out.cell_size = body.file.cell_size, out.up = scene.up;
  const float units = static_cast<float>(1 / scene.metres_per_unit);
  for (int f = 0; f < count; ++f) {
    const SimulationState state = frames.frame(f);
    TrajectoryFile::Frame frame;
    frame.time = state.time, frame.step = state.substeps;
    frame.velocity = state.v, frame.F = drawn_deformation(state);
    frame.position.reserve(state.x.size());
    for (const Vec3f& x : state.x) frame.position.push_back(units * x);
    out.frames.push_back(std::move(frame));
  }
  return out;
}

}  // namespace

json run_simulate(const Context& context, RunDirectory& run, const Scene& scene, const SimulateStage& stage) {
  const std::string folder = object_folder(run);
  run.summary("seed", "run `pliant seed` first");
  const ObjectMaterial material = check_material(scene, stage.material);
  const Camera camera = clip_camera(scene, "", robust_bounds(read_ply(run / (folder + "/object.ply"))));

  StageKey key{"simulate",
               {{"material", material_to_json(material)}, {"fps", stage.fps}, {"duration", stage.duration}, {"damping_time", stage.damping_time}, {"gravity", stage.gravity},
                {"floor", stage.floor}},
               {{"particles", run / (folder + "/particles.h5")}},
               {folder + "/trajectory.h5", folder + "/material.h5", "interactions.json"}};
  if (stage.interactions.empty()) key.options["push"] = stage.push;
  else key.inputs["interactions"] = stage.interactions;

  return run.stage(context, key, [&]() -> json {
    const std::string provenance = run.provenance(context, key);
    Body body = make_body(run, folder, scene, material, provenance);
    const json extract = run.summary("extract", "");
    const double height = extract["height"].get<double>() * scene.metres_per_unit;

    SimulateOptions options;
    options.fps = stage.fps, options.duration = stage.duration, options.damping_time = stage.damping_time;
    options.gravity = stage.gravity ? Vec3d(-9.81 * scene.up) : Vec3d::Zero();

    // Without a script: one sideways push at the top, as strong as the body's stiffness asks for.
    json rows;
    json push = nullptr;
    if (stage.interactions.empty()) {
      const Vec3d right = camera.cam_from_world.linear().row(0).transpose();
      const PushPlace place = default_push_place(body.particles, scene.up, right);
      PushOptions sizing;
      sizing.simulate = options, sizing.up = scene.up, sizing.height = height;
      sizing.fraction = stage.push, sizing.duration = kPushDuration;
      std::vector<Interaction> held = body.pins;
      if (const auto floor = stage.floor ? floor_of(extract, {}, scene) : std::nullopt) held.push_back(*floor);
      const PushSize size = size_push(sizing, body.particles, held, place.region, place.direction);
      rows = json::array({push_row(place, size.newtons, kPushStart, kPushDuration, scene.metres_per_unit)});
      push = {{"newtons", size.newtons}, {"expected_peak", size.peak_fraction}, {"trials", size.trials}};
      context.progress.say(fmt::format("simulate: no interactions given: one push of {:.3g} N at the top, from {} s to {} s",
                                       size.newtons, kPushStart, kPushStart + kPushDuration));
    } else {
      rows = json::parse(read_text(stage.interactions), nullptr, false);
    }
    const std::string script = rows.is_discarded() ? read_text(stage.interactions) : rows.dump(2) + "\n";
    std::vector<Interaction> interactions =
        parse_interactions(script, {scene.metres_per_unit, scene.up}, stage.interactions.empty() ? "interactions.json" : stage.interactions);
    interactions.insert(interactions.end(), body.pins.begin(), body.pins.end());
    const std::optional<Interaction> floor = stage.floor ? floor_of(extract, interactions, scene) : std::nullopt;
    if (floor) {
      interactions.push_back(*floor);
      context.progress.say(fmt::format("simulate: nothing passes below the plane of '{}', friction {}",
                                       extract["contact"]["support"].get<std::string>(), floor->friction));
    }
    write_text(run / "interactions.json", script);

    FrameStore frames(run / (folder + "/trajectory.partial"), provenance);
    const SimulationState rest = initial_state(body.particles);
    const int total = static_cast<int>(std::lround(stage.fps * stage.duration));
    context.progress.begin("simulate", total);
    SimulateResult result = simulate<float>(options, body.particles, interactions, frames.resume(rest),
                                            [&](const SimulationState& state) {
                                              frames.add(state);
                                              context.progress.done(state.frame);
                                              return !context.interrupted();
                                            });
    context.progress.end();
    if (result.stopped)
      throw Error(Failure::kInterrupted, "simulate", "", "interrupted", "run the same command to continue");
    for (const std::string& warning : result.summary.warnings) context.progress.warn(warning);

    const TrajectoryFile trajectory = assemble(frames, total + 1, body, run.summary("extract", "")["name"], stage, scene);
    write_trajectory(run / (folder + "/trajectory.h5"), trajectory, provenance);
    frames.remove();

    const SimulateSummary& s = result.summary;
    const json motion = describe_motion(trajectory, body.file, scene.up, height / scene.metres_per_unit);
    context.progress.say(fmt::format("simulate: tip moves {:.1f} % of the object's height and ends at {:.1f} %",
                                     100 * motion["tip_peak"].get<double>(), 100 * motion["tip_end"].get<double>()));
    return {{"frames", total}, {"mass_kg", s.mass}, {"cell_size_m", s.cell_size}, {"dt_min_s", s.min_dt}, {"dt_max_s", s.max_dt},
            {"substeps_max", s.substeps_of_frame.empty() ? 0 : *std::max_element(s.substeps_of_frame.begin(), s.substeps_of_frame.end())},
            {"strays", s.strays}, {"retries", s.retries}, {"gravity_cancelled", s.gravity_cancelled},
            {"settle_displacement_m", s.settle_displacement}, {"push", push}, {"motion", motion}, {"floor", floor.has_value()}};
  });
}

}  // namespace pliant
