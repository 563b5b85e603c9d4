#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// A field as PhysDreamer's released code stores it: features on three planes (xy, xz, yz), bilinear and summed, and a
/// network of linear layers with ReLU between them.
struct PhysDreamerField {
  int channels = 1, features = 0, hidden = 0, layers = 0, resolution = 0;
  std::vector<double> parameters;  ///< planes [3, features, resolution, resolution], then weight and bias of each layer
  std::optional<std::array<Vec3d, 2>> box;  ///< low and high end of the planes, in the cube; none = that of the points
};

/// Reads sim_fields.pt (one channel) or velo_fields.pt (three) with the safe reader of state_dict.h; tensors are told
/// by their shapes: three planes [features, n, n], which may have a leading 1, in the order of the file, then weights
/// [out, in] each with its bias [out]; the box `aabb` [2, 3] by its name.  Throws Error{kInput} naming what is missing
/// or does not fit together.
PhysDreamerField read_physdreamer_field(const std::filesystem::path& file, int channels);

}  // namespace pliant
