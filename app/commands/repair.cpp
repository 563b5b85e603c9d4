#include "app/commands/stage_options.h"

namespace pliant {
namespace {

void add_options(CLI::App& command, RepairStage& stage) {
  add_repair_options(command, stage);
  add_inpainter(command, stage.models);
  add_trust(command, {&stage.models});
}

}  // namespace

void add_repair(CLI::App& app, Program& program) {
  add_stage_command<RepairStage>(app, program, "repair", "Fill the hole that the object left in the background",
                                 add_options, run_repair);
}

}  // namespace pliant
