#include "app/run/attach_scene.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/run/physdreamer_scene.h"
#include "gaussians/base/error.h"

namespace pliant {
using nlohmann::json;

namespace {

json recorded(const std::filesystem::path& source, const LoadOptions& options) {
  json record = {{"source", std::filesystem::weakly_canonical(source).string()}, {"orbit_views", options.orbit_views}};
  if (options.level) record["level"] = *options.level;
  if (options.up) record["up"] = {options.up->x(), options.up->y(), options.up->z()};
  if (options.metres_per_unit) record["metres_per_unit"] = *options.metres_per_unit;
  return record;
}

Scene load_any_scene(const std::filesystem::path& source, const LoadOptions& options) {
  Scene scene = load_scene(source, options);
  if (const auto folder = physdreamer_folder(scene)) take_physdreamer_settings(scene, *folder);
  return scene;
}

}  // namespace

Scene attach_scene(const Context& context, RunDirectory& run, const std::filesystem::path& source,
                   const LoadOptions& options) {
  Scene scene = load_any_scene(source, options);
  run.set_scene(recorded(source, options), context.overwrite);
  for (const std::string& warning : scene.warnings) context.progress.warn(warning);
  context.progress.say(fmt::format("scene: {} Gaussians, {} cameras{}; up: {}", scene.cloud.size(),
                                   scene.cameras.size(), scene.cameras_are_orbit ? " (orbit)" : "", scene.up_source));
  if (!options.metres_per_unit && !scene.settings.metres_per_unit)
    context.progress.say("scene: the length of a unit is not known, taken as 1 m (--metres-per-unit)");
  return scene;
}

Scene load_run_scene(const RunDirectory& run) {
  const json& record = run.scene();
  if (!record.is_object())
    throw usage_error(run.path().string(), "scene", "is not recorded", "run `pliant segment SCENE --out DIR` first");
  LoadOptions options;
  options.orbit_views = record["orbit_views"];
  if (record.contains("level")) options.level = record["level"].get<int>();
  if (record.contains("up")) options.up = Eigen::Vector3d(record["up"][0], record["up"][1], record["up"][2]);
  if (record.contains("metres_per_unit")) options.metres_per_unit = record["metres_per_unit"].get<double>();
  return load_any_scene(record["source"].get<std::string>(), options);
}

bool is_fitted(const RunDirectory& run) { return run.has("fit"); }

std::string object_folder(const RunDirectory& run) {
  return run.summary("extract", "run `pliant extract DIR --object NAME` first")["folder"];
}

}  // namespace pliant
