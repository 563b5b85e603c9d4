#include "gaussians/vision/optical_flow.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/video/tracking.hpp>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"

namespace pliant {
namespace {

/// One thread in OpenCV while it lives.
class OneThread {
 public:
  OneThread() : before_(cv::getNumThreads()) { cv::setNumThreads(1); }
  ~OneThread() { cv::setNumThreads(before_); }
  OneThread(const OneThread&) = delete;

 private:
  int before_;
};

cv::Mat grey_of(const ImageF& picture) {
  CHECK(picture.channels == 3);
  cv::Mat grey(picture.height, picture.width, CV_8UC1);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const float* c = picture.at(x, y);
      grey.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(255 * (0.299f * c[0] + 0.587f * c[1] + 0.114f * c[2]));
    }
  return grey;
}

}  // namespace

std::vector<ImageF> dense_flows(std::span<const ImageF> frames, std::span<const std::pair<int, int>> pairs,
                                FlowQuality quality) {
  std::vector<cv::Mat> grey(frames.size());
  for (const auto& [from, to] : pairs)
    for (const int f : {from, to}) {
      CHECK(f >= 0 && f < static_cast<int>(frames.size()));
      if (grey[f].empty()) grey[f] = grey_of(frames[f]);
    }
  std::vector<ImageF> flows(pairs.size());
  const int preset =
      quality == FlowQuality::kFine ? cv::DISOpticalFlow::PRESET_MEDIUM : cv::DISOpticalFlow::PRESET_FAST;
  const OneThread one_thread;
  parallel_for(static_cast<std::ptrdiff_t>(pairs.size()), [&](std::ptrdiff_t i) {
    const cv::Mat &from = grey[pairs[i].first], &to = grey[pairs[i].second];
    CHECK(from.size() == to.size());
    cv::Mat flow;
    cv::DISOpticalFlow::create(preset)->calc(from, to, flow);
    flows[i] = ImageF(flow.cols, flow.rows, 2);
    for (int y = 0; y < flow.rows; ++y) std::copy_n(flow.ptr<float>(y), 2 * flow.cols, flows[i].at(0, y));
  });
  return flows;
}

float sample(const ImageF& picture, double u, double v, int channel) {
  const double x = std::clamp(u - 0.5, 0.0, picture.width - 1.0), y = std::clamp(v - 0.5, 0.0, picture.height - 1.0);
  const int x0 = std::min(static_cast<int>(x), std::max(0, picture.width - 2)),
            y0 = std::min(static_cast<int>(y), std::max(0, picture.height - 2));
  const int x1 = std::min(x0 + 1, picture.width - 1), y1 = std::min(y0 + 1, picture.height - 1);
  const float a = static_cast<float>(x - x0), b = static_cast<float>(y - y0);
  const float top = picture(x0, y0, channel) * (1 - a) + picture(x1, y0, channel) * a;
  const float bottom = picture(x0, y1, channel) * (1 - a) + picture(x1, y1, channel) * a;
  return top * (1 - b) + bottom * b;
}

}  // namespace pliant
