#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/commands/stage_options.h"
#include "app/simulate/pictures.h"
#include "app/simulate/render_stage.h"

namespace pliant {

void add_render(CLI::App& app, Program& program) {
  CLI::App* command = app.add_subcommand("render", "Pictures of a scene, or the clip of a run directory");
  struct Options {
    SceneOptions scene;
    RenderStage stage;
    PictureOptions pictures;
  };
  auto options = std::make_shared<Options>();
  add_scene_options(*command, program, options->scene);
  add_options(*command, program, options_of(options->stage));
  command->add_option("--cameras", options->pictures.cameras, "Of a scene: 'scene', 'orbit', or a camera file")
      ->capture_default_str();
  command->add_option("--background", options->pictures.background, "Background colour r,g,b in 0..1")
      ->expected(3)
      ->delimiter(',');
  command->add_flag("--depth", options->pictures.depth, "Also write depth pictures (near = bright)");
  command->add_flag("--antialiased", options->pictures.antialiased, "Opacity compensation for mip-trained scenes");
  add_out(*command, program, "Of a scene: folder for the pictures, or a .mp4 file");
  add_overwrite(*command, program);
  add_common(*command, program);
  command->callback([options, &program] {
    program.action = [options, &program](Context& context) -> nlohmann::json {
      const std::filesystem::path source = options->scene.source;
      // A reconstructed scene has a run.json of its own.
      if (std::filesystem::exists(source / "run.json") && !std::filesystem::exists(source / "scene.json")) {
        RunDirectory run = RunDirectory::open(source);
        return run_render(context, run, load_run_scene(run), options->stage);
      }
      if (program.out.empty()) throw CLI::RequiredError("--out");
      const Scene scene = load_scene(source, options->scene.load_options());
      return render_pictures(context, scene, options->pictures, program.out);
    };
  });
}

}  // namespace pliant
