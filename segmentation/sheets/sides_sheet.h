#pragma once

#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/image.h"
#include "gaussians/render/render.h"
#include "segmentation/sheets/objects_sheet.h"

namespace pliant {

/// One kind of Gaussians in a sheet: its name with their number, in its colour.
struct SheetKind {
  std::string name;
  Vec3f color = Vec3f::Ones();
  size_t count = 0;
};

/// Eight cameras around `object`, which fills their pictures; `up` is the scene's unit up.
std::vector<Camera> sheet_sides(const GaussianCloud& object, const Eigen::Vector3d& up);

/// Where a sheet shows the pictures of `sides`, whole, in their order.
std::vector<SheetCell> side_cells(const std::vector<Camera>& sides);

/// An object from the `sides` that sheet_sides gave: Gaussians of kind[p] >= 0 tinted in the colour of that kind,
/// others darkened; below a legend with the kinds and a caption.
ImageF sides_sheet(const GaussianCloud& cloud, const std::vector<Camera>& sides, const std::vector<int>& kind,
                   const std::vector<SheetKind>& kinds, const std::string& caption, const RenderOptions& options);

}  // namespace pliant
