#pragma once

#include "gaussians/base/image.h"
#include "segmentation/labelling/id_picture.h"

namespace pliant {

/// `picture` with masks, boxes, names and scores over it, to look at.
ImageF overlay_labels(const ImageF& picture, const LabelledPhoto& photo);

}  // namespace pliant
