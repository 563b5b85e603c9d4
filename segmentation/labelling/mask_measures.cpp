#include "segmentation/labelling/mask_measures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"

namespace pliant {

size_t pixels_of(const ImageF& logits) {
  return static_cast<size_t>(std::count_if(logits.data.begin(), logits.data.end(), [](float m) { return m > 0; }));
}

MaskPrompt::Box box_of_mask(const ImageF& logits) {
  MaskPrompt::Box box{INFINITY, INFINITY, -INFINITY, -INFINITY};
  for (int y = 0; y < logits.height; ++y)
    for (int x = 0; x < logits.width; ++x) {
      if (!(logits(x, y) > 0)) continue;
      box.x0 = std::min<float>(box.x0, x);
      box.x1 = std::max<float>(box.x1, x + 1);
      box.y0 = std::min<float>(box.y0, y);
      box.y1 = std::max<float>(box.y1, y + 1);
    }
  return box;
}

float stability(const ImageF& logits, float offset) {
  size_t sure = 0, maybe = 0;
  for (const float logit : logits.data) {
    sure += logit > offset;
    maybe += logit > -offset;
  }
  return maybe > 0 ? static_cast<float>(sure) / static_cast<float>(maybe) : 0;
}

float mask_iou(const ImageF& a, const ImageF& b) {
  CHECK(a.width == b.width && a.height == b.height);
  size_t both = 0, either = 0;
  for (size_t i = 0; i < a.data.size(); ++i) {
    both += a.data[i] > 0 && b.data[i] > 0;
    either += a.data[i] > 0 || b.data[i] > 0;
  }
  return either > 0 ? static_cast<float>(both) / static_cast<float>(either) : 0;
}

float box_iou(const MaskPrompt::Box& a, const MaskPrompt::Box& b) {
  const auto area = [](float x0, float y0, float x1, float y1) {
    return std::max(0.0f, x1 - x0) * std::max(0.0f, y1 - y0);
  };
  const float both = area(std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1));
  const float either = area(a.x0, a.y0, a.x1, a.y1) + area(b.x0, b.y0, b.x1, b.y1) - both;
  return either > 0 ? both / either : 0;
}

void tidy_parts(const std::vector<uint8_t>& given, float least, float least_hole, ImageF& logits) {
  CHECK(given.size() == logits.data.size() && logits.channels == 1);
  cv::Mat mask(logits.height, logits.width, CV_8U), number, stats, centres;
  int pixels = 0;
  for (size_t i = 0; i < given.size(); ++i) pixels += mask.data[i] = logits.data[i] > 0;
  // First the parts, then what the mask encloses.
  for (const bool holes : {false, true}) {
    const int count = cv::connectedComponentsWithStats(holes ? cv::Mat(mask == 0) : mask, number, stats, centres,
                                                       holes ? 4 : 8, CV_32S);
    std::vector<uint8_t> turns(count, 0);
    for (int k = 1; k < count; ++k) {
      const int* s = stats.ptr<int>(k);
      const bool open = s[cv::CC_STAT_LEFT] == 0 || s[cv::CC_STAT_TOP] == 0 ||
                        s[cv::CC_STAT_LEFT] + s[cv::CC_STAT_WIDTH] == mask.cols ||
                        s[cv::CC_STAT_TOP] + s[cv::CC_STAT_HEIGHT] == mask.rows;
      const float share = static_cast<float>(s[cv::CC_STAT_AREA]) / static_cast<float>(std::max(1, pixels));
      turns[k] = holes ? !open && share < least_hole : share < least;
    }
    const int* part = number.ptr<int>();
    for (size_t i = 0; i < given.size(); ++i)
      if (given[i]) turns[part[i]] = 0;
    for (size_t i = 0; i < given.size(); ++i)
      if (turns[part[i]]) {
        logits.data[i] = -logits.data[i];
        mask.data[i] = !holes ? 0 : 1;
      }
  }
}

}  // namespace pliant
