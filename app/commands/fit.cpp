#include "app/commands/stage_options.h"
#include "app/fit/fit_stage.h"

namespace pliant {

void add_fit(CLI::App& app, Program& program) {
  add_stage_command<FitStage>(app, program, "fit",
                              "Estimate the object's material from a video of its motion, or from markers on it",
                              run_fit, nullptr, "Replace an earlier fit without keeping it");
}

}  // namespace pliant
