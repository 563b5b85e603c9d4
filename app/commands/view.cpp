#include <nlohmann/json.hpp>

#include "app/choose/chooser.h"
#include "app/choose/opener.h"
#include "app/commands/stage_options.h"
#include "app/live/live_view.h"
#include "app/run/attach_scene.h"
#include "app/segment/segment_stage.h"
#include "gaussians/base/error.h"

namespace pliant {
using nlohmann::json;

namespace {

struct Viewed {
  RunDirectory run;
  Scene scene;
};

/// The run directory, or that of a scene, whose objects are found where that is not done.
Viewed open_viewed(const Context& context, const std::string& source, const std::string& out) {
  const std::filesystem::path folder = source;
  // A reconstructed scene has a run.json of its own.
  const bool is_run = std::filesystem::exists(folder / "run.json") && !std::filesystem::exists(folder / "scene.json");
  if (is_run && !out.empty())
    throw usage_error("--out", out, "was given together with a run directory", "leave it out, or name the scene");
  RunDirectory run =
      is_run ? RunDirectory::open(source) : RunDirectory::create(out.empty() ? default_out(source, "run") : out);
  Scene scene = is_run ? load_run_scene(run) : attach_scene(context, run, source, {});
  if (!run.has("segment")) run_segment(context, run, scene, {});
  return {std::move(run), std::move(scene)};
}

/// Shows a page for a scene that is not there yet, then the choice of an object in it.
json view_dropped(const Context& context, ViewOptions options, const std::filesystem::path& folder) {
  if (options.server.allow_remote)
    throw usage_error("view", "--allow-remote", "lets others send files to this machine", "name a scene");
  if (options.choose) throw usage_error("view", "--choose", "does nothing without a run", "name a run directory");
  std::filesystem::create_directories(folder);
  options.server.drop_folder = folder;
  LiveSite site;
  std::unique_ptr<Viewed> viewed;
  std::unique_ptr<Chooser> chooser;
  Opener opener(context, site, folder, [&](const Context& opening, const std::filesystem::path& scene) {
    viewed = std::make_unique<Viewed>(
        open_viewed(opening, scene.string(), (folder / default_out(scene.string(), "run")).string()));
    chooser = std::make_unique<Chooser>(context, viewed->run, viewed->scene, site);
    chooser->show();
  });
  site.take_files([&](const std::string& name, const std::filesystem::path& file) { return opener.take(name, file); });
  opener.show();
  return serve(context, options, site);
}

}  // namespace

void add_view(CLI::App& app, Program& program) {
  CLI::App* command =
      app.add_subcommand("view", "Open a scene or a run in the browser: choose an object and move it by hand");
  auto source = std::make_shared<std::string>();
  auto options = std::make_shared<ViewOptions>();
  command->add_option("SCENE", *source,
                      "Scene, or a run directory; without one, a page on which a file can be dropped");
  add_options(*command, program, options_of(*options));
  add_out(*command, program,
          "Run directory to make for a scene or continue (default: SCENE_run); without SCENE, the folder for what is "
          "dropped");
  add_common(*command, program);
  command->callback([=, &program] {
    program.action = [=, &program](Context& context) {
      if (source->empty()) return view_dropped(context, *options, program.out.empty() ? "." : program.out);
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
