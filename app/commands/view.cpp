#include <nlohmann/json.hpp>

#include "app/commands/stage_options.h"
#include "app/live/live_view.h"

namespace pliant {

void add_view(CLI::App& app, Program& program) {
  CLI::App* command = app.add_subcommand("view", "Open a simulated run in the browser, to be moved by hand");
  auto directory = std::make_shared<std::string>();
  auto options = std::make_shared<ViewOptions>();
  command->add_option("DIR", *directory, "Run directory")->required();
  add_options(*command, program, options_of(*options));
  add_common(*command, program);
  command->callback([=, &program] {
    program.action = [=](Context& context) {
      const RunDirectory run = RunDirectory::open(*directory);
      return run_view(context, run, load_run_scene(run), *options);
    };
  });
}

}  // namespace pliant
