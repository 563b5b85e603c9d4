#include "fitting/observe/hidden_pixels.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr int kHalfWindow = 5;             // px
constexpr double kLeastBackground = 0.05;  // of the background

bool leaves_background(std::span<const ImageU8> compared, const ImageU8& surroundings) {
  if (compared.empty()) return false;
  CHECK(compared[0].width == surroundings.width && compared[0].height == surroundings.height);
  size_t all = 0, seen = 0;
  for (size_t i = 0; i < surroundings.data.size(); ++i) {
    all += surroundings.data[i] == 0;
    seen += surroundings.data[i] == 0 && compared[0].data[i] != 0;
  }
  return static_cast<double>(seen) >= kLeastBackground * static_cast<double>(all);
}

}  // namespace

ImageU8 dilated(const ImageU8& mask, int radius) {
  ImageU8 out(mask.width, mask.height, 1);
  const cv::Mat from(mask.height, mask.width, CV_8UC1, const_cast<uint8_t*>(mask.data.data()));
  cv::Mat to(mask.height, mask.width, CV_8UC1, out.data.data());
  cv::dilate(from, to, cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(2 * radius + 1, 2 * radius + 1)));
  return out;
}

HiddenPixels::HiddenPixels(std::span<const ImageU8> compared, const ImageU8& surroundings)
    : compared_(leaves_background(compared, surroundings) ? compared : std::span<const ImageU8>()) {}

size_t HiddenPixels::seen(int frame, const ImageU8& mask) const {
  size_t count = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) count += mask(x, y) != 0 && !at(frame, x, y);
  return count;
}

ImageU8 HiddenPixels::beside(const ImageU8& ignored, int frame, int other) const {
  if (compared_.empty()) return ignored;
  ImageU8 hidden(ignored.width, ignored.height, 1);
  for (int y = 0; y < hidden.height; ++y)
    for (int x = 0; x < hidden.width; ++x) hidden(x, y) = at(frame, x, y) || at(other, x, y);
  hidden = dilated(hidden, kHalfWindow);
  for (size_t i = 0; i < hidden.data.size(); ++i) hidden.data[i] |= ignored.data[i];
  return hidden;
}

ImageF HiddenPixels::filled(const ImageF& picture, int frame, const ImageF& other) const {
  ImageF out = picture;
  for (int y = 0; y < out.height && any(); ++y)
    for (int x = 0; x < out.width; ++x)
      for (int c = 0; c < out.channels && at(frame, x, y); ++c) out(x, y, c) = other(x, y, c);
  return out;
}

ObjectFlow HiddenPixels::seen_flow(const ImageF& flow, const ImageF& contrast, ImageU8 object, ImageU8 surroundings,
                                   int frame, int other) const {
  const auto led_to = [](float from, float by, int size) {
    return static_cast<int>(std::clamp(from + 0.5f + by, 0.0f, static_cast<float>(size - 1)));
  };
  for (int y = 0; y < flow.height && any(); ++y)
    for (int x = 0; x < flow.width; ++x) {
      const int u = led_to(static_cast<float>(x), flow(x, y, 0), flow.width),
                v = led_to(static_cast<float>(y), flow(x, y, 1), flow.height);
      if (!at(frame, x, y) && !at(other, u, v)) continue;
      object(x, y) = 0;
      surroundings(x, y) = 1;
    }
  return object_flow(flow, contrast, object, surroundings);
}

}  // namespace pliant
