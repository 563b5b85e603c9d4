#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "app/commands/stage_options.h"
#include "app/render/pictures.h"
#include "app/render/render_stage.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

OptionTable picture_options(PictureOptions& pictures) {
  return {"images",
          {{.name = "background",
            .field = &pictures.background,
            .help = "Background color in 0..1 (default: the scene's, else black)",
            .value = "r,g,b",
            .low = 0,
            .high = 1,
            .numbers = 3},
           {.name = "depth", .field = &pictures.depth, .help = "Also write depth images (near = bright)"}}};
}

/// Options of the clip that are also those of the images or the video of a scene, with the help of both.
const std::map<std::string, std::string> kShared = {
    {"camera",
     "The only camera of a scene that is rendered; of a clip: its camera (default: one that sees the object)"},
    {"cameras",
     "Cameras of a scene: 'scene', 'orbit', a camera file or a camera path (nerfstudio); of a clip: its path"},
    {"clip-fps", "Frames per second of the video of a scene, or of the clips (default: the path's or simulation's)"},
    {"size", ""}};

OptionTable clip_options(RenderStage& stage) {
  OptionTable table = options_of(stage);
  for (Option& option : table.options)
    if (const auto shared = kShared.find(option.name); shared != kShared.end() && !shared->second.empty())
      option.help = shared->second;
  return table;
}

OptionTable without_shared(OptionTable table) {
  std::erase_if(table.options, [](const Option& option) { return kShared.count(option.name) > 0; });
  return table;
}

}  // namespace

void add_render(CLI::App& app, Program& program) {
  CLI::App* command = app.add_subcommand("render", "Render images of a scene, or the clip of a run directory");
  struct Options {
    SceneOptions scene;
    RenderStage stage;
    PictureOptions pictures;
  };
  auto options = std::make_shared<Options>();
  add_scene_options(*command, program, options->scene, {},
                    "Splat file, model or scene.json folder, or a run directory");
  add_options(*command, program, clip_options(options->stage));
  add_options(*command, program, picture_options(options->pictures));
  add_out(*command, program, "For a scene: folder for the images, or an .mp4 file")->option_text("DIR|FILE");
  add_common(*command, program);
  command->callback([options, command, &program] {
    program.action = [options, command, &program](Context& context) -> nlohmann::json {
      const std::filesystem::path source = options->scene.source;
      if (is_run_directory(source)) {
        const Unused of_scenes = {
            "does nothing for a run directory, whose clip is rendered", "leave it out, or render the scene", {}};
        refuse_given(*command, options_of(options->scene), of_scenes);
        refuse_given(*command, picture_options(options->pictures), of_scenes);
        if (!program.out.empty()) throw usage_error("render", "--out", of_scenes.why, of_scenes.advice);
        RunDirectory run = RunDirectory::open(source);
        const Scene scene = load_run_scene(run);
        warn_of_selection(context, run);
        return run_render(context, run, scene, options->stage);
      }
      refuse_given(
          *command, without_shared(options_of(options->stage)),
          {"does nothing for a scene, which stands still", "leave it out, or render the clip of a run directory", {}});
      if (program.out.empty()) throw CLI::RequiredError("--out");
      const OptionTable clip = options_of(options->stage);
      if (is_video_out(program.out)) {
        refuse_given(*command, picture_options(options->pictures),
                     {"does nothing for a video", "leave it out, or give a folder", {"depth"}});
        refuse_given(*command, clip,
                     {"chooses one image, and a video goes through all cameras", "give a folder", {"camera"}});
      } else {
        refuse_given(*command, clip, {"does nothing for images", "leave it out, or give an .mp4", {"clip-fps"}});
      }
      const Scene scene = load_scene(source, options->scene.load_options());
      refuse_given(*command, options_of(options->scene),
                   {"does nothing for images", "leave it out", {"metres-per-unit", "object-height"}});
      const std::string& cameras = options->pictures.cameras = options->stage.shot.path;
      options->pictures.camera = options->stage.shot.camera;
      options->pictures.fps = options->stage.shot.fps;
      options->pictures.size = options->stage.shot.size;
      const bool of_scene = cameras.empty() || cameras == "scene";
      const bool orbit = cameras == "orbit" || (of_scene && scene.cameras_are_orbit);
      if (!orbit)
        refuse_given(*command, options_of(options->scene),
                     {"does nothing where no orbit is rendered", "add --cameras orbit", {"up", "orbit-views"}});
      options->pictures.orbit_views = options->scene.orbit_views;
      warn_of_scene(context, scene);
      return render_pictures(context, scene, options->pictures, program.out);
    };
  });
}

}  // namespace pliant
