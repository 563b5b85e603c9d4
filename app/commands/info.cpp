#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/commands/stage_options.h"
#include "app/import/material_fields.h"
#include "app/import/physdreamer_folder.h"
#include "app/run/run_directory.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/scene/describe.h"

namespace pliant {
namespace {

/// What a scene folder of PhysDreamer says besides its splats and cameras.
nlohmann::json describe_physdreamer(const std::filesystem::path& path) {
  const PhysDreamerFolder folder = read_physdreamer_folder(path);
  nlohmann::json videos = nlohmann::json::array();
  for (const auto& video : folder.videos) videos.push_back({{"file", video.file.string()}, {"camera", video.camera}});
  return {{"object_points", folder.object_points.size()},
          {"moving_points", folder.moving_points.size()},
          {"filled_points", folder.filled_points.size()},
          {"stem_points", folder.stem_points.size()},
          {"videos", videos},
          {"masks", folder.masks.size()},
          {"material_field", folder.material_field.string()},
          {"velocity_field", folder.velocity_field.string()},
          {"warnings", folder.warnings}};
}

/// Scene, finished stages and objects of a run directory.
nlohmann::json describe_run(const std::filesystem::path& path) {
  const RunDirectory run = RunDirectory::open(path);
  nlohmann::json out = {{"file", path.string()}, {"kind", "run directory"}};
  if (run.scene().is_object()) out["scene"] = recorded_place(run).string();
  out["stages"] = nlohmann::json::array();
  for (const auto& [stage, record] : run.manifest()["stages"].items()) out["stages"].push_back(stage);
  if (const std::filesystem::path objects = path / "objects.json"; std::filesystem::exists(objects)) {
    out["objects"] = nlohmann::json::array();
    for (const nlohmann::json& object : read_json(objects))
      out["objects"].push_back(object["id"].dump() + " = " + object["name"].get<std::string>());
  }
  return out;
}

nlohmann::json range_of(const std::vector<float>& values) {
  if (values.empty()) return nlohmann::json::array();
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const auto shortened = [](float value) { return std::stod(fmt::format("{:.7g}", value)); };
  return {shortened(*low), shortened(*high)};
}

/// Number of points and ranges of an .npz of material values.
nlohmann::json describe_material(const std::filesystem::path& file) {
  const MaterialFile field = read_material_field(file);
  return {{"file", file.string()},
          {"kind", "material field"},
          {"points", field.young.size()},
          {"young_pa", range_of(field.young)},
          {"poisson", range_of(field.poisson)},
          {"density_kg_m3", range_of(field.density)}};
}

nlohmann::json describe_any(const std::filesystem::path& path, std::optional<int> level) {
  const bool run = is_run_directory(path), field = path.extension() == ".npz" && std::filesystem::is_regular_file(path);
  if ((run || field) && level)
    throw usage_error("--level", "", "does nothing: " + path.string() + " has no splats", "leave it out");
  if (run) return describe_run(path);
  return field ? describe_material(path) : describe(path, level);
}

}  // namespace

void add_info(CLI::App& app, Program& program) {
  CLI::App* command = app.add_subcommand("info", "Describe a file or scene: counts, bounds, warnings");
  auto files = std::make_shared<std::vector<std::string>>();
  command
      ->add_option("FILE", *files,
                   "Splat files, camera files, material fields (.npz), scene folders or run directories")
      ->required();
  auto level = std::make_shared<std::optional<int>>();
  add_options(*command, program, {"info", {level_option(*level)}});
  add_common(*command, program);
  command->callback([=, &program] {
    program.action = [=, &program](Context&) {
      nlohmann::json all = nlohmann::json::array();
      for (const std::string& file : *files) {
        all.push_back(describe_any(file, *level));
        if (!program.json) std::printf("%s\n", description_text(all.back()).c_str());
        if (!is_physdreamer_folder(file)) continue;
        all.back()["physdreamer"] = describe_physdreamer(file);
        if (!program.json) std::printf("PhysDreamer scene: %s\n", all.back()["physdreamer"].dump(2).c_str());
      }
      return all.size() == 1 ? all[0] : all;
    };
  });
}

}  // namespace pliant
