#pragma once

#include <optional>
#include <span>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/image.h"
#include "gaussians/render/tiles.h"
#include "gaussians/simd/instruction_set.h"

namespace pliant {

/// Conventions of the reference 3DGS rasteriser (Kerbl et al. 2023, and its released code).
struct RenderOptions {
  Vec3f background = Vec3f::Zero();
  bool antialiased = false;  ///< opacity compensation for scenes trained with mip-splatting (Yu et al. 2024)
  double screen_variance = splat::kScreenVariance;  ///< of the low-pass filter (px^2)
  InstructionSet instruction_set = best_instruction_set();
  size_t most_pairs = kMostPairs;          ///< of splat and tile, held at a time
  std::optional<PictureFrame> frame = {};  ///< the whole picture, where the camera draws a part of one; see cropped

  /// The same for a part of a picture.
  RenderOptions within(const std::optional<PictureFrame>& whole) const {
    RenderOptions options = *this;
    options.frame = whole;
    return options;
  }
};

template <class T>
struct Rendered {
  Image<T> color;     ///< [H, W, 3] including the background; not clamped
  Image<T> depth;     ///< [H, W, 1] sum of blend weight * z; divide by alpha for the mean depth (scene units)
  Image<T> alpha;     ///< [H, W, 1] accumulated opacity, 1 - final transmittance
  Image<T> features;  ///< [H, W, C] blended extra channels; empty when there are none
};
using RenderResult = Rendered<float>;

/// What a picture leaves for its derivatives, so that they need not project and bin again.
template <class T>
struct RenderTape {
  ProjectedSplats<T> projected;
  std::optional<TileLists> lists;  ///< only when the picture is made in one band
};

/// Picture of `cloud` from `camera`.  `features` [N, channels] are blended like colour, without a background.
/// Equal bit for bit for any number of threads.  Memory: see project_splats and kMostPairs; linear in the Gaussians in
/// view and in the pairs of splat and tile, of which at most `most_pairs` are held.
RenderResult render(const CloudOf<float>& cloud, const Camera& camera, const RenderOptions& options = {},
                    std::span<const float> features = {}, int channels = 0, RenderTape<float>* tape = nullptr);

/// Derivatives of a scalar with respect to everything that makes a picture.
template <class T>
struct RenderGradient {
  CloudOf<T> cloud;
  std::vector<T> features;  ///< [N, channels]
  Vec3<T> background = Vec3<T>::Zero();
  Vec3<T> rotation =
      Vec3<T>::Zero();  ///< of the camera: cam_from_world <- (exp([rotation]), translation) cam_from_world
  Vec3<T> translation = Vec3<T>::Zero();
  std::vector<Mat3<T>> covariance;  ///< [N] when asked for: what rotation and log_scale say, as one symmetric matrix
  std::vector<Eigen::Matrix<T, 2, 1>> screen;  ///< [N, 2] when asked for: of the projected mean (u, v) in pixels
};

/// Derivatives that are made only when asked for.
struct GradientExtras {
  bool covariance = false, screen = false;
};

/// Derivatives of a scalar L of the picture, given dL/dpicture in `adj`, whose empty images count as zero.  `picture`
/// is the result of `render` for the same arguments, `tape` what it left (or null).  Equal bit for bit for any number
/// of threads.  Memory: 4 (10 + channels) bytes per pair of splat and tile in a band.
RenderGradient<float> render_adjoint(const CloudOf<float>& cloud, const Camera& camera, const RenderOptions& options,
                                     std::span<const float> features, int channels, const RenderResult& picture,
                                     const RenderResult& adj, const RenderTape<float>* tape = nullptr,
                                     const GradientExtras& extras = {});

}  // namespace pliant
