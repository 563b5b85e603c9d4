#include "app/commands/stage_options.h"

namespace pliant {
namespace {

void add_options(CLI::App& command, SimulateStage& stage) {
  add_simulate_options(command, stage);
  add_negation(command, "--no-fit", stage.use_fit, "Do not use what a fit found");
  add_physgaussian(command, {&stage.physgaussian});
}

}  // namespace

void add_simulate(CLI::App& app, Program& program) {
  add_stage_command<SimulateStage>(app, program, "simulate", "Move the object under forces (MLS-MPM)", add_options,
                                   run_simulate);
}

}  // namespace pliant
