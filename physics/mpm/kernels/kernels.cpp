#include "physics/mpm/kernels/kernels.h"

namespace pliant {

template <class T>
const MpmKernels<T>& mpm_kernels(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::kAvx2) return avx2::mpm_kernels<T>();
#endif
  (void)set;
  return baseline::mpm_kernels<T>();
}

template const MpmKernels<float>& mpm_kernels<float>(InstructionSet);
template const MpmKernels<double>& mpm_kernels<double>(InstructionSet);

}  // namespace pliant
