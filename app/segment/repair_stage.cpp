#include "app/segment/repair_stage.h"

#include <nlohmann/json.hpp>

#include "app/run/attach_scene.h"
#include "app/segment/interruption.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "segmentation/repair/repair.h"

namespace pliant {
using nlohmann::json;

namespace {

json repair_background(const Context& context, const RunDirectory& run, const StageInputs<RepairStage>& in,
                       const std::string&) {
  const std::unique_ptr<Inpainter> inpainter = make_inpainter(in.options.models);
  const GaussianCloud background = read_ply(in.files.at("background")), object = read_ply(in.files.at("object"));
  const std::vector<Camera>& cameras = in.scene.cameras;
  context.progress.begin("repair", 100);
  RepairOptions options;
  options.render.antialiased = in.scene.report.antialiased;
  options.repair_shadow = in.options.shadow == "repair";
  const RepairResult result = repair(
      options, background, object, cameras,
      [&](double done) {
        stop_if_interrupted(context, "repair");
        context.progress.done(static_cast<int>(100 * done));
      },
      inpainter.get());
  context.progress.end();
  write_ply(run / "background_repaired.ply", result.background, in.scene.report.antialiased, in.scene.report.z_is_up);
  RenderOptions shown = options.render;
  shown.background = in.scene.settings.background_color();
  write_image(run / "repair.png", repair_sheet(result, background, object, cameras, shown));
  const RepairSummary& s = result.summary;
  if (!s.views.empty() && !s.object_seen)
    context.progress.warn(
        "no camera shows the object, so the hole behind it is not filled: check the cameras, or extract another "
        "object");
  context.progress.say("repair: " + s.describe());
  if (const std::string shadow = s.describe_shadow(); !shadow.empty()) context.progress.say("repair: " + shadow);
  return {{"views", s.views},
          {"hole_before", s.hole_before},
          {"hole_after", s.hole_after},
          {"planes", s.planes},
          {"plane_gaussians", s.plane_gaussians},
          {"view_gaussians", s.view_gaussians},
          {"unobserved", s.unobserved},
          {"outside_change", s.outside_change},
          {"shadow", s.describe_shadow()},
          {"shadow_gaussians", s.shadow_gaussians},
          {"replaced", result.replaced.size()},
          {"inpainted_views", s.inpainted_views},
          {"refined", s.refinement.kept},
          {"mse_before_refinement", s.refinement.mse_before},
          {"mse_after_refinement", s.refinement.mse_after}};
}

}  // namespace

StageInputs<RepairStage> inputs_of(const RunDirectory& run, const Scene& scene, const RepairStage& stage) {
  StageInputs<RepairStage> in;
  in.options = stage;
  in.parts = {ScenePart::kDrawing, ScenePart::kCameras};
  in.scene = only(in.parts, scene);
  in.files = {{"object", run / (object_folder(run) + "/object.ply")}, {"background", run / "background.ply"}};
  in.outputs = {"background_repaired.ply", "repair.png"};
  return in;
}

json run_repair(const Context& context, RunDirectory& run, const Scene& scene, const RepairStage& stage) {
  return run_stage(context, run, inputs_of(run, scene, stage), repair_background);
}

OptionTable options_of(RepairStage& stage) {
  return {"repair",
          {{.name = "shadow",
            .field = &stage.shadow,
            .help = "Contact shadow of the object on its support",
            .choices = {"repair", "keep"}},
           {.name = "inpainter",
            .field = &stage.models.inpainter,
            .help = "Inpainting network: LaMa",
            .value = "FILE",
            .exists = true,
            .recorded = Recorded::kContents},
           {.name = "trust-torchscript",
            .field = &stage.models.trust_torchscript,
            .help = "Run a TorchScript file: it is a program with all your permissions",
            .recorded = Recorded::kElsewhere}}};
}

}  // namespace pliant
