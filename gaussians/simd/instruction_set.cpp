#include "gaussians/simd/instruction_set.h"

#include <cstdlib>
#include <string_view>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

InstructionSet of_processor() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return InstructionSet::kAvx2;
#endif
  return InstructionSet::kBaseline;
}

}  // namespace

InstructionSet best_instruction_set() {
  const InstructionSet widest = of_processor();
  const char* wish = std::getenv("PLIANT_INSTRUCTION_SET");
  if (!wish || !*wish || std::string_view(wish) == name_of(widest)) return widest;
  if (std::string_view(wish) == name_of(InstructionSet::kBaseline)) return InstructionSet::kBaseline;
  throw usage_error("PLIANT_INSTRUCTION_SET", "", std::string("'") + wish + "' is not available on this processor",
                    std::string("use baseline") + (widest == InstructionSet::kAvx2 ? " or avx2" : ""));
}

const char* name_of(InstructionSet set) { return set == InstructionSet::kAvx2 ? "avx2" : "baseline"; }

}  // namespace pliant
