#include "app/commands/command.h"
#include "app/commands/stage_options.h"
#include "app/segment/edit_stage.h"

namespace pliant {
namespace {

/// `pliant segment edit DIR`; edits are applied in the order in which they are written.
CLI::App* add_edit(CLI::App& segment, Program& program) {
  CLI::App* command = segment.add_subcommand("edit", "Edit the objects of a run directory");
  auto directory = std::make_shared<std::string>();
  auto stage = std::make_shared<EditStage>();
  command->add_option("DIR", *directory, "Run directory")->required();
  const auto edit = [&](const std::string& name, ObjectEdit::Kind kind, const std::string& value,
                        const std::string& description) {
    command
        ->add_option_function<std::string>(
            name, [stage, kind](const std::string& text) { stage->edits.push_back(ObjectEdit::parse(kind, text)); },
            description)
        ->trigger_on_parse()
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast)
        ->option_text(value);
  };
  edit("--merge", ObjectEdit::Kind::kMerge, "ID,ID,...",
       "Merge these objects into the first; repeatable, like the others");
  edit("--split", ObjectEdit::Kind::kSplit, "ID",
       "Split the object into its separate parts, or cut it in two by color and distance");
  edit("--drop", ObjectEdit::Kind::kDrop, "ID",
       "Remove the object; its Gaussians take the label of their surroundings");
  edit("--name", ObjectEdit::Kind::kName, "ID=NAME", "Name the object");
  add_common(*command, program);
  command->callback([=, &program] {
    program.action = [=](Context& context) {
      RunDirectory run = RunDirectory::open(*directory);
      const Scene scene = load_run_scene(run);
      return run_edit(context, run, scene, *stage);
    };
  });
  return command;
}

}  // namespace

void add_segment(CLI::App& app, Program& program) {
  CLI::App* command = app.add_subcommand("segment", "Label every Gaussian from 2D masks or a selection");
  struct Options {
    SceneOptions scene;
    ReconstructStage reconstruct;
    SegmentStage stage;
  };
  auto options = std::make_shared<Options>();
  add_scene_options(*command, program, options->scene);
  add_options(*command, program, options_of(options->stage));
  add_options(*command, program, options_of(options->reconstruct), {.own = false, .left_out = {}});
  add_out(*command, program, "Run directory to make or continue (default: SCENE_run)");
  add_overwrite(*command, program, "Do not keep earlier results; discard manual edits; take another scene");
  add_common(*command, program);
  const CLI::App* edit = add_edit(*command, program);
  command->get_option("SCENE")->required(false);
  command->callback([options, edit, command, &program] {
    if (edit->parsed()) return;
    if (options->scene.source.empty()) throw CLI::RequiredError("SCENE");
    program.action = [options, command, &program](Context& context) {
      check_given(*command, options->stage);
      const std::string out = program.out.empty() ? default_out(options->scene.source, "run") : program.out;
      RunDirectory run = RunDirectory::create(out);
      const Scene scene =
          attach_or_reconstruct(context, *command, run, options->scene, options->reconstruct, options->stage);
      return run_segment(context, run, scene, options->stage);
    };
  });
}

}  // namespace pliant
