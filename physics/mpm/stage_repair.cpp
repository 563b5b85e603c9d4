#include <fmt/format.h>

#include "app/pipeline/photos.h"
#include "app/pipeline/stages.h"
#include "gaussians/io/image_io.h"
#include "gaussians/io/ply.h"
#include "segmentation/repair/repair.h"

namespace pliant {
using nlohmann::json;

json run_repair(const Context& context, RunDirectory& run, const Scene& scene, const RepairStage&) {
  const std::string folder = object_folder(run);
  const StageKey key{"repair",
                     json::object(),
                     {{"object", run / (folder + "/object.ply")}, {"background", run / "background.ply"}},
                     {"background_repaired.ply", "repair.png"}};
  return run.stage(context, key, [&]() -> json {
    const GaussianCloud background = read_ply(run / "background.ply"), object = read_ply(run / (folder + "/object.ply"));
    RepairOptions options;
    options.seed = context.seed;
    options.render.antialiased = scene.report.antialiased;
    options.up = scene.up.cast<float>();
    std::vector<ImageF> photos;
    for (size_t c = 0; c < scene.cameras.size(); ++c) photos.push_back(photo_or_render(scene, static_cast<int>(c)));
    const RepairResult result = repair(options, background, object, scene.cameras, photos);
    write_ply(run / "background_repaired.ply", result.background);
    write_image(run / "repair.png", result.sheet);
    context.progress.say(fmt::format("repair: {} hole pixels in {} views, {} after {} new Gaussians", result.summary.hole_pixels_before,
                                     scene.cameras.size(), result.summary.hole_pixels_after, result.summary.added));
    return {{"hole_pixels_before", result.summary.hole_pixels_before}, {"hole_pixels_after", result.summary.hole_pixels_after},
            {"added", result.summary.added}};
  });
}

}  // namespace pliant
