#pragma once

#include <algorithm>
#include <cmath>

#include "gaussians/base/image.h"
#include "gaussians/base/random.h"
#include "gaussians/base/types.h"

namespace pliant {

/// A disc of a made picture [px].
struct MadeDisc {
  float x = 0, y = 0, radius = 0;
  Vec3f colour = Vec3f(0.8f, 0.15f, 0.1f);

  bool contains(int i, int j) const { return std::hypot(i + 0.5f - x, j + 0.5f - y) <= radius; }
};

/// Discs with a little noise on a ground of dark stripes and coarse blotches that move by `shift` px.
inline ImageF made_picture(int width, int height, const std::vector<MadeDisc>& discs, float shift = 0) {
  ImageF picture(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      Random random(3, static_cast<uint64_t>(y) * width + x);
      const float u = x - shift,
                  blotch = 0.12f * std::sin(0.31f * u) * std::cos(0.23f * y) + 0.06f * std::sin(0.9f * u + 0.7f * y);
      Vec3f colour = std::fmod(u + 1000, 12.0f) < 4 ? Vec3f(0.1f, 0.2f, 0.1f) : Vec3f(0.35f, 0.5f, 0.3f);
      colour += Vec3f::Constant(blotch);
      for (const MadeDisc& disc : discs)
        if (disc.contains(x, y))
          colour = disc.colour + Vec3f::Constant(0.08f * std::sin(0.8f * (x - disc.x)) * std::cos(0.7f * (y - disc.y)));
      for (int c = 0; c < 3; ++c)
        picture(x, y, c) = std::clamp(colour[c] + 0.03f * static_cast<float>(random.normal()), 0.0f, 1.0f);
    }
  return picture;
}

/// 1 in the disc, -1 elsewhere.
inline ImageF disc_mask(int width, int height, const MadeDisc& disc) {
  ImageF mask(width, height, 1, -1.0f);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (disc.contains(x, y)) mask(x, y) = 1;
  return mask;
}

}  // namespace pliant
