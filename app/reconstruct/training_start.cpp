#include "app/reconstruct/training_start.h"

#include <fmt/format.h>

#include "gaussians/base/error.h"
#include "gaussians/io/splats/splats.h"
#include "gaussians/reconstruct/start_cloud.h"
#include "gaussians/reconstruct/trainer.h"
#include "gaussians/reconstruct/triangulate.h"

namespace pliant {
namespace {

/// At most `count` of the points, evenly spread over their order.
void thin_out(SparsePoints& points, size_t count) {
  const size_t n = points.position.size();
  if (n <= count) return;
  for (size_t i = 0; i < count; ++i) {
    const size_t from = i * n / count;
    points.position[i] = points.position[from];
    points.color[i] = points.color[from];
  }
  points.position.resize(count);
  points.color.resize(count);
}

}  // namespace

TrainingStart start_training(const Context& context, const ReconstructStage& stage, SparsePoints points,
                             const TrainingPhotos& photos) {
  const size_t budget = gaussian_budget(stage.train, photos);
  std::string reasons;  // why the kinds that were tried do not do
  const auto from_points = [&](const char* kind, SparsePoints points) -> TrainingStart {
    const size_t found = points.position.size();
    thin_out(points, budget);
    std::string sentence = points.source;
    if (found > budget) sentence += fmt::format("; {} of {} points, the maximum number of Gaussians", budget, found);
    return {cloud_from_points(points.position, points.color),
            {{"kind", kind}, {"points", found}, {"sentence", sentence}}};
  };
  const auto enough = [&](const SparsePoints& points, const char* what) {
    if (points.position.size() >= kFewestStartPoints) return true;
    reasons += fmt::format(
        "{}{}: {}", reasons.empty() ? "" : "; ", what,
        points.empty() ? points.source : fmt::format("only {} points ({})", points.position.size(), points.source));
    return false;
  };
  const auto asked_for = [&](const char* kind) {
    if (stage.start == kind)
      throw usage_error("--init", kind, "is not available: " + reasons, "leave --init out, or give --init random");
  };

  if (stage.start == "auto" || stage.start == "points") {
    if (enough(points, "structure from motion")) return from_points("points", std::move(points));
    asked_for("points");
  }
  if (stage.start == "auto" || stage.start == "triangulate") {
    context.progress.say("reconstruct: matching features between the photos");
    points = triangulate_photos({}, photos);
    if (enough(points, "triangulation")) {
      std::vector<std::string> warnings = photos_without_points(photos, points);
      TrainingStart start = from_points("triangulate", std::move(points));
      start.warnings = std::move(warnings);
      return start;
    }
    asked_for("triangulate");
  }
  const size_t count = std::max<size_t>(1, budget / 4);
  std::string sentence = fmt::format("{} random Gaussians in the sphere that the cameras view", count);
  if (!reasons.empty()) sentence += " (" + reasons + ")";
  std::vector<Camera> cameras;
  for (const TrainingPhoto& photo : photos.photos) cameras.push_back(photo.camera);
  return {random_cloud(cameras, count, context.seed), {{"kind", "random"}, {"points", count}, {"sentence", sentence}}};
}

TrainingStart start_from_splats(const ReconstructStage& stage, const SceneFile& settings, TrainOptions& options) {
  ReadReport report;
  GaussianCloud cloud = read_splats(stage.splats.at(0), &report, stage.level.value_or(kFinestLevel));
  options.render.antialiased |= settings.antialiased.value_or(report.antialiased);
  options.densification = Densification::kNone;
  options.coarse_to_fine = false;
  options.position_rate *= 0.1f;
  if (options.sh_degree < cloud.sh_degree)
    throw usage_error("--reconstruct.sh-degree", std::to_string(options.sh_degree),
                      fmt::format("is below that of the splats, {}, which is kept", cloud.sh_degree),
                      "leave it out, or lower theirs first with `pliant convert --sh-degree`");
  const size_t count = cloud.size();
  const std::string sentence = fmt::format("{} Gaussians from {}", count, stage.splats[0].string());
  return {std::move(cloud),
          {{"kind", "splats"}, {"points", count}, {"sentence", sentence}},
          std::move(report.warnings),
          report.z_is_up};
}

}  // namespace pliant
