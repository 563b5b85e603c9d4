#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/image.h"
#include "gaussians/base/types.h"
#include "gaussians/io/cameras/camera_file.h"

namespace pliant {

struct TrainingPhoto {
  Camera camera;   ///< pinhole without distortion, of the size of `pixels`; `photo` is the file on disk
  Camera lens;     ///< with the lens that was undone, of the size of the photo that it was undone in; width 0 = none
  ImageU8 pixels;  ///< [H, W, 3]
  ImageU8 weight;  ///< [H, W, 1] 255 = counts, 0 = the photo says nothing here; empty = all pixels count
  ImageU8 alpha;   ///< [H, W, 1] how much of a pixel is the photo and not PhotoOptions::background; empty = all of it
  bool held_out = false;  ///< never trained on
  bool changed = false;   ///< undistorted, scaled, turned or composited: no longer the file on disk
};

struct PhotoOptions {
  int longest_side = 960;  ///< px; larger photos are scaled down to it; 0 = never
  int hold_out_every = 8;  ///< in the order of names, photo i is held out when i % hold_out_every == 0; 0 = none
  Vec3f background = Vec3f::Zero();  ///< on which photos with an alpha channel are put
};

struct TrainingPhotos {
  std::vector<TrainingPhoto> photos;  ///< in the order of their cameras' names
  bool changed = false;               ///< undistorted, scaled, turned or composited: no longer the files on disk
  std::vector<std::string> warnings;
};

/// Smaller sides of a photo cannot be measured: SSIM compares windows of 11 x 11 pixels.
constexpr int kSmallestSide = 11;

/// Fewer photos do not determine a scene.
constexpr int kFewestPhotos = 3;

/// Reads the photos of `file`, which was read with PhotoFit::kEachPhoto, and makes each one the picture of a pinhole:
///  - a camera of another size but the same shape is scaled to its photo; the pixels that cameras refer to are the
///    stored ones unless only the picture turned by its EXIF orientation has the camera's shape;
///  - alpha is put on the background; larger photos are scaled down by area average, intrinsics exactly with them;
///  - the lens is undone by Catmull-Rom interpolation; the pinhole keeps the rectangle that the photo covers
///    (make_undistortion), and pixels that it does not cover all the same have weight 0.
/// Photos that cannot be used are left out with a warning.  Throws Error{kInput} when fewer than kFewestPhotos are left
/// or none to train on.
TrainingPhotos load_training_photos(const PhotoOptions& options, const CameraFile& file);

/// Writes the photos that are no longer the files on disk as PNG to `folder`, named after their cameras, and returns
/// the cameras of all photos with the files that show what was trained on.
std::vector<Camera> write_training_photos(const std::filesystem::path& folder, const TrainingPhotos& photos);

}  // namespace pliant
