#include "app/commands/stage_options.h"

namespace pliant {

void add_seed(CLI::App& app, Program& program) {
  add_stage_command<SeedStage>(app, program, "seed", "Fill the object and place the driving particles", add_seed_options,
                               run_seed);
}

}  // namespace pliant
