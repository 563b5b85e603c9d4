#include <cstdio>

#include "app/commands/stage_options.h"
#include "gaussians/io/describe.h"

namespace pliant {

void add_info(CLI::App& app, Program& program) {
  CLI::App* command = app.add_subcommand("info", "What a file or scene is: counts, bounds, warnings");
  auto files = std::make_shared<std::vector<std::string>>();
  command->add_option("FILE", *files, "Splat files, camera files or scene folders")->required();
  auto level = std::make_shared<std::optional<int>>();
  add_level(*command, *level);
  add_common(*command, program);
  command->callback([=, &program] {
    program.action = [=, &program](Context&) {
      nlohmann::json all = nlohmann::json::array();
      for (const std::string& file : *files) {
        all.push_back(describe(file, *level));
        if (!program.json) std::printf("%s\n", description_text(all.back()).c_str());
      }
      return all.size() == 1 ? all[0] : all;
    };
  });
}

}  // namespace pliant
