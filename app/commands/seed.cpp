#include "app/commands/stage_options.h"

namespace pliant {
namespace {

void add_options(CLI::App& command, SeedStage& stage) {
  add_seed_options(command, stage);
  command
      .add_option("--material", stage.material_file,
                  "E(x) that --drivers pgas follows, from a material.h5, of these or of other particles (default: the "
                  "same everywhere)")
      ->check(CLI::ExistingFile);
  add_physgaussian(command, {&stage.physgaussian});
}

}  // namespace

void add_seed(CLI::App& app, Program& program) {
  add_stage_command<SeedStage>(app, program, "seed", "Fill the object and place the driving particles", add_options,
                               run_seed);
}

}  // namespace pliant
