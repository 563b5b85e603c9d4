#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/commands/stage_options.h"
#include "app/fit/fit_video.h"

namespace pliant {
namespace {

struct RunOptions {
  SceneOptions scene;
  ReconstructStage reconstruct;
  SegmentStage segment;
  ExtractStage extract;
  RepairStage repair;
  SeedStage seed;
  FitStage fit;
  bool use_video = true;
  SimulateStage simulate;
  RenderStage render;
};

/// Why nothing is fitted; empty where a video, or markers, say what the object is made of.
std::string why_no_fit(const Scene& scene, const RunOptions& options) {
  const FitStage& fit = options.fit;
  if (!options.use_video) return "with --no-video";
  if (options.simulate.material.young) return "with --young, which says what the object is made of";
  if (!options.simulate.physgaussian.empty()) return "with --physgaussian, which says what the object is made of";
  const bool seen =
      has_video(scene, fit) || !fit.markers.file.empty() || !fit.compare.guide.empty() || fit.released_young;
  return seen ? "" : "without a reference video";
}

nlohmann::json run_all(Context& context, const Program& program, const RunOptions& options) {
  RunDirectory run = RunDirectory::create(program.out);
  const Scene scene = attach_or_reconstruct(context, run, options.scene, options.reconstruct, options.segment);
  const std::string no_fit = why_no_fit(scene, options);
  const bool fits = no_fit.empty();
  if (fits) {
    check_fit_stage(options.fit, has_video(scene, options.fit));
    check_material(scene, options.simulate.material, true);
  } else {
    check_no_fit_stage(options.fit, no_fit, "leave it out, or let the material be fitted");
    check_material(scene, options.simulate);
  }
  run_segment(context, run, scene, options.segment);
  ExtractStage extract = options.extract;
  if (extract.object.empty() && !options.segment.physgaussian.empty()) extract.object = "object";
  run_extract(context, run, scene, extract);
  run_repair(context, run, scene, options.repair);
  SeedStage seed = options.seed;
  if (seed.drivers == "pgas") seed.material_file = options.simulate.material_file;
  run_seed(context, run, scene, seed);
  if (fits) {
    FitStage fit = options.fit;
    fit.material = options.simulate.material;
    run_fit(context, run, scene, fit);
  }
  SimulateStage simulate = options.simulate;
  simulate.use_fit = fits;
  run_simulate(context, run, scene, simulate);
  run_render(context, run, scene, options.render);
  write_report(run, scene, program.command_line);
  context.progress.say(
      fmt::format("clip: {}\nreport: {}", (run / "clip.mp4").string(), (run / "report.html").string()));
  return run.manifest();
}

}  // namespace

void add_run(CLI::App& app, Program& program) {
  CLI::App* command =
      app.add_subcommand("run", "Everything: from a scene, or photos with cameras, to a clip of an object that moves");
  auto options = std::make_shared<RunOptions>();
  add_scene_options(*command, options->scene);
  add_out(*command, program, "Run directory to make or continue")->required();
  add_reconstruct_options(*command, options->reconstruct, "--hold-out-every");
  add_segment_options(*command, options->segment);
  add_extract_options(*command, options->extract);
  add_repair_options(*command, options->repair);
  add_inpainter(*command, options->repair.models);
  add_trust(*command, {&options->segment.label.models, &options->repair.models});
  add_seed_options(*command, options->seed);
  add_fit_options(*command, options->fit, "fit-");
  add_negation(*command, "--no-video", options->use_video, "Do not fit the material to the scene's reference video");
  add_simulate_options(*command, options->simulate);
  add_render_options(*command, options->render);
  add_physgaussian(*command,
                   {&options->segment.physgaussian, &options->seed.physgaussian, &options->simulate.physgaussian});
  add_overwrite(*command, program);
  add_common(*command, program);
  command->callback([options, &program] {
    program.action = [options, &program](Context& context) { return run_all(context, program, *options); };
  });
}

}  // namespace pliant
