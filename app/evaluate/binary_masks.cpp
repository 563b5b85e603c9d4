#include "app/evaluate/binary_masks.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/io/images/image_files.h"
#include "gaussians/io/images/image_io.h"
#include "segmentation/labels/agreement.h"

namespace pliant {

ImageU8 read_mask(const std::filesystem::path& file) {
  const ImageF picture = read_image(file);
  ImageU8 mask(picture.width, picture.height, 1);
  int brightest = 0;
  for (size_t i = 0; i < mask.data.size(); ++i) {
    const float* c = picture.data.data() + 3 * i;
    // Integers, as PIL computes luma.
    const int luma = static_cast<int>(std::lround(255 * c[0])) * 19595 +
                     static_cast<int>(std::lround(255 * c[1])) * 38470 +
                     static_cast<int>(std::lround(255 * c[2])) * 7471 + 0x8000;
    mask.data[i] = (luma >> 16) > 128;
    brightest = std::max(brightest, luma >> 16);
  }
  const float largest = *std::max_element(picture.data.begin(), picture.data.end());
  // The black of a JPEG may be 1.
  if (largest > 0 && brightest <= 1 && !is_jpeg_file(file))
    throw input_error(file.string(), "", "has values 0 and 1, which are both black", "save it as 0 and 255");
  return mask;
}

ImageU8 resized_nearest(const ImageU8& mask, int width, int height) {
  ImageU8 out(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      out(x, y) = mask(std::min(mask.width - 1, static_cast<int>((x + 0.5) * mask.width / width)),
                       std::min(mask.height - 1, static_cast<int>((y + 0.5) * mask.height / height)));
  return out;
}

MaskOverlap mask_overlap(const ImageU8& a, const ImageU8& b) {
  CHECK(a.width == b.width && a.height == b.height);
  MaskOverlap overlap;
  overlap.pixels = static_cast<double>(a.data.size());
  for (size_t i = 0; i < a.data.size(); ++i) {
    overlap.both += a.data[i] && b.data[i];
    overlap.either += a.data[i] || b.data[i];
    overlap.equal += (a.data[i] != 0) == (b.data[i] != 0);
  }
  return overlap;
}

MaskOverlap boundary_overlap(const ImageU8& a, const ImageU8& b, int band) {
  const auto inner_band = [band](const ImageU8& mask) {
    IdImage ids(mask.width, mask.height, 1);
    std::copy(mask.data.begin(), mask.data.end(), ids.data.begin());
    const std::vector<uint8_t> contour = contour_bands(ids, band);
    ImageU8 out = mask;
    for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = mask.data[i] && contour[i];
    return out;
  };
  return mask_overlap(inner_band(a), inner_band(b));
}

int boundary_band(int width, int height) {
  return std::max(1, static_cast<int>(std::lround(0.02 * std::hypot(width, height))));
}

}  // namespace pliant
