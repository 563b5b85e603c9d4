#include "app/commands/stage_options.h"
#include "app/segment/repair_stage.h"

namespace pliant {

void add_repair(CLI::App& app, Program& program) {
  add_stage_command<RepairStage>(app, program, "repair", "Fill the hole that the object left in the background",
                                 run_repair, check_given);
}

}  // namespace pliant
