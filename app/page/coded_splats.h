#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/page/clip_file.h"
#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

/// How splats are rounded.
struct SplatCoding {
  int sh_degree = 3;  ///< at most that of the cloud
  bool fine = true;   ///< scales, colours and opacities with 16 bits instead of 8

  bool operator==(const SplatCoding&) const = default;
};

constexpr size_t kSplatChunk = 256;  ///< splats whose positions are rounded within one box

/// A cloud in small integers.  Its Gaussians should lie along a curve, so that the boxes of chunks are small.  Ranges
/// are those of what is drawn, colours without the rarest; what lies outside is moved to their ends.
struct CodedSplats {
  struct Range {
    double low = 0, high = 1;
  };
  SplatCoding coding;
  std::vector<float> chunk_low, chunk_size;          ///< [chunks, 3] scene units
  std::vector<uint16_t> position;                    ///< [N, 3] within the chunk
  std::vector<uint16_t> log_scale, colour, opacity;  ///< [N, 3], [N, 3], [N]
  std::vector<uint32_t> rotation;                    ///< [N] number of the largest of w, x, y, z, and the others
  std::vector<uint8_t> sh;                           ///< [N, K - 1, 3]
  Range log_scale_range, colour_range, opacity_range, sh_range;

  size_t size() const { return rotation.size(); }
};

CodedSplats code_splats(const SplatCoding& coding, const GaussianCloud& cloud);
/// What is left of a cloud after that.
GaussianCloud decoded(const CodedSplats& splats);
/// Appends the arrays PREFIX.position and so on to the section of that name.
void add_splats(ClipFile& clip, const std::string& prefix, const CodedSplats& splats);

}  // namespace pliant
