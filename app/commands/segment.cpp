#include "app/commands/command.h"
#include "app/commands/stage_options.h"

namespace pliant {

void add_segment(CLI::App& app, Program& program) {
  CLI::App* command = app.add_subcommand("segment", "2D masks or a selection -> a label for every Gaussian");
  struct Options {
    SceneOptions scene;
    ReconstructStage reconstruct;
    SegmentStage stage;
  };
  auto options = std::make_shared<Options>();
  add_scene_options(*command, options->scene);
  add_reconstruct_options(*command, options->reconstruct, "--hold-out-every");
  add_segment_options(*command, options->stage);
  add_physgaussian(*command, {&options->stage.physgaussian});
  add_out(*command, program, "Run directory to make or continue")->required();
  add_overwrite(*command, program);
  add_common(*command, program);
  command->callback([options, &program] {
    program.action = [options, &program](Context& context) {
      RunDirectory run = RunDirectory::create(program.out);
      const Scene scene = attach_or_reconstruct(context, run, options->scene, options->reconstruct, options->stage);
      return run_segment(context, run, scene, options->stage);
    };
  });
}

}  // namespace pliant
