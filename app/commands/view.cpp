#include <nlohmann/json.hpp>

#include "app/choose/chooser.h"
#include "app/choose/opener.h"
#include "app/commands/stage_options.h"
#include "app/live/live_view.h"
#include "app/run/attach_scene.h"
#include "app/run/scene_parts.h"
#include "app/segment/segment_stage.h"
#include "gaussians/base/error.h"

namespace pliant {
using nlohmann::json;

namespace {

struct Viewed {
  RunDirectory run;
  Scene scene;
  bool simulated = false;  ///< an object of the scene as it is now
};

/// The run directory, or that of a scene, whose objects are found where that is not done for its splats as they are.
Viewed open_viewed(const Context& context, const std::string& source, const std::string& out) {
  const bool is_run = is_run_directory(source);
  if (is_run && !out.empty())
    throw usage_error("--out", out, "was given together with a run directory", "leave it out, or name the scene");
  RunDirectory run =
      is_run ? RunDirectory::open(source) : RunDirectory::create(out.empty() ? default_out(source, "run") : out);
  // The options that a known scene was loaded with stay.
  Scene scene = is_run || is_recorded_scene(run, source) ? load_run_scene(run)
                                                         : attach_scene(context, run, source, recorded_options(run));
  StageKey key;
  key.inputs = record_of({ScenePart::kSplats}, scene).files;
  const json splats = splats_of(record_of(key, context.seed)["inputs"]);
  const auto has_read = [&](const char* stage) {
    return run.has(stage) && splats_of(run.manifest()["stages"][stage]["inputs"]) == splats;
  };
  if (!has_read("segment")) run_segment(context, run, scene, {});
  // Another object, or new particles of this one, may have been made since: where that was cancelled, there is no
  // motion.
  const bool simulated =
      run.has("simulate") && has_read("extract") && seeds_object(run) && reads_present(run, "simulate", "particles");
  return {std::move(run), std::move(scene), simulated};
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
  const auto run_of = [&](const std::filesystem::path& scene) { return folder / default_out(scene.string(), "run"); };
  Opener opener(context, site, folder, run_of, [&](const Context& opening, const std::filesystem::path& scene) {
    viewed = std::make_unique<Viewed>(open_viewed(opening, scene.string(), run_of(scene).string()));
    chooser = std::make_unique<Chooser>(context, viewed->run, viewed->scene, site);
    chooser->show();
  });
  site.take_files([&](const std::string& name, const std::filesystem::path& file) { return opener.take(name, file); });
  opener.show();
  LocalServer server(options.server, site.handler());
  return serve(context, options, server, site);
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
    program.ends_when_interrupted = true;
    program.action = [=, &program](Context& context) {
      if (source->empty()) return view_dropped(context, *options, program.out.empty() ? "." : program.out);
      LiveSite site;
      std::unique_ptr<Viewed> viewed;
      std::unique_ptr<Chooser> chooser;
      // An address that cannot be used is refused before minutes of work; clients end before what they use.
      LocalServer server(options->server, site.handler());
      viewed = std::make_unique<Viewed>(open_viewed(context, *source, program.out));
      if (viewed->simulated && !options->choose) {
        site.show(live_screen(context, viewed->run, viewed->scene, context.progress));
      } else {
        chooser = std::make_unique<Chooser>(context, viewed->run, viewed->scene, site);
        chooser->show();
      }
      return serve(context, *options, server, site);
    };
  });
}

}  // namespace pliant
