#include "app/simulate/moving_scene.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/import/interactions.h"
#include "app/run/attach_scene.h"
#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/render/bind.h"
#include "gaussians/render/deform.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// Where the Gaussians are bound: where they lie, but those of a disconnected piece where the simulated part is nearest
/// to it.
std::vector<Vec3f> bound_positions(const ParticleFile& particles, const GaussianCloud& object) {
  constexpr float kShown = 1.5f;  // cells, from a sample to the Gaussians that show it
  std::vector<Vec3f> at = object.position;
  if (particles.solid_follows.empty()) return at;
  const std::vector<int> nearest = k_nearest(particles.solid_position, object.position, 1);
  for (size_t i = 0; i < at.size(); ++i) {
    if (nearest[i] < 0) continue;
    const int followed = particles.solid_follows[nearest[i]];
    const float distance = (particles.solid_position[nearest[i]] - at[i]).norm();
    if (followed >= 0 && distance <= kShown * static_cast<float>(particles.cell_size))
      at[i] = particles.solid_position[followed];
  }
  return at;
}

}  // namespace

std::vector<int> own_drivers(const ParticleFile& particles, std::span<const Vec3f> points) {
  std::vector<int> own;
  if (particles.driving_links.empty()) return own;
  std::vector<Vec3f> simulated;
  std::vector<int> driver;
  for (size_t s = 0; s < particles.solid_position.size(); ++s) {
    if (particles.solid_driver[s] < 0) continue;
    simulated.push_back(particles.solid_position[s]);
    driver.push_back(particles.solid_driver[s]);
  }
  for (const int s : k_nearest(simulated, points, 1)) own.push_back(driver[s]);
  return own;
}

Binding bind_object(const Scene& scene, const ParticleFile& particles, const GaussianCloud& object) {
  const std::vector<Vec3f> at = bound_positions(particles, object);
  const std::vector<int> own = own_drivers(particles, at);
  Binding binding = pliant::bind({}, at, particles.driving_position, {.links = particles.driving_links, .own = own});
  for (const json& row : json::parse(particles.pinned_json)) {
    const Region region = parse_region(row, {scene.metres_per_unit, scene.up}, "particles.h5");
    for (size_t i = 0; i < object.size(); ++i)
      if (region.contains(object.position[i].cast<double>())) binding.driver[i * Binding::kCount] = -1;
  }
  return binding;
}

size_t MovingScene::moving() const {
  size_t count = 0;
  for (size_t i = 0; i < binding.size(); ++i) count += binding.driver[i * Binding::kCount] >= 0;
  return count;
}

GaussianCloud MovingScene::object_at(const TrajectoryFile::Frame& frame) const {
  GaussianCloud moved;
  deform({}, object, binding, particles.driving_position, frame.position, frame.F, moved);
  return moved;
}

GaussianCloud MovingScene::all_at(const TrajectoryFile::Frame& frame) const {
  GaussianCloud all = background;
  all.append(object_at(frame));
  return all;
}

std::filesystem::path background_of(const RunDirectory& run) {
  const std::filesystem::path with_hole = run / "background.ply";
  if (!run.has("repair")) return with_hole;
  const json read = run.manifest()["stages"]["repair"].value("inputs", json::object()).value("background", json());
  return read == hash_of_input(with_hole) ? run / "background_repaired.ply" : with_hole;
}

InputFiles moving_scene_files(const RunDirectory& run) {
  check_simulated(run);
  const std::string folder = object_folder(run);
  return {{"object", run / (folder + "/object.ply")},
          {"background", background_of(run)},
          {"particles", run / (folder + "/particles.h5")},
          {"trajectory", run / (folder + "/trajectory.h5")}};
}

InputFiles recorded_scene_files(const RunDirectory& run) {
  InputFiles files = moving_scene_files(run);
  const std::string folder = object_folder(run);
  files["trajectory"] = run / (folder + "/recording.h5");
  files["particles"] = run / (folder + "/recording_particles.h5");
  for (const char* role : {"trajectory", "particles"})
    if (!fs::exists(files[role]))
      throw usage_error("--recorded", "", "finds no " + files[role].string(),
                        "run `pliant simulate DIR --recording FILE` first");
  return files;
}

void check_recorded_object(const InputFiles& files) {
  const json made_from = json::parse(read_trajectory_provenance(files.at("trajectory")), nullptr, false);
  const json of = made_from.is_object() ? made_from.value("object", json()) : json();
  if (of == hash_of_input(files.at("object"))) return;
  throw usage_error(
      "--recorded", files.at("trajectory").string(),
      of.is_null() ? "does not say which object it moves" : "moves an object that has since been replaced by `extract`",
      "run `pliant simulate DIR --recording FILE` with a recording of the present object, such as one of "
      "`pliant view DIR`");
}

MovingScene load_moving_scene(const InputFiles& files, const Scene& scene) {
  MovingScene moving;
  moving.object = read_ply(files.at("object"));
  moving.background = read_ply(files.at("background"));
  moving.particles = read_particles(files.at("particles"));
  moving.trajectory = read_trajectory(files.at("trajectory"));
  const std::vector<TrajectoryFile::Frame>& frames = moving.trajectory.frames;
  const size_t moved = frames.empty() ? 0 : frames[0].position.size(),
               drivers = moving.particles.driving_position.size();
  if (moved != drivers)
    throw input_error(files.at("trajectory").string(), "position",
                      "moves " + std::to_string(moved) + " particles, and " + files.at("particles").string() + " has " +
                          std::to_string(drivers),
                      "run `pliant simulate` again, with --recording FILE for a recording");
  moving.antialiased = scene.report.antialiased;
  moving.binding = bind_object(scene, moving.particles, moving.object);
  return moving;
}

}  // namespace pliant
