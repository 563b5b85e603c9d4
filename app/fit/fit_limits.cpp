#include "app/fit/fit_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gaussians/base/nearest.h"

namespace pliant {

namespace {
constexpr double kNotable = 0.1;   // share of the losses
constexpr double kWorse = 1.05;    // times the RMSE before a refinement, from which on it made the fit worse
constexpr double kDecibel = 1.26;  // times the squared error of a static picture: a decibel

const char* const kCheck = "check the pins, the object mask and the camera.";

/// The motion that was found leaves most of the video's unexplained; else empty.
std::string poor_fit(const FitEvidence& e) {
  if (!(e.rms_still > 0) || e.rms <= kPoorFit * e.rms_still) return "";
  return fmt::format(
      "The fitted motion explains {} of the video: track RMSE {:.2f} px, against {:.2f} px for a static object. Do not "
      "rely on E, damping or their errors; {}",
      e.rms < e.rms_still ? "little" : "nothing", e.rms, e.rms_still, kCheck);
}

double squared_error(double psnr) { return std::pow(10.0, -0.1 * psnr); }

/// The first frame held looks more like the video than the fitted motion does; else empty.
std::string poor_pictures(const MotionScores& scores) {
  const double at_rest = squared_error(scores.rest);
  const std::pair<const char*, const MotionScores::Span*> spans[] = {
      {"fitted", &scores.fitted}, {"further", &scores.searched}, {"held-out", &scores.later}};
  for (const auto& [name, span] : spans) {
    if (span->frames == 0) continue;
    // By motion, beyond how far the scene at rest differs from the first frame.
    const bool by_motion = squared_error(span->psnr) - at_rest > kDecibel * squared_error(span->still);
    if (!by_motion && !(span == &scores.fitted && span->psnr < span->still)) continue;
    const std::string worse = fmt::format(
        "The fitted motion draws the {} frames worse than the first frame held still: PSNR {:.1f} dB against "
        "{:.1f} dB. ",
        name, span->psnr, span->still);
    return by_motion ? worse + "Do not rely on E or damping; " + kCheck
                     : worse + fmt::format(
                                   "The scene at rest differs from the first frame about as much ({:.1f} dB), "
                                   "so pictures do not tell how good the fit is: check the camera, and that "
                                   "the video shows the scene in its own colors.",
                                   scores.rest);
  }
  return "";
}

}  // namespace

FitBlindness find_blindness(const FitScene& fit, const FittedMotion& motion) {
  FitBlindness out;
  const Particles& p = fit.body.particles;
  if (motion.frames.empty()) return out;
  // Along the rays of the camera, at the first frame that was compared.
  const Vec3d eye = fit.drawn->metres_per_unit * fit.video.camera.centre();
  double along = 0, all = 0;
  for (size_t i = 0; i < p.size(); ++i) {
    const Vec3d v = motion.frames[0].v[i].cast<double>(), ray = (p.position[i].cast<double>() - eye).normalized();
    along += p.mass[i] * std::pow(v.dot(ray), 2);
    all += p.mass[i] * v.squaredNorm();
  }
  if (fit.further.empty()) out.depth_share = all > 0 ? along / all : 0;

  double volume = 0, unseen = 0;
  std::vector<Vec3f> points;
  for (const FitView* view : fit.views()) points.insert(points.end(), view->points.begin(), view->points.end());
  if (!points.empty()) {
    const NearestPoints tree(points);
    const double reach = 3 * fit.body.file.cell_size;
    std::vector<NearestPoints::Hit> hits;
    for (size_t i = 0; i < p.size(); ++i) {
      hits.clear();
      tree.query(fit.drawn->drivers[i], 1, hits);
      volume += p.volume[i];
      if (hits.empty() || hits[0].distance > reach) unseen += p.volume[i];
    }
    out.unseen_volume = volume > 0 ? unseen / volume : 0;
  }

  // Largest Green strain of each particle over all frames.
  std::vector<float> strain(p.size(), 0.0f);
  for (const SimulationState& state : motion.frames)
    for (size_t i = 0; i < p.size(); ++i)
      strain[i] = std::max(strain[i], 0.5f * (state.F[i].transpose() * state.F[i] - Mat3f::Identity()).norm());
  std::vector<float> sorted = strain;
  std::sort(sorted.begin(), sorted.end());
  const float most = sorted[static_cast<size_t>(0.95 * static_cast<double>(sorted.size() - 1))];
  double stiff = 0, whole = 0;
  for (size_t i = 0; i < p.size(); ++i) {
    whole += p.volume[i];
    if (strain[i] < 0.05f * most) stiff += p.volume[i];
  }
  out.stiff_volume = whole > 0 ? stiff / whole : 0;
  return out;
}

std::vector<std::string> doubts_of(const FitEvidence& e) {
  std::vector<std::string> out;
  if (e.displaced > 0)
    out.push_back(fmt::format(
        "The first frame shows the object up to {:.1f} px away from rest, so its motion was measured from "
        "the rendered scene: E and damping are less exact than their errors say, and wrong if the camera or "
        "the scene is. Start with a frame that shows it at rest (--video-first).",
        e.displaced));
  if (e.pushed_away)
    out.push_back(
        "The object moves away from rest up to the last frame: it is pushed to the end, and nothing swings freely. Do "
        "not rely on E or damping; use a video that shows it swing after its release.");
  else if (e.start_late)
    out.push_back(fmt::format(
        "The object may still be pushed: its free motion is taken to begin at {:.2f} s, halfway through the "
        "frames, the latest time that is considered. Give the time of its release (--start), or use a "
        "longer video.",
        e.start));
  if (e.search_end != 0)
    out.push_back(fmt::format(
        "E is from the {} end of the search, where {} values would explain the motion at least as well: the "
        "video does not determine it. Check that the first frame shows the object at rest, the time of "
        "its release (--start) and the frame rate, or begin from another --young.",
        e.search_end < 0 ? "low" : "high", e.search_end < 0 ? "smaller" : "larger"));
  for (const std::string& poor : {poor_fit(e), poor_pictures(e.scores)})
    if (!poor.empty()) out.push_back(poor);
  if (e.refined >= 0 && e.rms > kWorse * e.rival_rms[e.refined])
    out.push_back(
        fmt::format("The refinement ended with a larger track RMSE than it began with: {:.2f} px, against {:.2f} px at "
                    "E = {:.3g} Pa.",
                    e.rms, e.rival_rms[e.refined], e.young * e.rival_factor[e.refined]));
  return out;
}

std::vector<std::string> undetermined_by_video(const FitEvidence& e, const FitBlindness& blindness, double fps) {
  std::vector<std::string> out = doubts_of(e);
  out.push_back(fmt::format("Motion determines E / density, not E alone: E is valid for the given {}, and {}.",
                            e.density_fitted ? "total mass, whose distribution was fitted" : "density",
                            e.poisson_fitted
                                ? "Poisson's ratio, which affects motion little, may be far from the fitted value"
                                : "Poisson's ratio is the given one"));
  if (e.stated_fps > 0)
    out.push_back(
        fmt::format("E scales with the square of the frame rate, assumed to be {:.4g} frames per second: at twice that "
                    "rate, E would be 4 times as large, {:.3g} Pa; at half of it, a quarter, {:.3g} Pa.",
                    e.stated_fps, 4 * e.young, e.young / 4));
  if (blindness.depth_share)
    out.push_back(
        fmt::format("One camera barely sees motion along its line of sight, which carries {:.0f} % of the energy of "
                    "the fitted initial state: that component is inferred from the object's vibration modes.",
                    100 * *blindness.depth_share));
  if (blindness.unseen_volume > 0.02)
    out.push_back(
        fmt::format("{:.0f} % of the moving volume is far from every tracked point; its motion was not observed.",
                    100 * blindness.unseen_volume));
  if (blindness.stiff_volume > 0.02)
    out.push_back(fmt::format("{:.0f} % of the object barely deforms in this video; it could be much stiffer.",
                              100 * blindness.stiff_volume));
  if (!e.searched)
    out.push_back(
        "E was refined from the given value by gradient descent, not searched globally: another value may explain the "
        "video better. Damping was not fitted.");
  if (e.field_left)
    out.push_back(
        "A spatially varying stiffness explained the motion no better than one for the whole object, which was kept: "
        "the video does not distinguish its parts.");
  if (e.one_stiffness)
    out.push_back(e.start_given
                      ? "One factor of the given material was fitted; its differences between parts were taken "
                        "over unchanged."
                      : "One stiffness was fitted for the whole object; differences between its parts were "
                        "not considered.");
  else if (!e.errors_known)
    out.push_back("The spatial uncertainty of E was not computed; a fit with --field smooth computes it.");
  else if (e.undecided_volume > 0.02)
    out.push_back(
        fmt::format("Where uncertainty.png is bright, in {:.0f} % of the object, its stiffness relative to the rest is "
                    "a guess: the video does not reduce its prior uncertainty.",
                    100 * e.undecided_volume));
  if (e.by_gradients && e.errors_known)
    out.push_back(
        "The uncertainty of E reflects only the tracked points, near the fit that was found; images and optical flow "
        "were not considered.");
  for (size_t k = 0; k < e.rival_factor.size(); ++k) {
    const double ratio = e.rival_factor[k];
    if (static_cast<int>(k) != e.refined && std::abs(std::log10(ratio)) > 0.05 && e.rival_rms[k] < 1.3 * e.rms)
      out.push_back(fmt::format("E = {:.3g} Pa explains the video {} (RMSE {:.2f} px against {:.2f} px).",
                                e.young * ratio, e.rival_rms[k] < e.rms ? "better" : "almost as well", e.rival_rms[k],
                                e.rms));
  }
  if (e.strongest_hz > 0.25 * fps)
    out.push_back(fmt::format(
        "The dominant vibration, {:.2g} Hz, is above a quarter of the frame rate, {:.3g} frames per second: a slower "
        "one sampled at the same instants could be mistaken for it. Film at a higher frame rate.",
        e.strongest_hz, fps));
  if (e.periods > 0 && e.periods < 1)
    out.push_back(
        fmt::format("Only {:.1f} of a period is visible: E and the initial state are hard to distinguish.", e.periods));
  if (e.losses.transfers > kNotable * e.losses.whole)
    out.push_back(
        fmt::format("The solver's grid also dissipates energy, equivalent to a damping time of {:.2g} s: the "
                    "simulation adds one of {:.2g} s, and on another grid the motion would decay differently. With all "
                    "losses the object's own damping time is {:.2g} s.",
                    1 / e.losses.transfers, e.damping_time, 1 / e.losses.whole));
  if (e.damping_high > 3 * e.damping_low)
    out.push_back(fmt::format("Damping is barely determined: any damping time from {:.2g} s to {:.2g} s fits.",
                              e.damping_low, e.damping_high));
  return out;
}

}  // namespace pliant
