#pragma once

#include <functional>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/image.h"
#include "segmentation/labels/segmentation.h"

namespace pliant {

/// Colour of an id in sheets and overlays; neighbouring ids differ in hue.
Vec3f id_color(uint32_t id);

/// `picture` with the ids laid over it: each id's colour mixed in by `strength` and its outline drawn.
ImageF overlay_ids(const ImageF& picture, const IdImage& ids, float strength = 0.45f);

/// A part of a sheet that shows a part of a camera's picture: picture px = origin + (sheet px - (x, y)) * scale.
struct SheetCell {
  int x = 0, y = 0, width = 0, height = 0;  ///< on the sheet
  int camera = -1;
  double origin_x = 0, origin_y = 0, scale = 1;
};

/// Contact sheet for objects.png: the view that shows most objects with ids laid over it, and below a crop of every
/// object, at most the 200 with the most Gaussians, from the view that shows it largest, with id, name and confidence.
/// `picture` gives the photo of a camera, or a render where there is none.  At most `max_views` cameras, evenly chosen,
/// are looked at.  `cells` gets what is where.
ImageF objects_sheet(const Segmentation& segmentation, const GaussianCloud& cloud, const std::vector<Camera>& cameras,
                     const std::function<ImageF(int camera)>& picture, int max_views = 12,
                     std::vector<SheetCell>* cells = nullptr);

}  // namespace pliant
