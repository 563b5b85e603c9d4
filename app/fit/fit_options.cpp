#include "app/fit/fit_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/simulate/simulate_stage.h"
#include "fitting/fit/fit_physdreamer.h"
#include "gaussians/base/error.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr double kCubeSide = 1.8;     // times the object's longest
constexpr int kGrow = 8;              // px by which the moving mask is grown where pictures are compared
constexpr double kDirectRate = 0.03;  // of ln E where it is a parameter itself, not what a network makes of many
constexpr double kAstray = 0.02;  // of the loss: such a fit begins at an optimum of the tracks, and Adam's steps are as
                                  // large as its rates there too

/// [m] of the cube in which PhysDreamer's code simulates the object.
double edge_of_cube(const FitScene& fit) {
  Box box;
  for (const Vec3f& x : fit.drawn->object.position) box.add(x);
  return kCubeSide * fit.drawn->metres_per_unit * double(box.size().maxCoeff());
}

/// A fit of Poisson's ratio would move the material that it is to start from.
void check_poisson(const FitStage& stage, const Particles& particles) {
  for (const float given : particles.poisson) {
    const float nearest = std::clamp(given, float(kPoissonStart[0]), float(kPoissonStart[1]));
    if (given != nearest)
      throw usage_error("fit", stage.typed("fit-poisson"),
                        fmt::format("fits values from {:g} to {:.3g}, but the material has {:g}", kPoissonStart[0],
                                    kPoissonStart[1], given),
                        "leave it out, or start from another " + stage.typed("poisson"));
  }
}

/// What gradients compare.
ClipTerms clip_terms(const Context& context, const RunDirectory& run, const CompareStage& stage, const FitScene& fit,
                     int first_step) {
  ClipTerms terms;
  terms.drawn = fit.drawn;
  terms.track_weight = stage.loss == "image" ? 0 : 1;
  terms.picture_weight = stage.loss == "tracks" ? 0 : *stage.picture_weight;
  terms.picture.photometric = {stage.lambda, 1 - stage.lambda};
  terms.flow_weight = stage.flow_weight;
  if (terms.picture_weight > 0 || terms.flow_weight > 0)
    for (const FitView* view : fit.views()) {
      std::vector<ImageF> weight(view->compared.size() > 1 ? fit.used : 1, motion_mask(*view, fit.used, kGrow));
      for (size_t f = 0; f < weight.size(); ++f) leave_out(weight[f], *view, static_cast<int>(f));
      terms.seen.push_back(cut_to_weight(view->video.camera, std::span(view->video.frames).first(fit.used), weight));
    }
  if (!stage.guide.empty()) {
    terms.guide = start_guide(context, run, stage, first_step);
    terms.guide_camera = fit.video.camera;
    terms.guide_weight = stage.guide_weight;
  }
  return terms;
}

}  // namespace

SimulateOptions rollout_options(const FitStage& stage) {
  SimulateOptions options;
  options.grid = grid_kind(stage.solver);
  options.object_friction = SimulateStage().contact_friction;
  return options;
}

uint64_t network_seed(const Context& context) { return context.seed - 1; }

std::shared_ptr<Guidance> start_guide(const Context& context, const RunDirectory& run, const CompareStage& stage,
                                      int first_step) {
  GuidanceOptions options;
  options.first_step = first_step;
  options.command = stage.guide;
  options.interrupted = context.interrupted;
  options.step_limit = stage.guide_limit;
  options.start_limit = 2 * stage.guide_limit;
  context.progress.say(fmt::format("fit: waiting for `{}` to be ready", stage.guide));
  auto guide = std::make_shared<Guidance>(options, run / "fit/guide");
  context.progress.say(fmt::format("fit: '{}' scores the rendered motion", guide->name()));
  return guide;
}

MaterialFitOptions material_fit_options(const Context& context, const RunDirectory& run, const Scene& scene,
                                        const FitStage& stage, const FitScene& fit, int first_step) {
  MaterialFitOptions options;
  VibrationFitOptions& vibration = options.vibration;
  vibration.simulate = rollout_options(stage);
  vibration.simulate.gravity = -9.81 * scene.up;
  vibration.search.first = fit.free_after;
  vibration.refine.tolerance = 1e-3;
  vibration.modes.most = 6;
  vibration.most_modes = 4;
  vibration.most_periods = fitted_periods(stage);
  vibration.stop = context.interrupted;
  if (stage.field == "parts") {
    options.kind = MaterialKind::kParts;
    options.part =
        stage.part_labels.empty() ? parts_of(fit, stage.parts) : labelled_parts(fit, scene, stage.part_labels);
    context.progress.say(
        fmt::format("fit: {} parts, each with its own stiffness", *std::ranges::max_element(options.part) + 1));
  }
  if (stage.field == "smooth") options.kind = MaterialKind::kSmooth;
  options.planes.seed = options.kan.seed = network_seed(context);
  if (stage.field == "triplanes") {
    options.kind = MaterialKind::kTriplanes;
  } else if (stage.field == "kan") {
    options.kind = MaterialKind::kKan;
  } else {
    options.gradient.material_rate = kDirectRate;
    options.gradient.astray = kAstray;
  }
  options.gradient.iterations = *stage.compare.iterations;
  options.gradient_window = *stage.compare.window;
  if (stage.physdreamer() && stage.until == 0) options.clip_frames = kPublishedFrames;
  if (stage.released_code()) options.released_code = PhysDreamerCode{.edge = edge_of_cube(fit)};
  options.poisson = stage.compare.poisson;
  if (options.poisson) check_poisson(stage, fit.body.particles);
  options.density = stage.compare.density;
  options.clip = clip_terms(context, run, stage.compare, fit, first_step);
  return options;
}

}  // namespace pliant
