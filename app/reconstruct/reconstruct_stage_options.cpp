#include <map>

#include "app/reconstruct/reconstruct_stage.h"
#include "gaussians/base/error.h"

namespace pliant {

OptionTable options_of(ReconstructStage& stage) {
  TrainOptions& train = stage.train;
  const auto set_strategy = [&train](const std::vector<std::string>& words) {
    const std::map<std::string, Densification> strategies = {
        {"mcmc", Densification::kMcmc}, {"classic", Densification::kClassic}, {"none", Densification::kNone}};
    train.densification = strategies.at(words.back());
  };
  const auto set_background = [&train](const std::vector<std::string>& words) {
    const std::vector<double> color = parse_numbers("--background", words.back(), 3);
    for (const double value : color)
      if (value < 0 || value > 1) throw usage_error("--background", "", "'" + words.back() + "' is not in 0..1", "");
    train.render.background = Vec3d(color[0], color[1], color[2]).cast<float>();
    train.changing_backdrop = false;
  };
  return {
      "reconstruct",
      {
          {.name = "photos",
           .field = &stage.photos,
           .help = "Folder of the photos, when they are not beside the cameras",
           .value = "DIR"},
          {.name = "time-limit",
           .field = TimeField{&train.seconds},
           .help = "Wall time of the training instead of iterations: 90s, 10m, 1h",
           .value = "TIME",
           .formerly = "time"},
          {.name = "iterations",
           .field = &train.iterations,
           .help = "Photos that the training is shown, one after the other",
           .low = 1,
           .high = 1e7},
          {.name = "max-gaussians",
           .field = CountField{&train.most_gaussians},
           .help = "Limit: 50000, 200k, 1.5M (default: one for 100 pixels of the photos, 20k to 150k)",
           .value = "N",
           .formerly = "gaussians"},
          {.name = "strategy",
           .field = set_strategy,
           .help = "How Gaussians are added and removed (default mcmc)",
           .choices = {"mcmc", "classic", "none"}},
          {.name = "init",
           .field = &stage.start,
           .help = "Where the Gaussians come from; auto: the first of points, triangulate, random that there is",
           .choices = {"auto", "points", "triangulate", "random"},
           .formerly = "start"},
          {.name = "pose-convention",
           .field = &stage.poses,
           .help = "How the file means its poses; auto: as given, unless the photos contradict",
           .choices = {"auto", "as-given", "inverse", "flipped", "inverse-flipped", "turned"},
           .formerly = "poses"},
          {.name = "max-image-size",
           .field = &stage.photo.longest_side,
           .help = "Larger photos are scaled down to this side [px]; 0 = never",
           .low = 0,
           .formerly = "longest-side"},
          {.name = "sh-degree",
           .field = &train.sh_degree,
           .help = "Degree of the spherical harmonics",
           .low = 0,
           .high = 3},
          {.name = "exposure", .field = &train.exposure, .help = "Train exposure and white balance of each photo"},
          {.name = "background",
           .field = set_background,
           .help = "Color behind the scene and behind photos with alpha, in 0..1 (default: black; behind such photos "
                   "another each time)",
           .value = "r,g,b"},
          {.name = "antialiased", .field = &train.render.antialiased, .help = "Opacity compensation (mip-splatting)"},
          {.name = "hold-out-every",
           .field = &stage.photo.hold_out_every,
           .help = "Measure on every Nth photo and never train on it; 0 = none",
           .low = 0,
           .formerly = "hold-out"},
          {.name = "checkpoint-every",
           .field = &stage.checkpoint_every,
           .help = "Iterations between two checkpoints; 0 = about a minute",
           .low = 0},
      }};
}

}  // namespace pliant
