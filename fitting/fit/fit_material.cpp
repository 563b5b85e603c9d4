#include "fitting/fit/fit_material.h"

#include <algorithm>
#include <cmath>

#include "fitting/fields/part_field.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr double kDecade = 2.302585092994046;
constexpr double kMostSigmas = 5;  // of the parameters of a smooth field, that they may reach
constexpr double kCommon = 0.02;  // of ln E: a field has a level of its own

std::shared_ptr<const Field> field_of(const MaterialFitOptions& options, const Particles& particles) {
  switch (options.kind) {
    case MaterialKind::kUniform: return nullptr;
    case MaterialKind::kParts:
      CHECK(options.part.size() == particles.size());
      return std::make_shared<PartField>(options.part, 1);
    case MaterialKind::kTriplanes:
      if (!options.smooth_first) return nullptr;
      [[fallthrough]];
    case MaterialKind::kSmooth: {
      SmoothFieldOptions smooth = options.smooth;
      smooth.level_sigma = std::max(smooth.level_sigma, smooth.sigma);
      return std::make_shared<SmoothField>(smooth, particles.position);
    }
  }
  return nullptr;
}

/// The fitted motion over the frames that were compared.
Motion<float> motion_of(const VibrationFit& fit, const VibrationFitOptions& options, const Particles& particles,
                        const std::vector<Interaction>& interactions, double fps) {
  Motion<float> motion{particles, fit.start, interactions, {}};
  SimulateOptions& simulate = motion.options.simulate;
  simulate = options.simulate;
  simulate.fps = fps * fit.subframes, simulate.substeps = fit.substeps, simulate.damping_time = fit.damping_time;
  simulate.duration = fit.rollout_frame(fit.last_frame, fps) / simulate.fps;
  simulate.settle_time = 0, simulate.sleep_speed = 0;
  return motion;
}

/// Loss as errors of the tracks: it is half the sum of squares.
FitStep step_of(const char* name, const VibrationFit& fit) {
  FitStep step{name, fit.rms, fit.seconds - fit.seconds_search, fit.summary.converged, fit.summary.stopped_by, {}};
  for (const double loss : fit.summary.loss) step.loss.push_back(fit.rms * std::sqrt(loss / std::max(fit.summary.loss.back(), 1e-30)));
  return step;
}

/// A field of factors of E, from the best constant on.
void add_field(const MaterialFitOptions& options, VibrationFitOptions vibration, const std::shared_ptr<const Field>& field,
               const std::vector<Interaction>& interactions, const TrackLoss<float>& tracks, double fps,
               const std::function<void(const std::string&)>& progress, const MaterialFitProgress& kept, MaterialFit& fit) {
  const bool parts = options.kind == MaterialKind::kParts;
  vibration.field = field, vibration.candidates = 1, vibration.refine.max_iterations *= 2;
  vibration.field_sigma = parts ? options.part_sigma * kDecade : 1, vibration.factor_sigma = kCommon;
  vibration.field_limit = parts ? options.decades * kDecade : kMostSigmas;
  vibration.search.low = -0.3, vibration.search.high = 0.3;
  vibration.search.first = fit.homogeneous.first_frame / fps;
  vibration.known_modes = fit.homogeneous.modes.stiffer(std::pow(10.0, fit.homogeneous.log10_factor));
  const Particles base = fit.particles;
  fit.found = kept.field ? *kept.field
                         : fit_vibration(vibration, base, interactions, tracks, fps, progress, kept.homogeneous ? kept.vibration : VibrationFitState{}, kept.keep_vibration);
  if (!kept.field && kept.keep_field) kept.keep_field(fit.found);
  fit.steps.push_back(step_of("field", fit.found));
  fit.particles = fit.found.fitted(base, field.get());
  fit.found.log10_factor += fit.homogeneous.log10_factor;
  fit.sigma = fit.found.young_sigma;
  if (const auto* smooth = dynamic_cast<const SmoothField*>(field.get()))
    for (size_t i = 0; i < fit.sigma.size(); ++i)
      fit.sigma[i] = std::sqrt(fit.sigma[i] * fit.sigma[i] + smooth->variance_left_out(i) / (kDecade * kDecade));
  fit.prior_sigma = parts ? options.part_sigma : options.smooth.sigma / kDecade;
}

/// Exact gradients from what was found on.
void refine_by_gradients(const MaterialFitOptions& options, const VibrationFitOptions& vibration, const std::vector<Interaction>& interactions,
                         const TrackLoss<float>& tracks, double fps, const std::function<void(const std::string&)>& progress,
                         const MaterialFitProgress& kept, MaterialFit& fit) {
  const VibrationFit& found = fit.found;
  const ClipFrames frames{found.first_frame, found.last_frame, found.rollout_frame(found.first_frame, fps), found.subframes, fps};
  Motion<float> motion = motion_of(found, vibration, fit.particles, interactions, fps);
  motion.options.gradient_window = options.gradient_window * frames.every;
  ClipFitOptions varied = gradient_fields(options, fit.particles);
  varied.gradient.first_window = frames.lead + frames.every * varied.gradient.first_window;
  const ClipFit clip = fit_clip(varied, motion, clip_objective(options.clip, &tracks, frames), kept.gradient, progress, kept.keep_gradient);
  const Motion<float>& best = clip.motion;
  fit.particles = best.particles, fit.found.start = best.start, fit.found.damping_time = best.options.simulate.damping_time;
  fit.found.substeps = best.options.simulate.substeps;
  fit.iterations = clip.iterations, fit.sigma.clear();
  const Rollout<float> run = rollout<float>(best.options, best.particles, best.interactions, best.start);
  fit.found.rms = tracks.on_rollout(frames.first, frames.last, frames.lead, frames.every).rms(run.frames);
  FitStep step{"gradients", fit.found.rms, clip.seconds, clip.stopped_by != "iterations", clip.stopped_by, {}};
  // As if all frames were compared from the first iteration on.
  for (const GradientFitRow& row : clip.iterations) step.loss.push_back(row.loss * clip.iterations.back().frames / row.frames);
  fit.steps.push_back(std::move(step));
}

}  // namespace

ClipFitOptions gradient_fields(const MaterialFitOptions& options, const Particles& particles) {
  ClipFitOptions varied;
  varied.gradient = options.gradient;
  if (options.kind == MaterialKind::kTriplanes) {
    TriplaneOptions planes = options.planes, velocity_planes = options.planes;
    planes.low = {-kDecade * options.decades}, planes.high = {kDecade * options.decades};
    velocity_planes.channels = 3, velocity_planes.resolution = 24;
    varied.material = make_triplane_field(planes, particles.position), varied.velocity = make_triplane_field(velocity_planes, particles.position);
  } else {
    varied.material = field_of(options, particles);
    if (!varied.material) varied.material = std::make_shared<PartField>(particles.size(), 1);
    varied.gradient.material_limit = options.kind == MaterialKind::kSmooth ? kMostSigmas : options.decades * kDecade;
  }
  if (options.poisson) varied.poisson = std::make_shared<PartField>(particles.size(), 1);
  if (options.clip.guide_weight > 0) varied.gradient.noisy = true, varied.gradient.growth = 0;
  return varied;
}

MaterialFit fit_material(const MaterialFitOptions& options, const Particles& particles, const std::vector<Interaction>& interactions,
                         const TrackLoss<float>& tracks, double fps, const std::function<void(const std::string&)>& progress,
                         MaterialFitProgress kept) {
  MaterialFit fit;
  VibrationFitOptions vibration = options.vibration;
  vibration.field = nullptr;
  fit.homogeneous = kept.homogeneous ? *kept.homogeneous
                                     : fit_vibration(vibration, particles, interactions, tracks, fps, progress, kept.vibration, kept.keep_vibration);
  if (!kept.homogeneous && kept.keep_homogeneous) kept.keep_homogeneous(fit.homogeneous);
  fit.found = fit.homogeneous;
  fit.particles = fit.found.fitted(particles);
  fit.sigma = fit.found.young_sigma, fit.prior_sigma = INFINITY;
  fit.steps = {{"search", fit.homogeneous.rms_search, fit.homogeneous.seconds_search, true, "", {}}, step_of("homogeneous", fit.homogeneous)};
  if (const auto field = field_of(options, particles)) add_field(options, vibration, field, interactions, tracks, fps, progress, kept, fit);
  if (options.kind == MaterialKind::kTriplanes || options.poisson || options.clip.beyond_tracks())
    refine_by_gradients(options, vibration, interactions, tracks, fps, progress, kept, fit);
  fit.young.assign(fit.particles.young.begin(), fit.particles.young.end());
  return fit;
}

}  // namespace pliant
