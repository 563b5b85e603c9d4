#include "app/commands/stage_options.h"
#include "app/fit/fit_stage.h"

namespace pliant {
namespace {

void add_options(CLI::App& command, FitStage& stage) {
  add_fit_options(command, stage);
  add_material_values(command, stage.material);
}

}  // namespace

void add_fit(CLI::App& app, Program& program) {
  add_stage_command<FitStage>(app, program, "fit",
                              "Find what the object is made of from a video of its motion, or from markers on it",
                              add_options, run_fit);
}

}  // namespace pliant
