#include "app/run/attach_scene.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/run/physdreamer_scene.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/utf8.h"

namespace pliant {
using nlohmann::json;

namespace {

json recorded(const std::filesystem::path& source, const LoadOptions& options) {
  json record = {{"source", std::filesystem::weakly_canonical(source).string()}};
  if (options.orbit_views) record["orbit_views"] = *options.orbit_views;
  if (options.level) record["level"] = *options.level;
  if (options.up) record["up"] = {options.up->x(), options.up->y(), options.up->z()};
  if (options.metres_per_unit) record["metres_per_unit"] = *options.metres_per_unit;
  if (options.object_height > 0) record["object_height"] = options.object_height;
  return record;
}

/// Refuses a name that a record in JSON cannot hold.
void check_name(const std::string& name) {
  const std::string shown = as_utf8(name);
  if (shown != name) throw input_error(shown, "", "its name is not UTF-8", "rename it");
}

/// Refuses a scene whose files or photographs have such names.
void check_names(const Scene& scene) {
  for (const std::filesystem::path& file : scene.report.files) check_name(file.string());
  for (const Camera& camera : scene.cameras) check_name(camera.name);
}

Scene load_any_scene(const std::filesystem::path& source, const LoadOptions& options) {
  Scene scene = load_scene(source, options);
  if (const auto folder = physdreamer_folder(scene)) take_physdreamer_settings(scene, *folder);
  return scene;
}

/// Keeps the up direction of a run that was made with the mean of the cameras' picture-up.
void keep_mean_up(const RunDirectory& run, Scene& scene, const LoadOptions& options) {
  const json segment = run.last_record("segment");
  const json up = segment.is_object() ? segment.value("scene", json::object()).value("up", json()) : json();
  if (options.up || scene.settings.up || scene.cameras_are_orbit || !up.is_array() || up.size() != 3) return;
  const Eigen::Vector3d recorded(up[0], up[1], up[2]);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Camera& camera : scene.cameras) mean -= camera.cam_from_world.linear().row(1).transpose();
  if ((recorded - mean.normalized()).norm() > 1e-9 || recorded == scene.up) return;
  scene.up = recorded;
  scene.up_source = "mean up of the cameras, with which this run was made";
}

}  // namespace

Scene attach_scene(const Context& context, RunDirectory& run, const std::filesystem::path& source,
                   const LoadOptions& options) {
  if (is_run_directory(source)) {
    const json made_from = RunDirectory::open(source).scene();
    throw usage_error(source.string(), "", "is a run directory, not a scene",
                      made_from.is_object() ? "give its scene, " + made_from.value("source", std::string()) +
                                                  ", with --out " + source.string()
                                            : std::string("give a scene"));
  }
  check_name(run.path().string());
  const json record = recorded(source, options);
  check_name(record["source"]);
  // Later stages read the path as it is recorded, beside which there may be other files than beside a link to it.
  Scene scene = load_any_scene(record["source"].get<std::string>(), options);
  if (!context.overwrite) keep_mean_up(run, scene, options);
  check_names(scene);
  refuse_unused(options, scene);
  const bool changed = run.scene() != record;
  run.set_scene(record, context.overwrite);
  if (changed) forget_assumed_height(run, scene);
  for (const std::string& warning : scene.warnings) context.progress.warn(warning);
  context.progress.say(fmt::format("scene: {} Gaussians, {} cameras{}; up: {}", scene.cloud.size(),
                                   scene.cameras.size(), scene.cameras_are_orbit ? " (orbit)" : "", scene.up_source));
  if (options.object_height == 0 && !options.metres_per_unit && !scene.settings.metres_per_unit)
    context.progress.say(
        "scene: the length of a unit is unknown and assumed to be 1 m (--metres-per-unit, --object-height)");
  scale_by_object(run, scene);
  return scene;
}

void refuse_unused(const LoadOptions& options, const Scene& scene) {
  if (options.orbit_views && !scene.cameras_are_orbit)
    throw usage_error("--orbit-views", std::to_string(*options.orbit_views), "does nothing: the scene has cameras",
                      "leave it out");
}

Scene load_run_scene(const RunDirectory& run) {
  const json& record = run.scene();
  if (!record.is_object())
    throw usage_error(run.path().string(), "scene", "is not recorded", "run `pliant segment SCENE --out DIR` first");
  LoadOptions options;
  if (record.contains("orbit_views")) options.orbit_views = record["orbit_views"].get<int>();
  if (record.contains("level")) options.level = record["level"].get<int>();
  if (record.contains("up")) options.up = Eigen::Vector3d(record["up"][0], record["up"][1], record["up"][2]);
  if (record.contains("metres_per_unit")) options.metres_per_unit = record["metres_per_unit"].get<double>();
  options.object_height = record.value("object_height", 0.0);
  Scene scene = load_any_scene(record["source"].get<std::string>(), options);
  keep_mean_up(run, scene, options);
  scale_by_object(run, scene);
  return scene;
}

void scale_by_object(const RunDirectory& run, Scene& scene) {
  const json assumed = run.note("assumed_height");
  if (assumed.is_number() && !scene.settings.metres_per_unit) scene.object_height = assumed;
  if (scene.object_height > 0 && run.has("extract"))
    scene.metres_per_unit = scene.object_height / extracted(run, {"height"})["height"].get<double>();
}

void forget_assumed_height(RunDirectory& run, Scene& scene) {
  if (!run.note("assumed_height").is_number()) return;
  run.set_note("assumed_height", {});
  scene.object_height = run.scene().value("object_height", 0.0);
  if (!run.scene().contains("metres_per_unit") && !scene.settings.metres_per_unit) scene.metres_per_unit = 1;
}

bool reads_present(const RunDirectory& run, const std::string& stage, const std::string& role) {
  const json inputs = run.manifest()["stages"][stage].value("inputs", json::object());
  const std::filesystem::path file = run / (object_folder(run) + "/" + role + ".h5");
  return !inputs.contains(role) || (std::filesystem::exists(file) && inputs[role] == hash_of_input(file));
}

bool is_fitted(const RunDirectory& run) {
  if (!run.has("fit")) return false;
  const json outputs = run.manifest()["stages"]["fit"].value("outputs", json::array());
  return std::any_of(outputs.begin(), outputs.end(), [](const json& output) {
    return std::filesystem::path(output.get<std::string>()).filename() == "material.h5";
  });
}

std::string fit_is_of(const RunDirectory& run, const Scene& scene) {
  if (!is_fitted(run)) return "";
  const json& record = run.manifest()["stages"]["fit"];
  if (!reads_present(run, "fit", "particles")) return "other particles";
  const bool same = record["scene"].value("metres_per_unit", scene.metres_per_unit) == scene.metres_per_unit;
  return same ? "" : "another scale";
}

void check_simulated(const RunDirectory& run) {
  run.summary("simulate", "run `pliant simulate` first");
  if (!reads_present(run, "simulate", "particles"))
    throw usage_error(run.path().string(), "simulate", "used particles that have since been replaced by `seed`",
                      "run `pliant simulate` again");
}

json extracted(const RunDirectory& run, const std::vector<std::string>& names) {
  const json& all = run.summary("extract", "run `pliant extract DIR --object NAME` first");
  json out = json::object();
  for (const std::string& name : names)
    if (all.contains(name)) out[name] = all[name];
  return out;
}

std::string object_folder(const RunDirectory& run) {
  return run.summary("extract", "run `pliant extract DIR --object NAME` first")["folder"];
}

}  // namespace pliant
