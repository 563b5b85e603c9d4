#include "physics/mpm/kernels/step_adjoint_view.h"

namespace pliant {

template <class T>
const AdjointKernels<T>& adjoint_kernels(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::kAvx2) return avx2::adjoint_kernels<T>();
#endif
  (void)set;
  return baseline::adjoint_kernels<T>();
}

template const AdjointKernels<float>& adjoint_kernels<float>(InstructionSet);
template const AdjointKernels<double>& adjoint_kernels<double>(InstructionSet);

}  // namespace pliant
