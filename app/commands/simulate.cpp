#include <nlohmann/json.hpp>

#include "app/commands/stage_options.h"
#include "app/live/recording.h"
#include "app/simulate/simulate_stage.h"

namespace pliant {
namespace {

/// `simulate`: a stage of the run, or what a person did to the object in its page.
struct SimulateCommand {
  SimulateStage stage;
  std::string recording;
};

OptionTable options_of(SimulateCommand& command) {
  OptionTable table = options_of(command.stage);
  table.options.push_back({.name = "recording",
                           .field = &command.recording,
                           .help = "Replay a recording.json of clip.html into recording.h5; takes no other option",
                           .value = "FILE",
                           .exists = true});
  return table;
}

void check_given(const CLI::App& app, SimulateCommand& command) {
  if (command.recording.empty()) return check_given(app, command.stage);
  refuse_given(app, options_of(command.stage),
               {"does nothing with --recording, which says what happens", "leave it out", {}});
}

nlohmann::json run_command(const Context& context, RunDirectory& run, const Scene& scene,
                           const SimulateCommand& command) {
  if (command.recording.empty()) return run_simulate(context, run, scene, command.stage);
  return replay_recording(context, run, scene, command.recording);
}

}  // namespace

void add_simulate(CLI::App& app, Program& program) {
  add_stage_command<SimulateCommand>(app, program, "simulate", "Simulate the object under forces (MLS-MPM)",
                                     run_command, check_given);
}

}  // namespace pliant
