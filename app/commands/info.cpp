#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/commands/stage_options.h"
#include "app/import/physdreamer_folder.h"
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

}  // namespace

void add_info(CLI::App& app, Program& program) {
  CLI::App* command = app.add_subcommand("info", "Describe a file or scene: counts, bounds, warnings");
  auto files = std::make_shared<std::vector<std::string>>();
  command->add_option("FILE", *files, "Splat files, camera files or scene folders")->required();
  auto level = std::make_shared<std::optional<int>>();
  add_options(*command, program, {"info", {level_option(*level)}});
  add_common(*command, program);
  command->callback([=, &program] {
    program.action = [=, &program](Context&) {
      nlohmann::json all = nlohmann::json::array();
      for (const std::string& file : *files) {
        all.push_back(describe(file, *level));
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
