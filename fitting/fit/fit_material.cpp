#include "fitting/fit/fit_material.h"

#include <chrono>
#include <cmath>

#include "fitting/fields/part_field.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr double kDecade = 2.302585092994046;
constexpr double kCommon = 0.02;  // of ln E: a field has a level of its own

std::shared_ptr<const Field> field_of(const MaterialFitOptions& options, const Particles& particles) {
  switch (options.kind) {
    case MaterialKind::kUniform:
    case MaterialKind::kTriplanes: return nullptr;
    case MaterialKind::kParts:
      CHECK(options.part.size() == particles.size());
      return std::make_shared<PartField>(options.part, 1);
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

Objective<float> objective_of(const MaterialFitOptions& options, const VibrationFit& fit, const TrackLoss<float>& tracks, double fps) {
  const int lead = fit.rollout_frame(fit.first_frame, fps);
  Objective<float> objective;
  objective.terms.push_back({1, std::make_shared<TrackLoss<float>>(tracks.on_rollout(fit.first_frame, fit.last_frame, lead, fit.subframes))});
  if (!(options.picture_weight > 0)) return objective;
  SeenFrames<float> seen = options.seen;
  seen.frames.assign(lead + fit.subframes * (fit.last_frame - fit.first_frame) + 1, {});
  for (int f = fit.first_frame; f <= fit.last_frame; ++f) seen.frames[lead + fit.subframes * (f - fit.first_frame)] = options.seen.frames.at(f);
  objective.terms.push_back({options.picture_weight, std::make_shared<PictureLoss<float>>(options.picture, options.drawn, std::move(seen))});
  return objective;
}

/// Triplanes of E(x) and v0(x), and damping, from the best constant on.
void fit_triplanes(const MaterialFitOptions& options, const VibrationFitOptions& vibration, const std::vector<Interaction>& interactions,
                   const TrackLoss<float>& tracks, double fps, const std::function<void(const std::string&)>& progress,
                   MaterialFitProgress& kept, MaterialFit& fit) {
  const auto begin = std::chrono::steady_clock::now();
  const Motion<float> motion = motion_of(fit.found, vibration, fit.particles, interactions, fps);
  const Objective<float> objective = objective_of(options, fit.found, tracks, fps);
  TriplaneOptions planes = options.planes;
  planes.low = {-kDecade * options.decades}, planes.high = {kDecade * options.decades};
  TriplaneOptions velocity_planes = options.planes;
  velocity_planes.channels = 3, velocity_planes.resolution = 24;
  const auto material = make_triplane_field(planes, motion.particles.position), velocity = make_triplane_field(velocity_planes, motion.particles.position);
  const GradientFitFields fields{material.get(), velocity.get(), true};
  GradientFitState& state = kept.gradient;
  if (state.now.material.empty()) {
    state.now.material = material->constant(std::vector<double>{0.0});
    state.now.velocity = velocity->constant(std::vector<double>(3, 0.0));
  }
  bool stopped = false;
  fit_gradient(options.gradient, motion, objective, fields, state, [&](const GradientFitState& now) {
    if (progress && now.rows.size() % 10 == 0)
      progress("iteration " + std::to_string(now.rows.size()) + ": " + std::to_string(now.rows.back().frames) + " frames, loss " + std::to_string(now.rows.back().loss));
    stopped = kept.keep_gradient && !kept.keep_gradient(now);
    return !stopped;
  });
  if (stopped) throw Error(Failure::kInterrupted, "fit", "", "interrupted", "run the same command to continue");
  const Motion<float> best = with_fields(motion, fields, state.best);
  fit.particles = best.particles, fit.found.start = best.start, fit.found.damping_time = best.options.simulate.damping_time;
  fit.iterations = state.rows, fit.sigma.clear();
  const Rollout<float> run = rollout<float>(best.options, best.particles, best.interactions, best.start);
  fit.found.rms = tracks.on_rollout(fit.found.first_frame, fit.found.last_frame, fit.found.rollout_frame(fit.found.first_frame, fps), fit.found.subframes).rms(run.frames);
  fit.steps.push_back({"gradients", fit.found.rms, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count()});
}

}  // namespace

MaterialFit fit_material(const MaterialFitOptions& options, const Particles& particles, const std::vector<Interaction>& interactions,
                         const TrackLoss<float>& tracks, double fps, const std::function<void(const std::string&)>& progress,
                         MaterialFitProgress kept) {
  MaterialFit fit;
  VibrationFitOptions vibration = options.vibration;
  vibration.field = nullptr;
  fit.homogeneous = kept.homogeneous ? *kept.homogeneous : fit_vibration(vibration, particles, interactions, tracks, fps, progress);
  if (!kept.homogeneous && kept.keep_homogeneous) kept.keep_homogeneous(fit.homogeneous);
  fit.found = fit.homogeneous;
  fit.particles = fit.found.fitted(particles);
  fit.sigma = fit.found.young_sigma, fit.prior_sigma = INFINITY;
  fit.steps = {{"search", fit.homogeneous.rms_search, 0}, {"homogeneous", fit.homogeneous.rms, fit.homogeneous.seconds}};
  if (const auto field = field_of(options, particles)) {
    vibration.field = field, vibration.candidates = 1, vibration.refine.max_iterations *= 2;
    vibration.field_sigma = options.kind == MaterialKind::kParts ? options.part_sigma * kDecade : 1;
    vibration.factor_sigma = kCommon;
    vibration.search.low = -0.3, vibration.search.high = 0.3;
    vibration.search.first = fit.homogeneous.first_frame / fps;
    const Particles base = fit.particles;
    vibration.known_modes = fit.homogeneous.modes.stiffer(std::pow(10.0, fit.homogeneous.log10_factor));
    fit.found = fit_vibration(vibration, base, interactions, tracks, fps, progress);
    fit.steps.push_back({"field", fit.found.rms, fit.found.seconds});
    fit.particles = fit.found.fitted(base, field.get());
    fit.found.log10_factor += fit.homogeneous.log10_factor;
    fit.sigma = fit.found.young_sigma;
    if (const auto* smooth = dynamic_cast<const SmoothField*>(field.get()))
      for (size_t i = 0; i < fit.sigma.size(); ++i)
        fit.sigma[i] = std::sqrt(fit.sigma[i] * fit.sigma[i] + smooth->variance_left_out(i) / (kDecade * kDecade));
    fit.prior_sigma = options.kind == MaterialKind::kParts ? options.part_sigma : options.smooth.sigma / kDecade;
  }
  if (options.kind == MaterialKind::kTriplanes) fit_triplanes(options, vibration, interactions, tracks, fps, progress, kept, fit);
  fit.young.assign(fit.particles.young.begin(), fit.particles.young.end());
  return fit;
}

}  // namespace pliant
