#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

struct SettleOptions {
  int neighbours = 12;
  double like = 0.6;     ///< nats that each neighbour in a part speaks for it
  double spread = 0.03;  ///< least standard deviation of logarithms of ratios of colours in a part
  double dark = 0.02;    ///< added to colours of 0..1, below which ratios say nothing
  int rounds = 100;      ///< at most; a round without a change is the last
};

/// Parts [N] whose borders follow the look: each point joins the part that its look, against the mean and covariance of
/// the part's, and its neighbours make likeliest (iterated conditional modes, Besag 1986).  Looks are ratios of
/// colours, which shading does not change, and what is thin [N].  position [N, 3], color [N, 3] in 0..1; numbers from 0
/// without gaps. What is `held` [N] or none keeps its part and has no say.
std::vector<uint32_t> settle_parts(const SettleOptions& options, std::vector<uint32_t> part,
                                   std::span<const Vec3f> position, std::span<const Vec3f> color,
                                   std::span<const uint8_t> thin, std::span<const uint8_t> held = {});

}  // namespace pliant
