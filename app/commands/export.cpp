#include "app/commands/stage_options.h"
#include "app/simulate/export_stage.h"

namespace pliant {

void add_export(CLI::App& app, Program& program) {
  add_stage_command<ExportStage>(app, program, "export", "Write the moving scene as splat files", run_export,
                                 check_given);
}

}  // namespace pliant
