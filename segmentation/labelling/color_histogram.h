#pragma once

#include <array>
#include <cmath>

#include "gaussians/base/image.h"
#include "segmentation/graph/color_model.h"

namespace pliant {

/// Shares of colours in coarse bins of Lab (see lab_of_rgb), each colour spread over the nearest bins.
class ColorHistogram {
 public:
  void add(const Vec3f& lab, float weight = 1);
  bool empty() const { return total_ <= 0; }
  /// Share of the bin of a colour, 0..1.
  float share(const Vec3f& lab) const;
  /// Bhattacharyya coefficient: 1 = the same colours, 0 = none in common.
  float likeness(const ColorHistogram& other) const;
  /// keep of this and 1 - keep of the other one.
  void blend(const ColorHistogram& other, float keep);

 private:
  static constexpr int kLight = 8, kColor = 10;
  struct Corner {
    int bin;
    float weight;
  };
  static std::array<Corner, 8> corners(const Vec3f& lab);

  std::array<float, kLight* kColor* kColor> count_ = {};
  float total_ = 0;
};

/// Colours of the pixels where inside(i) holds; lab [h, w, 3].
template <class Inside>
ColorHistogram histogram_of(const ImageF& lab, Inside&& inside) {
  ColorHistogram histogram;
  for (size_t i = 0; i < lab.pixels(); ++i)
    if (inside(i)) histogram.add(Eigen::Map<const Vec3f>(lab.data.data() + 3 * i));
  return histogram;
}

/// lab_of_rgb of every pixel of a picture [h, w, 3].
ImageF lab_picture(const ImageF& picture);

}  // namespace pliant
