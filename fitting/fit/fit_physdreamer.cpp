#include "fitting/fit/fit_physdreamer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fitting/fields/axes_field.h"
#include "fitting/fields/weighted_field.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr int kFirstFrames = 3;         // after the start, that v0 is found from
constexpr double kDirectRate = 0.05;    // of a velocity whose parameters are its amplitudes
constexpr double kSmoothLength = 0.35;  // of the box's diagonal, over which a smooth v0 is alike

/// What a metre of motion is in the tracks' unit, root mean square over its three directions.
double per_metre(const TrackLoss<float>& tracks, const Particles& particles) {
  Box box;
  for (const Vec3f& x : particles.position) box.add(x);
  const float step = 1e-3f * box.size().norm();
  const SimulationState rest = initial_state(particles);
  const std::vector<Vec3f> here = tracks.expected(rest);
  double square = 0;
  for (int axis = 0; axis < 3; ++axis) {
    SimulationState moved = rest;
    for (Vec3f& x : moved.x) x[axis] += step;
    const std::vector<Vec3f> there = tracks.expected(moved);
    for (size_t k = 0; k < here.size(); ++k)
      square += (there[k] - here[k]).squaredNorm() / (3.0 * step * step * static_cast<double>(here.size()));
  }
  return std::sqrt(square);
}

/// Typical of what the tracks do in the first frames, m/s.
double typical_speed(const TrackLoss<float>& early, const Particles& particles, double fps) {
  const std::vector<SimulationState> still(kFirstFrames + 1, initial_state(particles));
  double square = 0;  // of a steady motion by one unit a frame
  for (int k = 0; k <= kFirstFrames; ++k) square += double(k * k) / (kFirstFrames + 1);
  return early.rms(still) / std::sqrt(square) * fps / per_metre(early, particles);
}

/// Frame from which a body that starts in its shape at rest with a velocity can explain the tracks: the first, unless
/// the motion builds up later, under a push; then that where it first swings back through its shape at rest.
int start_frame(const TrackLoss<float>& tracks, const Particles& particles) {
  constexpr double kAtOnce = 0.7;  // of the fastest three frames: a motion of its own is fastest at first
  const int last = static_cast<int>(tracks.tracks().place.size()) - 1;
  const std::vector<SimulationState> rest = {initial_state(particles)};
  std::vector<double> displacement;
  for (int f = 0; f <= last; ++f) displacement.push_back(tracks.on_rollout(f, f, 0, 1).rms(rest));
  const double most = *std::ranges::max_element(displacement);
  double fastest = 0;
  for (int f = 0; f + kFirstFrames <= last; ++f)
    fastest = std::max(fastest, displacement[f + kFirstFrames] - displacement[f]);
  if (last <= kFirstFrames || displacement[kFirstFrames] - displacement[0] > kAtOnce * fastest) return 0;
  int f = 0;
  while (f < last && !(displacement[f] > 0.5 * most && displacement[f] >= displacement[f + 1])) ++f;
  while (f < last && displacement[f + 1] < displacement[f]) ++f;
  return last - f > kFirstFrames ? f : 0;
}

/// v0(x): nothing where the body is held, its unit a typical speed.
std::shared_ptr<const Field> velocity_field(const MaterialFitOptions& options, const Particles& particles,
                                            const std::vector<Interaction>& interactions, double speed) {
  std::vector<double> weight = free_particles(particles, interactions);
  for (double& w : weight) w *= speed;
  if (options.kind == MaterialKind::kTriplanes) {
    TriplaneOptions planes = options.planes;
    planes.channels = 3;
    planes.resolution = 24;
    if (options.released_code) planes.layers = 2;
    return std::make_shared<WeightedField>(make_triplane_field(planes, particles.position), weight);
  }
  Box box;
  for (const Vec3f& x : particles.position) box.add(x);
  SmoothFieldOptions smooth;
  smooth.sigma = 1;
  smooth.modes = options.vibration.most_smooth;
  smooth.least = 1e-5;
  smooth.length = kSmoothLength * double(box.size().norm());
  return std::make_shared<WeightedField>(
      std::make_shared<AxesField>(std::make_shared<SmoothField>(smooth, particles.position)), weight);
}

/// Loss, rates and schedule of a stage of the released code, with the weights of its two kinds of loss.
void follow_released_code(GradientFitOptions& gradient, PictureLossOptions& picture, double weight_mse,
                          double weight_dssim) {
  gradient.weight_decay = 1e-4;
  gradient.warm_up = 10;
  gradient.linear = true;
  picture.photometric = {0, weight_dssim};
  picture.weight_mse = weight_mse;
}

/// At the time step that a simulation from its start chooses.
void fix_time_step(Motion<float>& motion) {
  RolloutOptions one = motion.options;
  one.simulate.duration = 1 / one.simulate.fps;
  one.simulate.substeps = 0;
  motion.options.simulate.substeps = rollout<float>(one, motion.particles, motion.interactions, motion.start).substeps;
}

}  // namespace

MaterialFit fit_physdreamer(const MaterialFitOptions& options, const Particles& particles,
                            const std::vector<Interaction>& interactions, const TrackLoss<float>& tracks, double fps,
                            const std::function<void(const std::string&)>& progress, MaterialFitProgress kept) {
  const double told = options.vibration.search.first;
  const int first = told >= 0 ? static_cast<int>(std::lround(told * fps)) : start_frame(tracks, particles),
            end = static_cast<int>(tracks.tracks().place.size()) - 1,
            last = options.clip_frames > 0 ? std::min(end, first + options.clip_frames - 1) : end;
  if (progress && told < 0 && first > 0)
    progress("the motion builds up at first; from frame " + std::to_string(first) +
             " on, where the object passes its shape at rest");
  if (last - first <= kFirstFrames)
    throw input_error("fit", "video",
                      fmt::format("has {} frames after the start of the fit, and more than {} are needed",
                                  std::max(0, last - first), kFirstFrames),
                      "use a longer part of it");
  const PhysDreamerCode* code = options.released_code ? &*options.released_code : nullptr;
  CHECK(!code || options.kind == MaterialKind::kTriplanes);
  const ClipFrames early{first, first + kFirstFrames, 0, 1, fps}, all{first, last, 0, 1, fps};
  const auto tracks_of = [&](const ClipFrames& frames) { return tracks.on_rollout(frames.first, frames.last, 0, 1); };
  if (!(tracks_of(early).total_weight() > 0))
    throw input_error("fit", "video",
                      fmt::format("shows no followed point in the first {} frames of the fit", kFirstFrames + 1),
                      "check --video-mask and --start");
  Motion<float> motion{particles, initial_state(particles), interactions, {}};
  SimulateOptions& simulate = motion.options.simulate;
  simulate = options.vibration.simulate;
  simulate.fps = fps;
  simulate.settle_time = 0;
  simulate.sleep_speed = 0;

  MaterialFit fit;
  VibrationFit& given = fit.homogeneous;
  given.time = first / fps;
  given.first_frame = given.search.first_frame = first;
  given.last_frame = last;
  given.damping_time = simulate.damping_time;
  given.rms_rest = given.rms_search = tracks_of(all).rms(std::vector<SimulationState>(all.count(), motion.start));

  // v0(x) under the E that is given.
  ClipFitOptions start;
  start.damping = false;
  start.gradient = options.gradient;
  start.gradient.growth = 0;
  start.gradient.patience = start.gradient.iterations;
  const double speed =
      code ? PhysDreamerCode::kSpeedStep * code->edge : typical_speed(tracks_of(early), particles, fps);
  start.velocity = velocity_field(options, particles, interactions, speed);
  ClipTerms compared = options.clip;
  if (code) {
    start.gradient.iterations = start.gradient.patience = 3 * options.gradient.iterations / 2;
    follow_released_code(start.gradient, compared.picture, 0.5, 0.5);
  }
  if (options.kind != MaterialKind::kTriplanes) start.gradient.velocity_rate = kDirectRate;
  simulate.duration = kFirstFrames / fps;
  fix_time_step(motion);
  const ClipFit velocity =
      fit_clip(start, motion, clip_objective(compared, &tracks, early), kept.velocity, progress, kept.keep_velocity);
  fit.steps.push_back(step_of("velocity", velocity, tracks, early));
  motion.start = given.start = velocity.motion.start;

  // E(x) from there, with a gradient that is cut; that of v0(x) passes through all of its few frames.
  motion.options.gradient_window = options.gradient_window;
  ClipFitOptions material = gradient_fields(options, particles, interactions);
  material.velocity = nullptr;
  material.damping = false;
  material.gradient.patience = material.gradient.iterations;
  if (code) {
    TriplaneOptions planes = options.planes;
    planes.layers = 2;
    material.material = std::make_shared<WeightedField>(make_triplane_field(planes, particles.position),
                                                        free_particles(particles, interactions));
    const double square = code->edge * code->edge;
    material.added_young = {square * PhysDreamerCode::kYoungStep, square * PhysDreamerCode::kYoungLow,
                            square * PhysDreamerCode::kYoungHigh};
    material.gradient.growth = 0.8;
    follow_released_code(material.gradient, compared.picture, 0.05, 0.9);
  }
  simulate.duration = (last - first) / fps;
  fix_time_step(motion);
  given.rms =
      tracks_of(all).rms(rollout<float>(motion.options, motion.particles, motion.interactions, motion.start).frames);
  given.substeps = simulate.substeps;
  const ClipFit clip =
      fit_clip(material, motion, clip_objective(compared, &tracks, all), kept.gradient, progress, kept.keep_gradient);
  fit.steps.push_back(step_of("material", clip, tracks, all));

  fit.found = given;
  fit.found.rms = fit.steps.back().rms;
  fit.found.substeps = clip.motion.options.simulate.substeps;
  fit.particles = clip.motion.particles;
  fit.iterations = clip.iterations;
  fit.young.assign(fit.particles.young.begin(), fit.particles.young.end());
  fit.found.log10_factor += mean_log10_factor(fit.particles, particles);
  find_posterior(options, clip.motion, tracks, all, kept, fit);
  given.seconds = velocity.seconds;
  fit.found.seconds = velocity.seconds + clip.seconds;
  return fit;
}

}  // namespace pliant
