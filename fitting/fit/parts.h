#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

struct PartsOptions {
  int count = 6;
  double color_weight = 0.7;  ///< of a difference of 1 in a colour channel, against the extent of what is not held
  int iterations = 30;
  double thin_weight = 0.3;  ///< of being thin or not, against a difference of 1 in a colour channel
  double alike = 0.1;        ///< difference of mean looks, in colour, below which parts count as one material
};

/// Parts of a body that are near together and alike in colour, by k-means (Lloyd 1982) from farthest points: [N]
/// numbers from 0 without gaps; fewer parts when there are fewer different points.  position [N, 3], color [N, 3] in
/// 0..1.  What is `held` [N] or none, not 0, never bends: it takes no parts of its own, but joins the one that it is
/// most like.
std::vector<uint32_t> find_parts(const PartsOptions& options, std::span<const Vec3f> position,
                                 std::span<const Vec3f> color, std::span<const uint8_t> held = {});

/// The same parts with numbers from 0 without gaps, in the order in which they are met.
std::vector<uint32_t> numbered(std::vector<uint32_t> part);

/// Parts [N] joined where they look as if they were of one material: the two whose mean colours, and shares of what is
/// thin, differ least, again and again while they differ by less than `alike`; none when nothing but one would remain.
/// color [N, 3]; thin [N], not 0 in sheets and rods; what is held has no say.
std::optional<std::vector<uint32_t>> join_alike(const PartsOptions& options, std::span<const uint32_t> part,
                                                std::span<const Vec3f> color, std::span<const uint8_t> thin,
                                                std::span<const uint8_t> held = {});

}  // namespace pliant
