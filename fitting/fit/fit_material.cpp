#include "fitting/fit/fit_material.h"

#include <algorithm>
#include <cmath>

#include "fitting/fields/part_field.h"
#include "fitting/fields/weighted_field.h"
#include "fitting/fit/young_posterior.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr double kDecade = 2.302585092994046;
constexpr double kMostSigmas = 5;         // of the parameters of a smooth field, that they may reach
constexpr double kCommon = 0.02;          // of ln E: a field has a level of its own
constexpr double kDensitySigma = 0.7;     // of ln of the density from place to place ...
constexpr double kMostDenser = 1.609438;  // ... and at most, of a part: five times

std::shared_ptr<SmoothField> smooth_field_of(const MaterialFitOptions& options, const Particles& particles) {
  SmoothFieldOptions smooth = options.smooth;
  smooth.level_sigma = std::max(smooth.level_sigma, smooth.sigma);
  return std::make_shared<SmoothField>(smooth, particles.position);
}

/// Decades by which E of a particle is expected to differ from the common level.
double prior_sigma_of(const MaterialFitOptions& options) {
  if (options.kind == MaterialKind::kUniform) return INFINITY;
  return options.kind == MaterialKind::kParts ? options.part_sigma : options.smooth.sigma / kDecade;
}

/// What the modes of a smooth field leave out joins the spread that they give.
void add_left_out(const Field* field, std::vector<double>& sigma) {
  if (const auto* smooth = dynamic_cast<const SmoothField*>(field))
    for (size_t i = 0; i < sigma.size(); ++i)
      sigma[i] = std::sqrt(sigma[i] * sigma[i] + smooth->variance_left_out(i) / (kDecade * kDecade));
}

/// Whether E is a network's, which only gradients fit.
bool is_network(MaterialKind kind) { return kind == MaterialKind::kTriplanes || kind == MaterialKind::kKan; }

std::shared_ptr<const Field> field_of(const MaterialFitOptions& options, const Particles& particles) {
  switch (options.kind) {
    case MaterialKind::kUniform:
      return nullptr;
    case MaterialKind::kParts:
      CHECK(options.part.size() == particles.size());
      return std::make_shared<PartField>(options.part, 1);
    case MaterialKind::kTriplanes:
    case MaterialKind::kKan:
      if (!options.smooth_first) return nullptr;
      [[fallthrough]];
    case MaterialKind::kSmooth:
      return smooth_field_of(options, particles);
  }
  return nullptr;
}

/// Of a constant beside E: as E varies, one value, one of each part, or a smooth field.
std::shared_ptr<const Field> field_beside(const MaterialFitOptions& options, const Particles& particles, double sigma) {
  if (options.kind == MaterialKind::kUniform) return std::make_shared<PartField>(particles.size(), 1);
  if (options.kind == MaterialKind::kParts) return std::make_shared<PartField>(options.part, 1);
  SmoothFieldOptions smooth = options.smooth;
  smooth.sigma = smooth.level_sigma = sigma;
  return std::make_shared<SmoothField>(smooth, particles.position);
}

/// The fitted motion over the frames that were compared.
Motion<float> motion_of(const VibrationFit& fit, const VibrationFitOptions& options, const Particles& particles,
                        const std::vector<Interaction>& interactions, double fps) {
  Motion<float> motion{particles, fit.start, interactions, {}};
  SimulateOptions& simulate = motion.options.simulate;
  simulate = options.simulate;
  simulate.fps = fps * fit.subframes;
  simulate.substeps = fit.substeps;
  simulate.damping_time = fit.damping_time;
  simulate.duration = fit.rollout_frame(fit.last_frame, fps) / simulate.fps;
  simulate.settle_time = 0;
  simulate.sleep_speed = 0;
  return motion;
}

/// Loss as errors of the tracks: it is half the sum of squares.
FitStep step_of(const char* name, const VibrationFit& fit) {
  FitStep step{name, fit.rms, fit.seconds - fit.seconds_search, fit.summary.converged, fit.summary.stopped_by, {}};
  for (const double loss : fit.summary.loss)
    step.loss.push_back(fit.rms * std::sqrt(loss / std::max(fit.summary.loss.back(), 1e-30)));
  return step;
}

/// A field of factors of E, from the best constant on.
void add_field(const MaterialFitOptions& options, VibrationFitOptions vibration,
               const std::shared_ptr<const Field>& field, const std::vector<Interaction>& interactions,
               const TrackLoss<float>& tracks, double fps, const std::function<void(const std::string&)>& progress,
               const MaterialFitProgress& kept, MaterialFit& fit) {
  const bool parts = options.kind == MaterialKind::kParts;
  vibration.field = field;
  vibration.candidates = 1;
  vibration.refine.max_iterations *= 2;
  vibration.field_sigma = parts ? options.part_sigma * kDecade : 1;
  vibration.factor_sigma = kCommon;
  vibration.field_limit = parts ? options.decades * kDecade : kMostSigmas;
  vibration.search.low = -0.3;
  vibration.search.high = vibration.search.farthest = 0.3;
  vibration.search.first = fit.homogeneous.first_frame / fps;
  vibration.known_modes = fit.homogeneous.modes.stiffer(std::pow(10.0, fit.homogeneous.log10_factor));
  const Particles base = fit.particles;
  fit.found = kept.field ? *kept.field
                         : fit_vibration(vibration, base, interactions, tracks, fps, progress,
                                         kept.homogeneous ? kept.vibration : VibrationFitState{}, kept.keep_vibration);
  if (!kept.field && kept.keep_field) kept.keep_field(fit.found);
  fit.steps.push_back(step_of("field", fit.found));
  fit.prior_sigma = prior_sigma_of(options);
  fit.field_left = fit.found.rms > fit.homogeneous.rms;
  if (fit.field_left) {
    // The constant stays; from place to place E is then as uncertain as before any track was seen.
    fit.found = fit.homogeneous;
    for (double& sigma : fit.sigma) sigma = std::hypot(sigma, fit.prior_sigma);
    return;
  }
  fit.particles = fit.found.fitted(base, field.get());
  fit.found.log10_factor += fit.homogeneous.log10_factor;
  fit.sigma = fit.found.young_sigma;
  add_left_out(field.get(), fit.sigma);
}

/// Exact gradients from what was found on.
void refine_by_gradients(const MaterialFitOptions& options, const VibrationFitOptions& vibration,
                         const std::vector<Interaction>& interactions, const TrackLoss<float>& tracks, double fps,
                         const std::function<void(const std::string&)>& progress, const MaterialFitProgress& kept,
                         MaterialFit& fit) {
  const VibrationFit& found = fit.found;
  const ClipFrames frames{found.first_frame, found.last_frame, found.rollout_frame(found.first_frame, fps),
                          found.subframes, fps};
  Motion<float> motion = motion_of(found, vibration, fit.particles, interactions, fps);
  motion.options.gradient_window = options.gradient_window * frames.every;
  ClipFitOptions varied = gradient_fields(options, fit.particles, interactions);
  varied.gradient.first_window = frames.lead + frames.every * varied.gradient.first_window;
  const ClipFit clip = fit_clip(varied, motion, clip_objective(options.clip, &tracks, frames), kept.gradient, progress,
                                kept.keep_gradient);
  const Motion<float>& best = clip.motion;
  fit.found.log10_factor += mean_log10_factor(best.particles, fit.particles);
  fit.particles = best.particles;
  fit.found.start = best.start;
  fit.found.damping_time = best.options.simulate.damping_time;
  fit.found.substeps = best.options.simulate.substeps;
  fit.iterations = clip.iterations;
  fit.field_left = false;
  fit.steps.push_back(step_of("gradients", clip, tracks, frames));
  fit.found.rms = fit.steps.back().rms;
  find_posterior(options, best, tracks, frames, kept, fit);
}

}  // namespace

ClipFitOptions gradient_fields(const MaterialFitOptions& options, const Particles& particles,
                               const std::vector<Interaction>& interactions) {
  ClipFitOptions varied;
  const std::vector<double> free = free_particles(particles, interactions);
  varied.gradient = options.gradient;
  if (options.kind == MaterialKind::kTriplanes) {
    TriplaneOptions planes = options.planes, velocity_planes = options.planes;
    planes.low = {-kDecade * options.decades};
    planes.high = {kDecade * options.decades};
    velocity_planes.channels = 3;
    velocity_planes.resolution = 24;
    varied.material = std::make_shared<WeightedField>(make_triplane_field(planes, particles.position), free);
    varied.velocity = std::make_shared<WeightedField>(make_triplane_field(velocity_planes, particles.position), free);
  } else if (options.kind == MaterialKind::kKan) {
    KanFieldOptions kan = options.kan;
    kan.bound = kDecade * options.decades;
    varied.material = std::make_shared<WeightedField>(std::make_shared<KanField>(kan, particles.position), free);
  } else {
    varied.material = field_of(options, particles);
    if (!varied.material) varied.material = std::make_shared<PartField>(particles.size(), 1);
    if (options.kind == MaterialKind::kSmooth) varied.material = std::make_shared<WeightedField>(varied.material, free);
    varied.gradient.material_limit = options.kind == MaterialKind::kSmooth ? kMostSigmas : options.decades * kDecade;
  }
  if (options.poisson) varied.poisson = field_beside(options, particles, 1);
  if (options.density) {
    varied.density = field_beside(options, particles, kDensitySigma);
    varied.gradient.density_limit = options.kind == MaterialKind::kParts ? kMostDenser : kMostSigmas;
  }
  if (options.clip.guide_weight > 0) {
    varied.gradient.noisy = true;
    varied.gradient.growth = 0;
  }
  return varied;
}

void find_posterior(const MaterialFitOptions& options, const Motion<float>& motion, const TrackLoss<float>& tracks,
                    const ClipFrames& frames, const MaterialFitProgress& kept, MaterialFit& fit) {
  std::shared_ptr<const Field> field =
      is_network(options.kind) ? smooth_field_of(options, motion.particles) : field_of(options, motion.particles);
  if (!field) field = std::make_shared<PartField>(motion.particles.size(), 1);
  const double sigma = options.kind == MaterialKind::kUniform ? INFINITY
                       : options.kind == MaterialKind::kParts ? options.part_sigma * kDecade
                                                              : 1;
  const YoungPosterior posterior =
      posterior_about(motion, *field, sigma, tracks.on_rollout(frames.first, frames.last, frames.lead, frames.every),
                      options.vibration.stop, kept.posterior, kept.keep_posterior);
  // What nothing determines is open by as much as the search reaches.
  const double widest = options.vibration.search.farthest;
  fit.sigma = posterior.young_sigma;
  for (double& s : fit.sigma) s = std::min(s, widest);
  fit.prior_sigma = prior_sigma_of(options);
  add_left_out(field.get(), fit.sigma);
  VibrationFit& found = fit.found;
  const double spread = std::exp(std::min(5.0, posterior.log_damping_sigma));
  found.log10_sigma = std::min(posterior.log10_sigma, widest);
  found.damping_time_low = found.damping_time / spread;
  found.damping_time_high = found.damping_time * spread;
}

double mean_log10_factor(const Particles& fitted, const Particles& before) {
  double sum = 0;
  for (size_t i = 0; i < before.size(); ++i) sum += std::log10(double(fitted.young[i]) / before.young[i]);
  return sum / static_cast<double>(before.size());
}

FitStep step_of(const std::string& name, const ClipFit& clip, const TrackLoss<float>& tracks,
                const ClipFrames& frames) {
  const Motion<float>& motion = clip.motion;
  const Rollout<float> run = rollout<float>(motion.options, motion.particles, motion.interactions, motion.start);
  const double rms = tracks.on_rollout(frames.first, frames.last, frames.lead, frames.every).rms(run.frames);
  FitStep step{name, rms, clip.seconds, clip.stopped_by != "iterations", clip.stopped_by, {}, true};
  // As if all frames were compared from the first iteration on.
  for (const GradientFitRow& row : clip.iterations)
    step.loss.push_back(row.loss * clip.iterations.back().frames / row.frames);
  return step;
}

MaterialFit fit_material(const MaterialFitOptions& options, const Particles& particles,
                         const std::vector<Interaction>& interactions, const TrackLoss<float>& tracks, double fps,
                         const std::function<void(const std::string&)>& progress, MaterialFitProgress kept) {
  MaterialFit fit;
  VibrationFitOptions vibration = options.vibration;
  vibration.field = nullptr;
  fit.homogeneous = kept.homogeneous ? *kept.homogeneous
                                     : fit_vibration(vibration, particles, interactions, tracks, fps, progress,
                                                     kept.vibration, kept.keep_vibration);
  if (!kept.homogeneous && kept.keep_homogeneous) kept.keep_homogeneous(fit.homogeneous);
  fit.found = fit.homogeneous;
  fit.particles = fit.found.fitted(particles);
  fit.sigma = fit.found.young_sigma;
  fit.prior_sigma = INFINITY;
  fit.steps = {{"search", fit.homogeneous.rms_search, fit.homogeneous.seconds_search, true, "", {}},
               step_of("homogeneous", fit.homogeneous)};
  if (const auto field = field_of(options, particles))
    add_field(options, vibration, field, interactions, tracks, fps, progress, kept, fit);
  if (is_network(options.kind) || options.poisson || options.density || options.clip.beyond_tracks())
    refine_by_gradients(options, vibration, interactions, tracks, fps, progress, kept, fit);
  // What the search does not bound, a field about it does not either.
  if (fit.homogeneous.search.end != 0) {
    fit.found.log10_sigma = std::max(fit.found.log10_sigma, fit.homogeneous.log10_sigma);
    for (double& sigma : fit.sigma) sigma = std::max(sigma, fit.homogeneous.log10_sigma);
  }
  fit.losses = dissipation_of(motion_of(fit.found, vibration, fit.particles, interactions, fps));
  fit.young.assign(fit.particles.young.begin(), fit.particles.young.end());
  return fit;
}

}  // namespace pliant
