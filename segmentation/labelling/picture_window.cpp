#include "segmentation/labelling/picture_window.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"
#include "gaussians/vision/as_mat.h"

namespace pliant {

PictureWindow::PictureWindow(int picture_width, int picture_height, const MaskPrompt::Box& area, int longest) {
  CHECK(picture_width > 0 && picture_height > 0 && longest > 0);
  const auto whole = [](float value, int low, int high) { return std::clamp(static_cast<int>(value), low, high); };
  x0 = whole(std::floor(area.x0), 0, picture_width - 1);
  x1 = whole(std::ceil(area.x1), x0 + 1, picture_width);
  y0 = whole(std::floor(area.y0), 0, picture_height - 1);
  y1 = whole(std::ceil(area.y1), y0 + 1, picture_height);
  const double scale = static_cast<double>(longest) / std::max(x1 - x0, y1 - y0);
  width = std::max(1, static_cast<int>((x1 - x0) * scale + 0.5));
  height = std::max(1, static_cast<int>((y1 - y0) * scale + 0.5));
}

ImageF PictureWindow::read(const ImageF& picture) const {
  ImageF out(width, height, picture.channels);
  cv::Mat to = as_mat(out);
  const cv::Mat from = as_mat(picture)(cv::Rect(x0, y0, x1 - x0, y1 - y0));
  cv::resize(from, to, to.size(), 0, 0, width < x1 - x0 ? cv::INTER_AREA : cv::INTER_LINEAR);
  return out;
}

ImageF PictureWindow::write(const ImageF& values, int picture_width, int picture_height, float outside) const {
  CHECK(values.width == width && values.height == height && values.channels == 1);
  ImageF out(picture_width, picture_height, 1, outside);
  cv::Mat to = as_mat(out)(cv::Rect(x0, y0, x1 - x0, y1 - y0));
  cv::resize(as_mat(values), to, to.size(), 0, 0, cv::INTER_LINEAR);
  return out;
}

}  // namespace pliant
