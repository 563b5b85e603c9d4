#pragma once

#include <vector>

#include "app/store/particles.h"

namespace pliant {

inline constexpr float kSheetStep = 0.02f;  // between samples, and between the sheets

/// Two sheets of one layer of samples [1.2 x .06], each with a driver, one above the other; links within each alone.
inline ParticleFile two_sheets() {
  ParticleFile out;
  for (int sheet = 0; sheet < 2; ++sheet)
    for (int i = 0; i < 60; ++i)
      for (int j = 0; j < 3; ++j) {
        out.solid_driver.push_back(static_cast<int>(out.solid_position.size()));
        out.solid_position.push_back(kSheetStep *
                                     Vec3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(sheet)));
        out.solid_volume.push_back(kSheetStep * kSheetStep * kSheetStep);
      }
  out.driving_position = out.solid_position;
  out.driving_volume = out.solid_volume;
  out.cell_size = 2 * kSheetStep;
  const std::vector<Vec3f>& x = out.driving_position;
  const int n = static_cast<int>(x.size());
  for (int i = 0; i < n; ++i)
    for (int k = i + 1; k < n; ++k)
      if (x[i].z() == x[k].z() && (x[i] - x[k]).norm() < 1.5f * kSheetStep) out.driving_links.push_back({i, k});
  return out;
}

/// Of each driver [M] the sheets in which its samples lie: bit 0 the lower one, bit 1 the upper one.
inline std::vector<int> sheets_of_drivers(const ParticleFile& sheets) {
  std::vector<int> out(sheets.driving_position.size(), 0);
  for (size_t s = 0; s < sheets.solid_position.size(); ++s)
    out[sheets.solid_driver[s]] |= sheets.solid_position[s].z() > 0.5f * kSheetStep ? 2 : 1;
  return out;
}

}  // namespace pliant
