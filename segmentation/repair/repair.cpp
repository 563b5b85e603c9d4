#include "segmentation/repair/repair.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "segmentation/repair/chosen_views.h"
#include "segmentation/repair/patch.h"
#include "segmentation/repair/surfaces.h"
#include "segmentation/repair/visible.h"

namespace pliant {
namespace {

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
      for (int k = 0; k < 3; ++k) {
        sum += std::abs(before.picture.color(x, y, k) - after.picture.color(x, y, k));
        ++count;
      }
    }
  return count ? static_cast<float>(sum / static_cast<double>(count)) : 0.0f;
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
    for (const Vec3f& x : object.position)
      height.push_back(surfaces.plane[k].plane.normal.dot(x - surfaces.plane[k].plane.point));
    std::sort(height.begin(), height.end());
    const float low = height[height.size() / 50], high = height[height.size() - 1 - height.size() / 50];
    if (std::abs(low) < 0.1f * (high - low)) best = static_cast<int>(k);
  }
  return best;
}

/// The repair of one scene, step by step.
class Repair {
 public:
  Repair(const RepairOptions& options, const GaussianCloud& background, const GaussianCloud& removed,
         const std::vector<Camera>& cameras, const std::function<void(double done)>& report, Inpainter* inpainter)
      : options_(options), removed_(removed), report_(report), inpainter_(inpainter) {
    for (const Camera& camera : cameras) cameras_.push_back(scaled_down(camera, options.longest_side));
    result_.background = background;
    summary_.views = choose_evenly(cameras_, candidates(), options.max_views);
    observation_ =
        observe(options.hole, background, removed, cameras_, summary_.views, options.render, [&] { report_(0); });
    for (const ImageF& weight : observation_.object)
      summary_.object_seen |=
          std::any_of(weight.data.begin(), weight.data.end(), [&](float w) { return w >= options.hole.min_object; });
    summary_.unobserved =
        static_cast<size_t>(std::count(observation_.unobserved.begin(), observation_.unobserved.end(), 1.0f));
  }

  void find_holes() {
    before_.resize(views());
    for (size_t v = 0; v < views(); ++v) {
      before_[v] = hole(v);
      report_(0.3 + 0.2 * static_cast<double>(v) / static_cast<double>(views()));
    }
    result_.replaced = uncovered_guesses(result_.background, observation_, before_, cameras_);
    if (!result_.replaced.empty()) {
      take_out(result_.replaced);
      for (size_t v = 0; v < views(); ++v) before_[v] = hole(v);
    }
    result_.first_new = result_.background.size();
    surfaces_ = find_surfaces(before_, observation_, result_.background, cameras_, options_.ring, options_.max_planes);
    for (size_t v = 0; v < views(); ++v) {
      geometry_.push_back(place_hole(surfaces_, before_[v], observation_, v, camera(v), options_.ring));
      for (int pixel : geometry_[v].nowhere) {
        observation_.ignored[v].data[pixel] = 1;
        before_[v].hole.data[pixel] = 0;
      }
      before_[v].pixels -= geometry_[v].nowhere.size();
      summary_.hole_before.push_back(before_[v].pixels);
    }
  }

  void look_for_shadow() {
    const int support = support_plane(surfaces_, geometry_, removed_);
    if (support < 0) return;
    const Shadow shadow = find_shadow(options_.shadow, picture(support, {.margin = 2.0f, .most_texels = 240}));
    summary_.shadow = shadow.verdict;
    summary_.shadow_doubt = shadow.doubt;
    summary_.shadow_darkest = shadow.darkest;
    summary_.shadow_lifted = options_.repair_shadow && shadow.verdict == Shadow::Verdict::kPlain;
    if (!summary_.shadow_lifted) return;
    summary_.shadow_gaussians = lift_shadow(shadow, result_.background);
    for (size_t v = 0; v < views(); ++v) before_[v].picture = hole(v).picture;
  }

  /// All views at once; without an inpainter from the planes' own texture.
  void fill_planes() {
    const int count = static_cast<int>(surfaces_.plane.size());
    for (int k = 0; k < count; ++k) planes_.emplace_back(picture(k, {}));
    used_.assign(planes_.size(), 0);
    if (inpainter_) return;
    for (size_t k = 0; k < planes_.size(); ++k) {
      if (planes_[k].picture.empty()) continue;
      report_(0.5 + 0.2 * static_cast<double>(k) / count);
      fill_from_texture(planes_[k], options_.exemplar);
      add_texels(k, planes_[k].colored);
    }
  }

  /// What is left, one view after the other, largest hole first.  Holes only shrink, so a size that was measured before
  /// the last patch is an upper bound.
  void fill_views() {
    now_.resize(views());
    measured_.assign(views(), -1);
    for (size_t v = 0; v < views(); ++v) measure(v);
    std::vector<uint8_t> done(views(), 0);
    for (int turn = 0; turn < options_.max_view_patches; ++turn) {
      const size_t v = largest_hole(done);
      if (v == views() || now_[v].pixels < options_.min_pixels) return;
      done[v] = 1;
      report_(0.7 + 0.1 * turn / options_.max_view_patches);
      fill_view(v);
    }
  }

  void refine_new() {
    std::vector<FilledView> wanted;
    for (size_t v = 0; v < views(); ++v) {
      measure(v);
      wanted.push_back(show_planes(planes_, now_[v].picture.color, before_[v].hole, geometry_[v], camera(v)));
    }
    summary_.refinement =
        refine(options_.refine, wanted, result_.first_new, result_.background, options_.render, [&] { report_(0.8); });
    if (summary_.refinement.kept) ++patches_;
  }

  RepairResult finish() {
    summary_.planes = static_cast<size_t>(std::count(used_.begin(), used_.end(), 1));
    for (size_t v = 0; v < views(); ++v) {
      measure(v);
      summary_.hole_after.push_back(now_[v].pixels);
      summary_.outside_change = std::max(summary_.outside_change, change_outside(before_[v], now_[v]));
    }
    return std::move(result_);
  }

 private:
  /// Cameras that show the object; all where none does, or where all may be looked at.
  std::vector<int> candidates() const {
    std::vector<int> out;
    if (cameras_.size() > static_cast<size_t>(options_.max_views))
      out = cameras_with_object(options_.hole, result_.background, removed_, cameras_, options_.render,
                                [&] { report_(0); });
    if (out.empty()) {
      out.resize(cameras_.size());
      std::iota(out.begin(), out.end(), 0);
    }
    return out;
  }
  size_t views() const { return summary_.views.size(); }
  const Camera& camera(size_t v) const { return cameras_[summary_.views[v]]; }
  HoleView hole(size_t v) const {
    return find_hole(options_.hole, observation_, v, result_.background, cameras_, options_.render);
  }
  PlanePicture picture(int plane, const PlanePictureOptions& options) const {
    return picture_plane(options, surfaces_, plane, before_, geometry_, observation_, result_.background, cameras_,
                         options_.render);
  }

  void take_out(const std::vector<int>& gone) {
    std::vector<int> kept;
    std::vector<float> unobserved;
    for (size_t p = 0, next = 0; p < result_.background.size(); ++p) {
      if (next < gone.size() && gone[next] == static_cast<int>(p))
        ++next;
      else {
        kept.push_back(static_cast<int>(p));
        unobserved.push_back(observation_.unobserved[p]);
      }
    }
    result_.background = result_.background.select(kept);
    observation_.unobserved = std::move(unobserved);
  }

  size_t add(const GaussianCloud& patch) {
    const GaussianCloud inside = inside_holes(patch, before_, observation_, cameras_);
    result_.background.append(inside);
    patches_ += inside.size() > 0;
    return inside.size();
  }
  void add_texels(size_t k, const ImageU8& texels) {
    const size_t added = add(plane_patch(planes_[k], texels, result_.background));
    summary_.plane_gaussians += added;
    used_[k] |= added > 0;
  }

  void measure(size_t v) {
    if (measured_[v] != patches_) {
      now_[v] = hole(v);
      measured_[v] = patches_;
    }
  }
  size_t largest_hole(const std::vector<uint8_t>& done) {
    for (;;) {
      size_t largest = views();
      for (size_t v = 0; v < views(); ++v)
        if (!done[v] && (largest == views() || now_[v].pixels > now_[largest].pixels)) largest = v;
      if (largest == views() || measured_[largest] == patches_) return largest;
      measure(largest);
    }
  }
  void fill_view(size_t v) {
    const ViewFill fill = pliant::fill_view(now_[v], options_.exemplar, inpainter_);
    ImageU8 rest = now_[v].hole;
    if (inpainter_) {
      ++summary_.inpainted_views;
      for (size_t k = 0; k < planes_.size(); ++k)
        if (!planes_[k].picture.empty())
          add_texels(k, fill_from_view(planes_[k], static_cast<int>(k), fill, geometry_[v], camera(v)));
      for (size_t i = 0; i < rest.data.size(); ++i) rest.data[i] = rest.data[i] && geometry_[v].plane[i] < 0;
    }
    summary_.view_gaussians += add(view_patch(now_[v], camera(v), fill.color, rest));
  }

  const RepairOptions& options_;
  const GaussianCloud& removed_;
  std::vector<Camera> cameras_;  ///< scaled down
  const std::function<void(double done)>& report_;
  Inpainter* inpainter_;
  RepairResult result_;
  RepairSummary& summary_ = result_.summary;
  Observation observation_;
  std::vector<HoleView> before_, now_;  ///< [views] of the hole, and after the patches so far
  std::vector<int> measured_;           ///< [views] patches when now_ was rendered
  int patches_ = 0;
  Surfaces surfaces_;
  std::vector<HoleGeometry> geometry_;  ///< [views]
  std::vector<PlaneFill> planes_;
  std::vector<uint8_t> used_;  ///< [planes] 1 = has new Gaussians
};

}  // namespace

RepairResult repair(const RepairOptions& options, const GaussianCloud& background, const GaussianCloud& removed,
                    const std::vector<Camera>& cameras, const std::function<void(double done)>& progress,
                    Inpainter* inpainter) {
  const auto start = std::chrono::steady_clock::now();
  const std::function<void(double done)> report = [&](double done) {
    if (progress) progress(done);
  };
  if (background.size() == 0 || removed.size() == 0 || cameras.empty()) {
    RepairResult untouched;
    untouched.background = background;
    untouched.first_new = background.size();
    return untouched;
  }
  Repair work(options, background, removed, cameras, report, inpainter);
  report(0.3);
  work.find_holes();
  report(0.5);
  work.look_for_shadow();
  work.fill_planes();
  report(0.7);
  work.fill_views();
  report(0.8);
  work.refine_new();
  report(0.9);
  RepairResult result = work.finish();
  result.summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  report(1);
  return result;
}

}  // namespace pliant
