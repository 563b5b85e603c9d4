#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/image.h"
#include "gaussians/base/types.h"
#include "gaussians/io/camera_file.h"

namespace pliant {

struct TrainingPhoto {
  Camera camera;          ///< pinhole without distortion, of the size of `pixels`
  ImageU8 pixels;         ///< [H, W, 3]
  ImageU8 weight;         ///< [H, W, 1] 255 = counts, 0 = the photo says nothing here; empty = all pixels count
  bool held_out = false;  ///< never trained on
};

struct PhotoOptions {
  int longest_side = 960;  ///< px; larger photos are scaled down to it; 0 = never
  int hold_out_every = 8;  ///< in the order of names, photo i is held out when i % hold_out_every == 0; 0 = none
  Vec3f background = Vec3f::Zero();  ///< on which photos with an alpha channel are put
};

struct TrainingPhotos {
  std::vector<TrainingPhoto> photos;
  bool changed = false;  ///< undistorted, scaled, turned or composited: no longer the files on disk
  std::vector<std::string> warnings;
};

}  // namespace pliant
