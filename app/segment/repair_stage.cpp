#include "app/segment/repair_stage.h"

#include <nlohmann/json.hpp>

#include "app/run/attach_scene.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "segmentation/repair/repair.h"

namespace pliant {
using nlohmann::json;

json run_repair(const Context& context, RunDirectory& run, const Scene& scene, const RepairStage& stage) {
  const std::string folder = object_folder(run);
  StageKey key{"repair",
               {{"shadow", stage.shadow}},
               {{"object", run / (folder + "/object.ply")}, {"background", run / "background.ply"}},
               {"background_repaired.ply", "repair.png"}};
  if (!scene.cameras_are_orbit) key.inputs["cameras"] = scene.settings.cameras;
  if (!stage.models.inpainter.empty()) key.inputs["inpainter"] = stage.models.inpainter;
  return run.stage(context, key, [&]() -> json {
    const std::unique_ptr<Inpainter> inpainter = make_inpainter(stage.models);
    const GaussianCloud background = read_ply(run / "background.ply"),
                        object = read_ply(run / (folder + "/object.ply"));
    context.progress.begin("repair", 100);
    RepairOptions options;
    options.repair_shadow = stage.shadow == "repair";
    const RepairResult result = repair(
        options, background, object, scene.cameras,
        [&](double done) { context.progress.done(static_cast<int>(100 * done)); }, inpainter.get());
    context.progress.end();
    write_ply(run / "background_repaired.ply", result.background, scene.report.antialiased);
    write_image(run / "repair.png", repair_sheet(result, background, object, scene.cameras));
    const RepairSummary& s = result.summary;
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
  });
}

OptionTable options_of(RepairStage& stage) {
  return {"repair",
          {{.name = "shadow",
            .field = &stage.shadow,
            .help = "Contact shadow of the object on its support",
            .choices = {"repair", "keep"}},
           {.name = "inpainter",
            .field = &stage.models.inpainter,
            .help = "Network that fills holes: LaMa",
            .value = "FILE"},
           {.name = "trust-torchscript",
            .field = &stage.models.trust_torchscript,
            .help = "Run a TorchScript file: it is a program and may do anything that you may"}}};
}

}  // namespace pliant
