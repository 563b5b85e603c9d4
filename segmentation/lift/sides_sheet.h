#pragma once

#include <string>
#include <vector>

#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/image.h"
#include "gaussians/render/render.h"

namespace pliant {

/// One kind of Gaussians in a sheet: its name with their number, in its colour.
struct SheetKind {
  std::string name;
  Vec3f color = Vec3f::Ones();
  size_t count = 0;
};

/// An object from 8 sides: Gaussians of kind[p] >= 0 tinted in the colour of that kind, others darkened; below a legend
/// with the kinds and a caption.  `object` are the Gaussians that fill the pictures, `up` is the scene's unit up.
ImageF sides_sheet(const GaussianCloud& cloud, const std::vector<int>& object, const std::vector<int>& kind,
                   const std::vector<SheetKind>& kinds, const std::string& caption, const Eigen::Vector3d& up,
                   const RenderOptions& options);

}  // namespace pliant
