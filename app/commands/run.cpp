#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/commands/report.h"
#include "app/commands/stage_options.h"
#include "app/fit/fit_video.h"
#include "app/import/interactions.h"
#include "app/page/page_stage.h"
#include "app/predict/prepare_object.h"
#include "app/reconstruct/photo_set.h"
#include "app/render/render_stage.h"
#include "app/run/attach_scene.h"
#include "app/simulate/simulate_stage.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "segmentation/models/make_models.h"

namespace pliant {
namespace {

struct RunOptions {
  SceneOptions scene;
  ReconstructStage reconstruct;
  SegmentStage segment;
  ExtractStage extract;
  RepairStage repair;
  SeedStage seed;
  PredictStage predict;
  FitStage fit;
  bool use_video = true;
  SimulateStage simulate;
  RenderStage render;
  PageStage page;
};

/// Why nothing is fitted; empty where a video, or markers, say what the object is made of.
std::string why_no_fit(const Scene& scene, const RunOptions& options) {
  const FitStage& fit = options.fit;
  if (!options.use_video) return "with --no-video";
  if (options.simulate.material.young) return "with --young, which sets the material";
  if (!options.simulate.physgaussian.empty()) return "with --physgaussian, which sets the material";
  const bool seen =
      has_video(scene, fit) || !fit.markers.file.empty() || !fit.compare.guide.empty() || fit.released_young;
  return seen ? "" : "without a reference video";
}

/// Refuses options that would do nothing, or cannot be, before any work is done.
void check_choice(const RunDirectory& run, const Scene& scene, const CLI::App& command, RunOptions& options,
                  const std::string& no_fit) {
  check_render_stage(scene, options.render);
  SimulateStage simulate = options.simulate;
  if (!simulate.interactions.empty())
    parse_interactions(read_text(simulate.interactions), {scene.metres_per_unit, scene.up}, simulate.interactions);
  // What will be predicted may be anything here.
  if (needs_prediction(scene, options.predict, simulate)) {
    PredictStage predict = options.predict;
    predict.given = simulate.material;
    check_predict_stage(predict);
    simulate.material.young = simulate.material.young.value_or(kUnknownYoung);
    simulate.material.poisson = simulate.material.poisson.value_or(0.3);
    simulate.material.density = simulate.material.density.value_or(1000);
    // So may its law, unless a fit comes first, which takes no law from a prediction.
    const bool law_known = !simulate.material.law.empty() || !scene.settings.material.law.empty();
    if (!no_fit.empty() && !law_known) simulate.material.constants.clear();
  } else {
    refuse_given(command, options_of(options.predict), {"does nothing: the material is known", "leave it out", {}});
    if (no_fit.empty() && options.fit.initial_material == kPredictedMaterial)
      throw usage_error("run", options.fit.typed("initial-material") + " " + kPredictedMaterial,
                        "asks for a prediction, and the material is known", "add --label TEXT, or leave it out");
  }
  if (!no_fit.empty()) {
    check_no_fit_stage(options.fit, no_fit, "leave it out, or allow the material to be fitted");
    check_material(scene, simulate);
    return;
  }
  FitStage fit = options.fit;
  if (!fit.initial_material.empty()) fit.material = options.simulate.material;
  check_fit_stage(fit, has_video(scene, fit));
  check_material(scene, simulate.material, SetBy::kFit);
  if (!run.has("fit")) require_networks(fit);
  if (kind_of(options.fit, scene) == FitKind::kVideo && simulate.material_file.empty())
    refuse_given(
        command, options_of(simulate),
        {"does nothing where the fitted motion is replayed", "leave it out, or add --no-video", {"auto-push"}});
}

/// The page, with the report even where it does not fit; one that is larger than a size that nobody chose is left out.
void make_page(const Context& context, RunDirectory& run, const Scene& scene, PageStage page, bool chosen,
               const std::string& command) {
  page.command = command;
  try {
    run_page(context, run, scene, page);
  } catch (const Error& error) {
    if (error.failure != Failure::kUsage) throw;
    if (!shows_motion(run, "page")) drop_page(run);
    if (chosen) {
      write_report(run, scene, command);
      throw;
    }
    context.progress.warn(std::string("no clip.html: ") + error.what());
  }
}

nlohmann::json run_all(Context& context, const Program& program, const CLI::App& command, RunOptions& options) {
  check_given(command, options.segment);
  check_given(command, options.repair);
  check_given(command, options.seed);
  check_given(command, options.simulate);
  if (!options.page.html)
    refuse_given(command, options_of(options.page),
                 {"does nothing with --no-html", "leave it out", {"html-size", "html-license"}});
  make_inpainter(options.repair.models);  // one that cannot be loaded is refused
  RunDirectory run = RunDirectory::create(program.out.empty() ? default_out(options.scene.source, "run") : program.out);
  if (lacks_splats(options.scene.source)) {
    Scene untrained;
    untrained.settings = find_photo_set(options.scene.source, options.reconstruct.photos).settings;
    check_choice(run, untrained, command, options, why_no_fit(untrained, options));
  }
  Scene scene = attach_or_reconstruct(context, command, run, options.scene, options.reconstruct, options.segment);
  const std::string no_fit = why_no_fit(scene, options);
  const bool fits = no_fit.empty();
  check_choice(run, scene, command, options, no_fit);
  run_segment(context, run, scene, options.segment);
  ExtractStage extract = options.extract;
  extract.label = options.predict.label;
  if (extract.object.empty() && !options.segment.physgaussian.empty()) extract.object = "object";
  SimulateStage simulate = options.simulate;
  const nlohmann::json prediction =
      prepare_object(context, run, scene, {extract, options.repair, options.seed, options.predict}, simulate);
  if (fits) {
    FitStage fit = options.fit;
    if (!fit.kinematic()) {
      fit.material = options.simulate.material;
      if (!prediction.is_null() && fit.initial_material.empty())
        start_from_prediction(prediction, scene, options.predict, fit.material);
      if (!fit.released_young) fit.solver = options.simulate.solver;
      // The fit will have used them.
      simulate.material.poisson.reset();
      simulate.material.density.reset();
    }
    run_fit(context, run, scene, fit);
  } else if (is_fitted(run) || is_refit_unfinished(run)) {
    simulate.use_fit = false;
    context.progress.say("simulate: the existing fit is not used " + no_fit);
  }
  run_simulate(context, run, scene, simulate);
  run_render(context, run, scene, options.render);
  if (options.page.html) {
    const bool chosen = !given_option(command, options_of(options.page), {"html-size"}).empty();
    make_page(context, run, scene, options.page, chosen, program.command_line);
  } else {
    drop_page(run);
  }
  write_report(run, scene, program.command_line);
  context.progress.say(
      fmt::format("clip: {}\nreport: {}", (run / "clip.mp4").string(), (run / "report.html").string()));
  if (run.has("page")) context.progress.say(fmt::format("page: {}", (run / "clip.html").string()));
  return run.manifest();
}

}  // namespace

void add_run(CLI::App& app, Program& program) {
  CLI::App* command =
      app.add_subcommand("run", "All stages: from a scene, or photos with cameras, to a clip of the moving object");
  auto options = std::make_shared<RunOptions>();
  const Spelling spelling{.own = false, .left_out = {"physgaussian"}};
  Spelling simulate = spelling, seed = spelling, fit = spelling, render = spelling;
  simulate.left_out.insert("no-fit");
  seed.left_out.insert("material");
  render.left_out.insert("recorded");
  Spelling predict = spelling;
  predict.left_out = {"young", "poisson", "density"};
  fit.left_out.merge(std::set<std::string>{"young", "poisson", "density", "solver"});
  add_scene_options(*command, program, options->scene, spelling);
  add_out(*command, program, "Run directory to make or continue (default: SCENE_run)");
  add_options(*command, program, options_of(options->segment), spelling);
  add_options(*command, program, options_of(options->extract), spelling);
  add_options(*command, program, options_of(options->seed), seed);
  add_options(*command, program, options_of(options->simulate), simulate);
  add_options(*command, program, options_of(options->predict), predict);
  options->fit.prefix = "fit.";
  add_options(*command, program, options_of(options->fit), fit);
  command
      ->add_flag_callback(
          "--no-video", [options] { options->use_video = false; }, "Do not fit the material to the scene's video")
      ->group("Object, material and motion");
  program.renamed["run"]["--until"] +=
      ", a time of the video; to stop after a stage, call the stages one by one, from `pliant segment` on";
  add_options(*command, program, options_of(options->reconstruct), spelling);
  add_options(*command, program, options_of(options->repair), spelling);
  add_options(*command, program, options_of(options->render), render);
  add_options(*command, program, options_of(options->page), spelling);
  program.renamed["run"]["--antialiased"] =
      "--scene.antialiased, or where the scene is yet to be trained --reconstruct.antialiased";
  command
      ->add_option_function<std::string>(
          "--physgaussian",
          [options](const std::string& file) {
            options->segment.physgaussian = options->seed.fill.physgaussian = options->simulate.physgaussian = file;
          },
          "PhysGaussian configuration: object, material, boundaries, time")
      ->check(CLI::ExistingFile)
      ->option_text("FILE")
      ->group("Object, material and motion");
  add_overwrite(*command, program, "Do not keep earlier results; discard manual edits; take another scene");
  add_common(*command, program);
  command->footer("Options of the stages, such as --simulate.fps: pliant run --help-all");
  command->callback([options, command, &program] {
    program.action = [=, &program](Context& context) { return run_all(context, program, *command, *options); };
  });
}

}  // namespace pliant
