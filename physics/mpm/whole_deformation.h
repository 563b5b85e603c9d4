#pragma once

#include <vector>

#include "physics/mpm/particles.h"

namespace pliant {

/// [N, 3, 3] deformation gradients with the permanent part: what is drawn.
template <class T>
std::vector<Mat3<T>> whole_deformation(const BasicSimulationState<T>& state) {
  if (state.memory.empty()) return state.F;
  std::vector<Mat3<T>> F;
  for (const LawMemory<T>& memory : state.memory) F.push_back(memory.F_total);
  return F;
}

}  // namespace pliant
