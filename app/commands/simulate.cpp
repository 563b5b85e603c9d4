#include "app/commands/stage_options.h"
#include "app/simulate/simulate_stage.h"

namespace pliant {

void add_simulate(CLI::App& app, Program& program) {
  add_stage_command<SimulateStage>(app, program, "simulate", "Simulate the object under forces (MLS-MPM)", run_simulate,
                                   check_given);
}

}  // namespace pliant
