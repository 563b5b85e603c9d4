#pragma once

#include <functional>
#include <vector>

#include "segmentation/repair/hole.h"

namespace pliant {

constexpr int kSmallSide = 200;  ///< px, of pictures that only tell what a camera sees

/// The same view in a picture of at most `side` pixels a side.
Camera scaled_down(const Camera& camera, int side);

/// Cameras that show the object: its blend weight reaches min_object in a picture of side kSmallSide.  `under_way` is
/// called before each; it may throw.
std::vector<int> cameras_with_object(const HoleOptions& options, const GaussianCloud& background,
                                     const GaussianCloud& object, const std::vector<Camera>& cameras,
                                     const RenderOptions& render_options = {},
                                     const std::function<void()>& under_way = {});

/// At most `most` of the cameras `candidates`, evenly chosen whatever the order in which the cameras are given.
std::vector<int> choose_evenly(const std::vector<Camera>& cameras, std::vector<int> candidates, int most);

}  // namespace pliant
