#include "physics/body/samples.h"

#include "gaussians/base/error.h"

namespace pliant {

double SolidSamples::total_volume() const {
  double sum = 0;
  for (const float v : volume) sum += v;
  return sum;
}

SolidSamples SolidSamples::select(std::span<const int> indices) const {
  SolidSamples out;
  out.spacing = spacing;
  for (const int i : indices) {
    CHECK(i >= 0 && static_cast<size_t>(i) < size());
    out.position.push_back(position[i]);
    out.volume.push_back(volume[i]);
    if (!thickness.empty()) out.thickness.push_back(thickness[i]);
    if (!rod.empty()) out.rod.push_back(rod[i]);
  }
  return out;
}

}  // namespace pliant
