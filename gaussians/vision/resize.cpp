#include "gaussians/vision/resize.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"
#include "gaussians/vision/as_mat.h"

namespace pliant {

ImageF resized(const ImageF& picture, int width, int height) {
  CHECK(picture.channels == 3);
  if (picture.width == width && picture.height == height) return picture;
  ImageF out(width, height, 3);
  const cv::Mat from = as_mat(picture);
  cv::Mat to = as_mat(out);
  const bool smaller = static_cast<size_t>(width) * height < picture.pixels();
  cv::resize(from, to, to.size(), 0, 0, smaller ? cv::INTER_AREA : cv::INTER_LINEAR);
  return out;
}

}  // namespace pliant
