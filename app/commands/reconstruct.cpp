#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/commands/stage_options.h"
#include "app/reconstruct/trained_scene.h"

namespace pliant {

void add_reconstruct(CLI::App& app, Program& program) {
  CLI::App* command = app.add_subcommand("reconstruct", "Train a scene from photos with camera poses");
  struct Options {
    std::string source;
    ReconstructStage stage;
  };
  auto options = std::make_shared<Options>();
  command
      ->add_option(
          "PHOTOS", options->source,
          "Folder with photos and cameras (transforms.json, COLMAP, cameras.json, *_par.txt), or a camera file")
      ->required();
  add_options(*command, program, options_of(options->stage));
  add_out(*command, program, "Scene folder to make or continue (default: PHOTOS_scene)");
  add_overwrite(*command, program, "Replace an earlier training without keeping it");
  add_common(*command, program);
  command->callback([options, command, &program] {
    program.action = [options, command, &program](Context& context) {
      check_given(*command, options->stage);
      const std::string out = program.out.empty() ? default_out(options->source, "scene") : program.out;
      refuse_own_source(out, find_photo_set(options->source, options->stage.photos), options->stage);
      RunDirectory run = RunDirectory::create(out);
      const nlohmann::json summary = run_reconstruct(context, run, options->source, options->stage);
      context.progress.say(fmt::format("scene: {}", run.path().string()));
      return summary;
    };
  });
}

}  // namespace pliant
