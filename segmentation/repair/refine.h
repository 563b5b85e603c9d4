#pragma once

#include <functional>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/image.h"
#include "gaussians/render/render.h"

namespace pliant {

/// What a view should show in and around its hole.
struct FilledView {
  Camera camera;
  ImageF color;  ///< [H, W, 3]
  ImageU8 mask;  ///< [H, W, 1] 1 = filled
};

struct RefineOptions {
  int rounds = 8;              ///< over all views; 0 = nothing is refined
  int max_views = 12;          ///< with the largest holes
  int ring = 3;                ///< pixels around a hole in which the picture must stay as it is
  float color_rate = 0.01f;    ///< of Adam [colour]
  float opacity_rate = 0.03f;  ///< [logit]
  float scale_rate = 0.01f;    ///< [log]
  float most_scale = 0.35f;    ///< largest change of a log scale
};

struct RefineSummary {
  size_t views = 0;
  double mse_before = 0, mse_after = 0;  ///< in the holes of the views
  bool kept = false;                     ///< false: it was no improvement, and nothing changed
};

/// Makes the Gaussians from `first_new` on reproduce the filled views: descends on the mean squared difference in the
/// holes and a ring around them, through the reverse pass of the renderer, over their colour, opacity and scale.  All
/// others enter the pictures and are left bit for bit as they are.  Equal for any number of threads.
/// `under_way` is called before each step; it may throw.
RefineSummary refine(const RefineOptions& options, const std::vector<FilledView>& views, size_t first_new,
                     GaussianCloud& cloud, const RenderOptions& render_options = {},
                     const std::function<void()>& under_way = {});

}  // namespace pliant
