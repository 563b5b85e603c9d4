#include <nlohmann/json.hpp>

#include "app/choose/chooser.h"
#include "app/commands/stage_options.h"
#include "app/live/live_view.h"
#include "app/run/attach_scene.h"
#include "app/segment/segment_stage.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

struct Viewed {
  RunDirectory run;
  Scene scene;
};

/// The run directory, or that of a scene, whose objects are found where that is not done.
Viewed open_viewed(const Context& context, const std::string& source, const std::string& out) {
  const bool is_run = std::filesystem::exists(std::filesystem::path(source) / "run.json");
  if (is_run && !out.empty())
    throw usage_error("--out", out, "was given together with a run directory", "leave it out, or name the scene");
  RunDirectory run =
      is_run ? RunDirectory::open(source) : RunDirectory::create(out.empty() ? default_out(source, "run") : out);
  Scene scene = is_run ? load_run_scene(run) : attach_scene(context, run, source, {});
  if (!run.has("segment")) run_segment(context, run, scene, {});
  return {std::move(run), std::move(scene)};
}

}  // namespace

void add_view(CLI::App& app, Program& program) {
  CLI::App* command =
      app.add_subcommand("view", "Open a scene or a run in the browser: choose an object and move it by hand");
  auto source = std::make_shared<std::string>();
  auto options = std::make_shared<ViewOptions>();
  command->add_option("SCENE", *source, "Scene, or a run directory")->required();
  add_options(*command, program, options_of(*options));
  add_out(*command, program, "Run directory to make for a scene or continue (default: SCENE_run)");
  add_common(*command, program);
  command->callback([=, &program] {
    program.action = [=, &program](Context& context) {
      Viewed viewed = open_viewed(context, *source, program.out);
      LiveSite site;
      Chooser chooser(context, viewed.run, viewed.scene, site);
      if (viewed.run.has("simulate") && !options->choose)
        site.show(live_screen(context, viewed.run, viewed.scene));
      else
        chooser.show();
      return serve(context, *options, site);
    };
  });
}

}  // namespace pliant
