#include "gaussians/render/blend.h"

namespace pliant {

template <class T, bool kCutOffs>
const BlendKernels<T>& blend_kernels(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::kAvx2) return avx2::blend_kernels<T, kCutOffs>();
#endif
  (void)set;
  return baseline::blend_kernels<T, kCutOffs>();
}

template const BlendKernels<float>& blend_kernels<float, true>(InstructionSet);
template const BlendKernels<double>& blend_kernels<double, true>(InstructionSet);
template const BlendKernels<double>& blend_kernels<double, false>(InstructionSet);

}  // namespace pliant
