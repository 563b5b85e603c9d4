#include "segmentation/repair/repair.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "segmentation/repair/patch.h"
#include "segmentation/repair/surfaces.h"

namespace pliant {
namespace {

/// At most `most` cameras, evenly chosen from a sequence that does not depend on the order in which they are given.
std::vector<int> choose_views(const std::vector<Camera>& cameras, int most) {
  std::vector<int> sequence(cameras.size());
  std::iota(sequence.begin(), sequence.end(), 0);
  auto key = [&](int i) {
    const Eigen::Isometry3d& m = cameras[i].cam_from_world;
    const Vec3d eye = cameras[i].centre();
    return std::array<double, 6>{eye.x(), eye.y(), eye.z(), m(2, 0), m(2, 1), m(2, 2)};
  };
  std::stable_sort(sequence.begin(), sequence.end(), [&](int a, int b) { return key(a) < key(b); });
  const int n = std::min<int>(most, static_cast<int>(cameras.size()));
  std::vector<int> out(n);
  for (int i = 0; i < n; ++i) out[i] = sequence[static_cast<size_t>(i) * cameras.size() / n];
  return out;
}

/// Mean absolute colour difference over pixels farther than 3 from the hole.
float change_outside(const HoleView& before, const HoleView& after) {
  const int width = before.hole.width, height = before.hole.height;
  cv::Mat near, hole(height, width, CV_8U, const_cast<uint8_t*>(before.hole.data.data()));
  cv::dilate(hole, near, cv::Mat::ones(7, 7, CV_8U));
  double sum = 0;
  size_t count = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (near.at<uint8_t>(y, x)) continue;
      for (int k = 0; k < 3; ++k) sum += std::abs(before.picture.color(x, y, k) - after.picture.color(x, y, k)), ++count;
    }
  return count ? static_cast<float>(sum / static_cast<double>(count)) : 0.0f;
}

/// Where views see points: 1 = in front of what is there, in the hole; 2 = outside it.
std::vector<uint8_t> where_seen(const std::vector<Vec3f>& points, const std::vector<HoleView>& views, const std::vector<int>& camera_of,
                                const std::vector<Camera>& cameras) {
  constexpr int kSoftEdge = 2;      // pixels around a hole that belong to its blurred border
  constexpr double kSlack = 0.02;   // of the depth of what is there
  std::vector<uint8_t> seen(points.size(), 0);
  for (size_t v = 0; v < views.size(); ++v) {
    const HoleView& view = views[v];
    const Camera& camera = cameras[camera_of[v]];
    cv::Mat near, hole(view.hole.height, view.hole.width, CV_8U, const_cast<uint8_t*>(view.hole.data.data()));
    cv::dilate(hole, near, cv::Mat::ones(2 * kSoftEdge + 1, 2 * kSoftEdge + 1, CV_8U));
    for (size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d x = camera.cam_from_world * points[i].cast<double>();
      if (x.z() <= 0) continue;
      const double u = camera.fx * x.x() / x.z() + camera.cx, w = camera.fy * x.y() / x.z() + camera.cy;
      if (u < 0 || w < 0 || u >= camera.width || w >= camera.height) continue;
      const int px = static_cast<int>(u), py = static_cast<int>(w);
      const float alpha = view.picture.alpha(px, py);
      const double there = alpha > 0.5f ? view.picture.depth(px, py) / alpha : INFINITY;
      if (near.at<uint8_t>(py, px)) seen[i] |= x.z() <= (1 + kSlack) * there ? 1 : 0;
      else seen[i] |= x.z() <= (1 - kSlack) * there ? 2 : 0;
    }
  }
  return seen;
}

/// The Gaussians of `patch` that no view sees outside its hole: nothing may be added in front of what is there, nor
/// where there was nothing.
GaussianCloud inside_holes(const GaussianCloud& patch, const std::vector<HoleView>& views, const std::vector<int>& camera_of,
                           const std::vector<Camera>& cameras) {
  const std::vector<uint8_t> seen = where_seen(patch.position, views, camera_of, cameras);
  std::vector<int> kept;
  for (size_t i = 0; i < patch.size(); ++i)
    if (!(seen[i] & 2)) kept.push_back(static_cast<int>(i));
  return patch.select(kept);
}

/// Never observed Gaussians that come into view in holes and nowhere else: nobody knows whether they are right.
std::vector<int> uncovered_guesses(const GaussianCloud& background, const Observation& observation, const std::vector<HoleView>& views,
                                   const std::vector<Camera>& cameras) {
  std::vector<int> guesses, out;
  std::vector<Vec3f> points;
  for (size_t p = 0; p < background.size(); ++p)
    if (observation.unobserved[p] > 0) guesses.push_back(static_cast<int>(p)), points.push_back(background.position[p]);
  const std::vector<uint8_t> seen = where_seen(points, views, observation.view, cameras);
  for (size_t i = 0; i < guesses.size(); ++i)
    if (seen[i] == 1) out.push_back(guesses[i]);
  return out;
}

/// The plane on which the object stands: most of the hole is on it and the object reaches down to it.  -1 = none.
int support_plane(const Surfaces& surfaces, const std::vector<HoleGeometry>& geometry, const GaussianCloud& object) {
  std::vector<size_t> pixels(surfaces.plane.size(), 0);
  for (const HoleGeometry& view : geometry)
    for (int k : view.plane)
      if (k >= 0) ++pixels[k];
  int best = -1;
  for (size_t k = 0; k < pixels.size(); ++k) {
    if (pixels[k] == 0 || (best >= 0 && pixels[k] <= pixels[best])) continue;
    std::vector<float> height;
    for (const Vec3f& x : object.position) height.push_back(surfaces.plane[k].plane.normal.dot(x - surfaces.plane[k].plane.point));
    std::sort(height.begin(), height.end());
    const float low = height[height.size() / 50], high = height[height.size() - 1 - height.size() / 50];
    if (std::abs(low) < 0.1f * (high - low)) best = static_cast<int>(k);
  }
  return best;
}

}  // namespace

size_t RepairSummary::before() const { return std::accumulate(hole_before.begin(), hole_before.end(), size_t(0)); }
size_t RepairSummary::after() const { return std::accumulate(hole_after.begin(), hole_after.end(), size_t(0)); }

std::string RepairSummary::describe() const {
  char text[256];
  std::snprintf(text, sizeof(text), "hole of %zu pixels in %zu views filled with %zu Gaussians on %zu planes and %zu placed view by view; %zu pixels left; %.1f s",
                before(), views.size(), plane_gaussians, planes, view_gaussians, after(), seconds);
  return text;
}

std::string RepairSummary::describe_shadow() const {
  char text[256] = "";
  if (shadow == Shadow::Verdict::kPlain)
    std::snprintf(text, sizeof(text), "contact shadow that leaves %.0f %% of the light beside the object: %s", 100 * shadow_darkest,
                  shadow_lifted ? ("lifted from " + std::to_string(shadow_gaussians) + " Gaussians").c_str() : "kept, as asked");
  else if (shadow == Shadow::Verdict::kDoubtful)
    std::snprintf(text, sizeof(text), "the support is darker around the object, but %s: left as it is", shadow_doubt.c_str());
  return text;
}

RepairResult repair(const RepairOptions& options, const GaussianCloud& background, const GaussianCloud& removed,
                    const std::vector<Camera>& cameras, const std::function<void(double done)>& progress) {
  const auto start = std::chrono::steady_clock::now();
  auto report = [&](double done) {
    if (progress) progress(done);
  };
  RepairResult result;
  RepairSummary& summary = result.summary;
  result.background = background;
  result.first_new = background.size();
  if (background.size() == 0 || removed.size() == 0 || cameras.empty()) return result;

  summary.views = choose_views(cameras, options.max_views);
  Observation observation = observe(options.hole, background, removed, cameras, summary.views);
  summary.unobserved = static_cast<size_t>(std::count(observation.unobserved.begin(), observation.unobserved.end(), 1.0f));
  report(0.3);
  const size_t views = summary.views.size();
  std::vector<HoleView> before(views);
  for (size_t v = 0; v < views; ++v) before[v] = find_hole(options.hole, observation, v, background, cameras);
  result.replaced = uncovered_guesses(background, observation, before, cameras);
  if (!result.replaced.empty()) {
    std::vector<int> kept;
    std::vector<float> unobserved;
    for (size_t p = 0, next = 0; p < background.size(); ++p) {
      if (next < result.replaced.size() && result.replaced[next] == static_cast<int>(p)) ++next;
      else kept.push_back(static_cast<int>(p)), unobserved.push_back(observation.unobserved[p]);
    }
    result.background = background.select(kept), observation.unobserved = std::move(unobserved);
    result.first_new = result.background.size();
    for (size_t v = 0; v < views; ++v) before[v] = find_hole(options.hole, observation, v, result.background, cameras);
  }
  report(0.5);

  // Planes, all views at once.
  const Surfaces surfaces = find_surfaces(before, observation, result.background, cameras, options.ring, options.max_planes);
  std::vector<HoleGeometry> geometry;
  for (size_t v = 0; v < views; ++v) {
    geometry.push_back(place_hole(surfaces, before[v], cameras[summary.views[v]], options.ring));
    for (int pixel : geometry[v].nowhere) observation.ignored[v].data[pixel] = 1, before[v].hole.data[pixel] = 0;
    before[v].pixels -= geometry[v].nowhere.size();
    summary.hole_before.push_back(before[v].pixels);
  }
  if (const int support = support_plane(surfaces, geometry, removed); support >= 0) {
    const PlanePicture wide =
        picture_plane({.margin = 2.0f, .most_texels = 240}, surfaces, support, before, geometry, observation, result.background, cameras);
    const Shadow shadow = find_shadow(options.shadow, wide);
    summary.shadow = shadow.verdict, summary.shadow_doubt = shadow.doubt, summary.shadow_darkest = shadow.darkest;
    summary.shadow_lifted = options.repair_shadow && shadow.verdict == Shadow::Verdict::kPlain;
    if (summary.shadow_lifted) {
      summary.shadow_gaussians = lift_shadow(shadow, result.background);
      for (size_t v = 0; v < views; ++v) before[v].picture = find_hole(options.hole, observation, v, result.background, cameras).picture;
    }
  }
  const GaussianCloud lit = result.background;
  for (size_t k = 0; k < surfaces.plane.size(); ++k) {
    const PlanePicture picture =
        picture_plane({}, surfaces, static_cast<int>(k), before, geometry, observation, lit, cameras);
    if (picture.empty()) continue;
    const GaussianCloud patch =
        inside_holes(plane_patch(picture, lit, options.exemplar), before, summary.views, cameras);
    if (patch.size() == 0) continue;
    result.background.append(patch);
    summary.plane_gaussians += patch.size(), ++summary.planes;
  }
  report(0.7);

  // What is left, one view after the other, largest hole first.
  std::vector<HoleView> now(views);
  for (size_t v = 0; v < views; ++v) now[v] = find_hole(options.hole, observation, v, result.background, cameras);
  std::vector<size_t> order(views);
  std::iota(order.begin(), order.end(), size_t(0));
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return now[a].pixels > now[b].pixels; });
  bool added = false;
  for (int turn = 0; turn < options.max_view_patches && turn < static_cast<int>(views); ++turn) {
    const size_t v = order[turn];
    if (added) now[v] = find_hole(options.hole, observation, v, result.background, cameras);
    if (now[v].pixels < options.min_pixels) continue;
    const GaussianCloud patch =
        inside_holes(view_patch(now[v], cameras[summary.views[v]], options.exemplar), before, summary.views, cameras);
    result.background.append(patch);
    summary.view_gaussians += patch.size();
    added = added || patch.size() > 0;
  }
  report(0.85);
  for (size_t v = 0; v < views; ++v) {
    if (added) now[v] = find_hole(options.hole, observation, v, result.background, cameras);
    summary.hole_after.push_back(now[v].pixels);
    summary.outside_change = std::max(summary.outside_change, change_outside(before[v], now[v]));
  }
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  report(1);
  return result;
}

ImageF repair_sheet(const RepairResult& result, const GaussianCloud& background, const GaussianCloud& removed,
                    const std::vector<Camera>& cameras) {
  const RepairSummary& summary = result.summary;
  std::vector<size_t> order(summary.hole_before.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return summary.hole_before[a] > summary.hole_before[b]; });
  // The largest hole, then views spread over the rest so that the sides of the hole are shown too.
  std::vector<size_t> chosen;
  for (size_t k = 0; k < 4 && k < order.size(); ++k) chosen.push_back(order[k * order.size() / std::min<size_t>(4, order.size())]);
  if (chosen.empty()) return ImageF(1, 1, 3);
  GaussianCloud scene = background;
  scene.append(removed);
  constexpr int kGap = 6;
  const Camera& first = cameras[summary.views[chosen[0]]];
  ImageF sheet(3 * (first.width + kGap) + kGap, static_cast<int>(chosen.size()) * (first.height + kGap) + kGap, 3, 0.1f);
  for (size_t row = 0; row < chosen.size(); ++row) {
    Camera camera = cameras[summary.views[chosen[row]]];
    if (camera.width != first.width || camera.height != first.height)
      camera = camera.scaled(std::min(static_cast<double>(first.width) / camera.width, static_cast<double>(first.height) / camera.height));
    const GaussianCloud* clouds[3] = {&scene, &background, &result.background};
    for (int column = 0; column < 3; ++column) {
      const ImageF picture = render(*clouds[column], camera).color;
      for (int y = 0; y < std::min(picture.height, first.height); ++y)
        std::copy_n(picture.at(0, y), 3 * std::min(picture.width, first.width),
                    sheet.at(kGap + column * (first.width + kGap), kGap + static_cast<int>(row) * (first.height + kGap) + y));
    }
  }
  return sheet;
}

}  // namespace pliant
