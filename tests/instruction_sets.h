#pragma once

#include <vector>

#include "gaussians/simd/instruction_set.h"

namespace pliant::fixture {

/// The baseline and, where this processor has a wider one, the widest.
inline std::vector<InstructionSet> instruction_sets() {
  std::vector<InstructionSet> sets = {InstructionSet::kBaseline};
  if (best_instruction_set() != sets[0]) sets.push_back(best_instruction_set());
  return sets;
}

}  // namespace pliant::fixture
