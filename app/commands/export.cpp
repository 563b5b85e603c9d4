#include "app/commands/stage_options.h"
#include "app/simulate/export_stage.h"

namespace pliant {
namespace {

void add_export_options(CLI::App& command, ExportStage& stage) {
  command.add_option("--ply-sequence", stage.ply_sequence, "Folder for frame_0000.ply and so on, one file per frame");
  command.add_option("--physgaussian-output", stage.physgaussian_output,
                     "Folder for the h5 and ply files that PhysGaussian writes");
  command
      .add_option("--every", stage.every, "Write every Nth frame of the trajectory; files are numbered without gaps")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command.add_flag("--object-only", stage.object_only, "Leave the background out");
}

}  // namespace

void add_export(CLI::App& app, Program& program) {
  add_stage_command<ExportStage>(app, program, "export", "The moving scene as splat files", add_export_options,
                                 run_export);
}

}  // namespace pliant
