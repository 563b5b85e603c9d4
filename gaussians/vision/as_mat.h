#pragma once

#include <opencv2/core.hpp>

#include "gaussians/base/image.h"

namespace pliant {

/// The pixels of a picture [H, W, C] as OpenCV sees them: nothing is copied, so that `image` must live longer; what
/// came from a const image is not to be written.
inline cv::Mat as_mat(const ImageF& image) {
  return {image.height, image.width, CV_32FC(image.channels), const_cast<float*>(image.data.data())};
}

}  // namespace pliant
