#pragma once

#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/render/render.h"
#include "gaussians/vision/match_pictures.h"

namespace pliant {

struct CameraRefineOptions {
  std::vector<int> sizes = {64, 128, 256,
                            512};  ///< px of the longer side, one after the other, up to the picture's own
  int iterations = 30;             ///< at each size
  double smallest_step = 0.01;     ///< px at which a size is done
};

struct RefinedCamera {
  Camera camera;
  PictureMatch before, after;  ///< of the picture with the scene
  double turned = 0;           ///< degrees against the start
  double moved = 0;            ///< scene units
  int renders = 0;
};

/// The pose near `start` (turned at most a quarter of its field of view away) from which `cloud` looks most like
/// `picture` [H, W, 3]: 0.8 L1 + 0.2 D-SSIM, from coarse to fine, by the method of Broyden, Fletcher, Goldfarb and
/// Shanno along the renderer's derivatives by the camera.  Poses turn about a point in the middle of the scene, which
/// keeps turns and shifts apart.  The picture's mean colours are first matched to the scene's, and shifts of the view
/// tried one by one on a coarse one.  The camera has the picture's size; its lens stays.
RefinedCamera refine_camera(const CameraRefineOptions& options, const GaussianCloud& cloud,
                            const RenderOptions& rendering, const Camera& start, const ImageF& picture);

struct FindCameraOptions {
  int search_size = 96;      ///< px of the longer side while known cameras are compared
  int candidates = 3;        ///< best known cameras that are refined
  double least_score = 0.3;  ///< of the refined view: below, the picture shows something else
  CameraRefineOptions refine;
};

struct FoundCamera {
  bool found = false;
  int nearest = -1;  ///< known camera that the search began from
  RefinedCamera refined;
  std::vector<double> scores;  ///< [cameras] of the known cameras (PictureMatch::score); -1 = another shape
  std::string sentence;        ///< for the user
};

/// The camera that took `picture`: the known cameras are compared with it, the best are refined coarsely and the best
/// of these finely.  Throws Error{kInput} when no camera has the picture's shape (within 2 %).
FoundCamera find_camera(const FindCameraOptions& options, const GaussianCloud& cloud, const RenderOptions& rendering,
                        const std::vector<Camera>& cameras, const ImageF& picture);

}  // namespace pliant
