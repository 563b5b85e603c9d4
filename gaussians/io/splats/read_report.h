#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace pliant {

/// What was met while reading a splat file, in sentences for the user.
struct ReadReport {
  std::string format;                        ///< for example "3DGS PLY, SH degree 3"
  size_t rows = 0;                           ///< records in the file
  size_t dropped = 0;                        ///< rows with NaN, infinite or absurd values that were left out
  bool antialiased = false;                  ///< the file, or the scene, says that it was trained with mip-splatting
  bool z_is_up = false;                      ///< the file says that +z points up
  bool nerfstudio = false;                   ///< the file says that nerfstudio wrote it
  int levels = 1;                            ///< levels of detail that the file offers
  int level = 0;                             ///< the one that was read, 0 = finest; kAllLevels = all
  std::vector<std::filesystem::path> files;  ///< every file that was read, the named one first
  std::vector<float> object_features;        ///< [N, object_channels] obj_dc_* of Gaussian Grouping (Ye et al. 2024)
  int object_channels = 0;                   ///< 0 = the file has none
  std::vector<std::string> warnings;
};

}  // namespace pliant
