#include "gaussians/reconstruct/check_poses.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "gaussians/base/error.h"
#include "gaussians/base/lens.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/quantile.h"
#include "gaussians/reconstruct/match_photos.h"
#include "gaussians/render/splat.h"

namespace pliant {
namespace {

constexpr int kFewestChecks = 50;  // matches or observations below which nothing is said
constexpr size_t kMostObservations = 20000;
constexpr size_t kMostMatchesOfPair = 200;
constexpr double kFitting = 0.4;  // share of agreement from which a reading is believed
constexpr double kSmallestParallax =
    0.2 * M_PI / 180;                              // below it, noise decides which side of the camera a point is on
constexpr double kFarOut = 1e3, kTooFarOut = 1e5;  // distance from the origin / distance between cameras

struct Match {
  int first, second;  // photos
  Vec2f pixel1, pixel2;
};

double scale_of(const Camera& camera) { return std::max(camera.width, camera.height) / 1000.0; }

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string pixels(double error) {
  return std::isfinite(error) ? number(error) + " px" : "infinite: behind the cameras";
}

std::string percent(double share) { return std::to_string(static_cast<int>(std::lround(100 * share))) + " %"; }

PoseFit fit_of(PoseConvention convention, const std::vector<double>& errors, double agreeing) {
  return {convention, quantile(errors, 0.5), agreeing / static_cast<double>(errors.size())};
}

/// By how many pixels the points miss their observations.
PoseFit fit_to_points(const PoseCheckOptions& options, PoseConvention convention, const std::vector<Camera>& cameras,
                      const SparsePoints& points) {
  std::vector<double> errors;
  double agreeing = 0;
  const size_t stride = 1 + points.observations.size() / kMostObservations;
  for (size_t i = 0; i < points.observations.size(); i += stride) {
    const auto& [point, camera, pixel] = points.observations[i];
    const auto seen = project(cameras[camera], points.position[point].cast<double>());
    errors.push_back(seen ? (*seen - pixel.cast<double>()).norm() : INFINITY);
    agreeing += errors.back() < options.agreement * scale_of(cameras[camera]);
  }
  return fit_of(convention, std::move(errors), agreeing);
}

/// Depths of the point in which two rays meet; none when they are too parallel to tell.
std::optional<Eigen::Vector2d> depths_of(const Camera& camera1, const Camera& camera2, const Match& match) {
  const Eigen::Isometry3d relative = camera2.cam_from_world * camera1.cam_from_world.inverse();
  const auto ray = [](const Camera& c, const Vec2f& u) {
    return Vec3d((u.x() - c.cx) / c.fx, (u.y() - c.cy) / c.fy, 1);
  };
  const Vec3d x1 = relative.linear() * ray(camera1, match.pixel1), x2 = ray(camera2, match.pixel2);
  const Vec3d normal = x2.cross(x1), t = relative.translation();
  if (normal.norm() < kSmallestParallax * x1.norm() * x2.norm()) return std::nullopt;
  // z2 x2 = z1 R x1 + t, multiplied by x2 from the left.
  const double z1 = -x2.cross(t).dot(normal) / normal.squaredNorm();
  return Eigen::Vector2d(z1, (z1 * x1 + t).z());
}

/// What lies nearer than the near plane of the renderer is not drawn.
void warn_of_near_plane(const std::string& where, const std::vector<Camera>& cameras, const std::vector<Match>& matches,
                        std::vector<std::string>& warnings) {
  std::vector<double> depth;
  for (const Match& match : matches) {
    const auto z = depths_of(cameras[match.first], cameras[match.second], match);
    if (z && z->minCoeff() > 0) depth.push_back(z->x());
  }
  if (static_cast<int>(depth.size()) < kFewestChecks) return;
  const double near = quantile(depth, 0.1);
  if (near > splat::kNear) return;
  warnings.push_back(where + ": a tenth of the photographed content is nearer than " + number(near) +
                     " units, and nothing nearer than " + number(splat::kNear) +
                     " is rendered: multiply all positions by " + number(std::ceil(5 * splat::kNear / near)));
}

/// By how many pixels feature matches miss their epipolar lines.
PoseFit fit_to_matches(const PoseCheckOptions& options, PoseConvention convention, const std::vector<Camera>& cameras,
                       const std::vector<Match>& matches) {
  std::vector<double> errors;
  double agreeing = 0;
  for (const Match& match : matches) {
    const Camera &camera1 = cameras[match.first], &camera2 = cameras[match.second];
    const double distance = sampson_distance(fundamental_matrix(camera1, camera2), match.pixel1, match.pixel2);
    const auto depths = depths_of(camera1, camera2, match);
    errors.push_back(!depths || depths->minCoeff() > 0 ? distance : INFINITY);
    agreeing += errors.back() < options.agreement * scale_of(camera2);
  }
  return fit_of(convention, std::move(errors), agreeing);
}

/// Pairs of photos that probably overlap, however the poses are meant: neighbours of some photos by pose and by name.
std::vector<PhotoPair> probable_pairs(int seeds, const std::vector<Camera>& cameras) {
  const int n = static_cast<int>(cameras.size());
  std::set<int> chosen;
  for (int s = 0; s < std::min(seeds, n); ++s) chosen.insert(s * n / std::min(seeds, n));
  std::set<std::pair<int, int>> pairs;
  for (const PhotoPair& pair : overlapping_pairs(cameras, 3)) {
    if (chosen.count(pair.first)) pairs.emplace(pair.first, pair.second);
  }
  for (const int i : chosen) {
    for (int j = i + 1; j <= std::min(i + 2, n - 1); ++j) pairs.emplace(i, j);
  }
  std::vector<PhotoPair> result;
  for (const auto& [i, j] : pairs) result.push_back({i, j});
  return result;
}

std::vector<Match> match_neighbours(const PoseCheckOptions& options, const TrainingPhotos& photos,
                                    const std::vector<Camera>& cameras) {
  const std::vector<PhotoPair> pairs = probable_pairs(options.seeds, cameras);
  std::set<int> used;
  for (const auto& [i, j] : pairs) {
    used.insert(i);
    used.insert(j);
  }
  const std::vector<int> order(used.begin(), used.end());
  std::vector<PhotoFeatures> features(photos.photos.size());
  const FeatureOptions feature_options = {.most = options.features, .longest_side = 1000};
  parallel_for(static_cast<std::ptrdiff_t>(order.size()),
               [&](std::ptrdiff_t k) { features[order[k]] = find_features(feature_options, photos.photos[order[k]]); });
  std::vector<std::vector<Match>> found(pairs.size());
  parallel_for(static_cast<std::ptrdiff_t>(pairs.size()), [&](std::ptrdiff_t p) {
    const auto [i, j] = pairs[p];
    for (const FeatureMatch& m : match_features({}, features[i], features[j])) {
      if (found[p].size() < kMostMatchesOfPair)
        found[p].push_back({i, j, features[i].pixel[m.first], features[j].pixel[m.second]});
    }
  });
  std::vector<Match> matches;
  for (const auto& some : found) matches.insert(matches.end(), some.begin(), some.end());
  return matches;
}

/// What the places of the cameras alone forbid.
void check_places(const std::string& where, const std::vector<Camera>& cameras, PoseReport& report) {
  Vec3d low = Vec3d::Constant(INFINITY), high = -low;
  for (const Camera& camera : cameras) {
    low = low.cwiseMin(camera.centre());
    high = high.cwiseMax(camera.centre());
  }
  const double spread = (high - low).norm(), distance = low.cwiseAbs().cwiseMax(high.cwiseAbs()).norm();
  if (!std::isfinite(spread))
    throw input_error(where, "", "has cameras at places that are not finite", "the file is damaged");
  if (!(spread > 1e-9 * distance)) {
    throw input_error(where, "", "has all " + std::to_string(cameras.size()) + " cameras at one point",
                      "depth is only seen from different places: walk around the object while taking photos");
  }
  const std::string text =
      "has cameras " + number(spread) + " units apart but " + number(distance) + " units from the origin";
  if (distance > kTooFarOut * spread)
    throw input_error(where, "", text + ", which 32-bit numbers cannot tell apart",
                      "subtract a common offset from all positions");
  if (distance > kFarOut * spread)
    report.warnings.push_back(where + ": " + text + "; 32-bit numbers lose precision: subtract a common offset");
}

void check_principal_points(const std::string& where, const std::vector<Camera>& cameras) {
  for (const Camera& c : cameras) {
    if (c.cx > 0 && c.cx < c.width && c.cy > 0 && c.cy < c.height) continue;
    const bool swapped = c.cy > 0 && c.cy < c.width && c.cx > 0 && c.cx < c.height;
    throw input_error(where, "cx, cy",
                      "place the principal point of " + c.name + " to (" + number(c.cx) + ", " + number(c.cy) +
                          "), outside its image of " + std::to_string(c.width) + " x " + std::to_string(c.height),
                      swapped ? "swap cx and cy" : "the intrinsics belong to images of another size");
  }
}

bool clearly_better(const PoseFit& other, const PoseFit& given) {
  return other.share >= kFitting && other.share > given.share + 0.2 && other.share > 0.5 * (1 + given.share) - 0.15 &&
         !(other.error > 0.5 * given.error);
}

std::string meaning(PoseConvention convention) {
  switch (convention) {
    case PoseConvention::kAsGiven:
      return "poses as the format defines them";
    case PoseConvention::kInverse:
      return "inverse poses (camera-to-world and world-to-camera are swapped)";
    case PoseConvention::kFlipped:
      return "cameras whose y and z axes are flipped (OpenGL and OpenCV are swapped)";
    case PoseConvention::kInverseFlipped:
      return "inverse poses with flipped y and z axes";
    case PoseConvention::kTurned:
      return "photos that are upside down relative to their cameras";
  }
  return {};
}

/// A sentence on how well the poses fit.  Throws or warns when another reading fits clearly better, warns when none
/// fits.
std::string judged(const PoseCheckOptions& options, const std::string& where, const PoseEvidence& evidence,
                   const std::string& what, std::vector<std::string>& warnings) {
  const PoseFit &used = evidence.fits[static_cast<size_t>(options.chosen.value_or(PoseConvention::kAsGiven))],
                &best = evidence.fits[static_cast<size_t>(evidence.best)];
  const std::string checked = std::to_string(evidence.checked) + " " + what;
  const std::string sentence =
      "poses agree with " + percent(used.share) + " of " + checked + " (median error " + pixels(used.error) + ")";
  if (clearly_better(best, used)) {
    const std::string problem = "fits its photos as " + meaning(best.convention) + ", not as " +
                                meaning(used.convention) + ": of " + checked + " " + percent(best.share) +
                                " agree (median error " + pixels(best.error) + ") instead of " + percent(used.share) +
                                " (median error " + pixels(used.error) + ")";
    const std::string option = "--pose-convention ", better = option + name_of(best.convention);
    if (options.refuse) throw input_error(where, "", problem, "add " + better + ", or correct the file");
    warnings.push_back(options.chosen ? option + name_of(*options.chosen) + " was given, but " + where + " " + problem +
                                            "; give " + better + " instead"
                                      : where + ": " + problem);
  } else if (used.share < kFitting) {
    const std::string others = best.convention == used.convention
                                   ? ""
                                   : std::string(" (the best, ") + name_of(best.convention) + ": " +
                                         percent(best.share) + ", " + pixels(best.error) + ")";
    warnings.push_back(where + ": " + sentence + ", and no other convention fits better" + others +
                       "; expect a blurred scene: photos and cameras may not belong together");
  }
  return sentence;
}

}  // namespace

PoseReport check_poses(const PoseCheckOptions& options, const CameraFile& file, const TrainingPhotos& photos,
                       const SparsePoints& points) {
  const std::string where = file.files.empty() ? "cameras" : file.files.front().string();
  PoseReport report;
  std::vector<Camera> cameras;
  for (const TrainingPhoto& photo : photos.photos) cameras.push_back(photo.camera);
  check_places(where, cameras, report);
  check_principal_points(where, cameras);

  const PoseConvention used = options.chosen.value_or(PoseConvention::kAsGiven);
  const std::vector<Camera> given = undo_convention(used, file.format, cameras);
  std::vector<std::string> sentences;
  const auto judge = [&](PoseEvidence& evidence, int checked, const std::string& what, const auto& fit) {
    evidence.checked = checked;
    if (checked < kFewestChecks) return;
    for (const PoseConvention convention : kPoseConventions) {
      evidence.fits.push_back(
          fit(convention, convention == used ? cameras : apply_convention(convention, file.format, given)));
    }
    // The reading that is used wins ties: some motions cannot tell readings apart, and then it does not matter.
    evidence.best = used;
    for (const PoseFit& other : evidence.fits)
      if (other.share > evidence.fits[static_cast<size_t>(evidence.best)].share) evidence.best = other.convention;
    sentences.push_back(judged(options, where, evidence, what, report.warnings));
  };
  judge(report.points, static_cast<int>(points.observations.size()), "observations of points",
        [&](PoseConvention convention, const std::vector<Camera>& read) {
          return fit_to_points(options, convention, read, points);
        });
  const std::vector<Match> matches = match_neighbours(options, photos, cameras);
  judge(report.matches, static_cast<int>(matches.size()), "feature matches",
        [&](PoseConvention convention, const std::vector<Camera>& read) {
          return fit_to_matches(options, convention, read, matches);
        });
  if (!report.matches.fits.empty() && report.matches.best == used)
    warn_of_near_plane(where, cameras, matches, report.warnings);
  if (sentences.empty()) {
    sentences.push_back("poses could not be checked: neighboring photos share only " + std::to_string(matches.size()) +
                        " features");
    report.warnings.push_back(where + ": " + sentences.back());
  }
  for (const std::string& sentence : sentences) report.sentence += (report.sentence.empty() ? "" : "; ") + sentence;
  return report;
}

}  // namespace pliant
