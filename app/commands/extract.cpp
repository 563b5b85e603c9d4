#include "app/commands/stage_options.h"
#include "app/segment/extract_stage.h"

namespace pliant {

void add_extract(CLI::App& app, Program& program) {
  add_stage_command<ExtractStage>(app, program, "extract", "Cut one object out of the scene", run_extract);
}

}  // namespace pliant
