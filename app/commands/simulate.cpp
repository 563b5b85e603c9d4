#include <nlohmann/json.hpp>
#include <optional>

#include "app/commands/stage_options.h"
#include "app/live/recording.h"
#include "app/simulate/simulate_stage.h"

namespace pliant {
namespace {

/// `simulate`: a stage of the run, or what a person did to the object in its page.
struct SimulateCommand {
  SimulateStage stage;
  std::string recording;
  bool shortened = false;  ///< --duration of the stage was given
};

OptionTable options_of(SimulateCommand& command) {
  OptionTable table = options_of(command.stage);
  table.options.push_back(
      {.name = "recording",
       .field = &command.recording,
       .help =
           "Replay a recording.json of clip.html into recording.h5; --duration shortens it, no other option is taken",
       .value = "FILE",
       .exists = true});
  return table;
}

void check_given(const CLI::App& app, SimulateCommand& command) {
  if (command.recording.empty()) return check_given(app, command.stage);
  OptionTable table = options_of(command.stage);
  command.shortened = !given_option(app, table, {"duration"}).empty();
  std::erase_if(table.options, [](const Option& option) { return option.name == "duration"; });
  refuse_given(app, table, {"does nothing with --recording, which says what happens", "leave it out", {}});
}

nlohmann::json run_command(const Context& context, RunDirectory& run, const Scene& scene,
                           const SimulateCommand& command) {
  if (command.recording.empty()) return run_simulate(context, run, scene, command.stage);
  const std::optional<double> duration = command.shortened ? std::optional(command.stage.duration) : std::nullopt;
  return replay_recording(context, run, scene, command.recording, duration);
}

}  // namespace

void add_simulate(CLI::App& app, Program& program) {
  add_stage_command<SimulateCommand>(app, program, "simulate", "Simulate the object under forces (MLS-MPM)",
                                     run_command, check_given);
}

}  // namespace pliant
