#include "app/commands/stage_options.h"
#include "app/seed/seed_stage.h"

namespace pliant {

void add_seed(CLI::App& app, Program& program) {
  add_stage_command<SeedStage>(app, program, "seed", "Fill the object and place the driving particles", run_seed,
                               check_given);
}

}  // namespace pliant
