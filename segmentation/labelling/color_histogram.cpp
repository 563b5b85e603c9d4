#include "segmentation/labelling/color_histogram.h"

#include <algorithm>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"

namespace pliant {

std::array<ColorHistogram::Corner, 8> ColorHistogram::corners(const Vec3f& lab) {
  // L in 0..1; a and b mostly in -0.5..0.5, colours beyond share the outer bins.
  const float place[3] = {std::clamp(lab[0], 0.0f, 1.0f) * (kLight - 1),
                          std::clamp(lab[1] + 0.5f, 0.0f, 1.0f) * (kColor - 1),
                          std::clamp(lab[2] + 0.5f, 0.0f, 1.0f) * (kColor - 1)};
  std::array<Corner, 8> out;
  for (int k = 0; k < 8; ++k) {
    int bin[3];
    float weight = 1;
    for (int c = 0; c < 3; ++c) {
      const int most = (c == 0 ? kLight : kColor) - 1, low = std::min(static_cast<int>(place[c]), most - 1);
      const bool high = k >> c & 1;
      bin[c] = low + high;
      weight *= high ? place[c] - low : 1 - (place[c] - low);
    }
    out[k] = {(bin[0] * kColor + bin[1]) * kColor + bin[2], weight};
  }
  return out;
}

void ColorHistogram::add(const Vec3f& lab, float weight) {
  for (const Corner& corner : corners(lab)) count_[corner.bin] += weight * corner.weight;
  total_ += weight;
}

float ColorHistogram::share(const Vec3f& lab) const {
  float sum = 0;
  for (const Corner& corner : corners(lab)) sum += corner.weight * count_[corner.bin];
  return empty() ? 0 : sum / total_;
}

float ColorHistogram::likeness(const ColorHistogram& other) const {
  if (empty() || other.empty()) return 0;
  float sum = 0;
  for (size_t i = 0; i < count_.size(); ++i) sum += std::sqrt(count_[i] / total_ * (other.count_[i] / other.total_));
  return sum;
}

void ColorHistogram::blend(const ColorHistogram& other, float keep) {
  if (other.empty()) return;
  const float a = empty() ? 0 : keep / total_, b = (empty() ? 1 : 1 - keep) / other.total_;
  for (size_t i = 0; i < count_.size(); ++i) count_[i] = a * count_[i] + b * other.count_[i];
  total_ = 1;
}

ImageF lab_picture(const ImageF& picture) {
  CHECK(picture.channels == 3 && !picture.empty());
  ImageF lab(picture.width, picture.height, 3);
  parallel_for(
      static_cast<std::ptrdiff_t>(picture.pixels()),
      [&](std::ptrdiff_t i) {
        const Vec3f rgb = Eigen::Map<const Vec3f>(picture.data.data() + 3 * i);
        Eigen::Map<Vec3f>(lab.data.data() + 3 * i) = lab_of_rgb(rgb);
      },
      4096);
  return lab;
}

}  // namespace pliant
