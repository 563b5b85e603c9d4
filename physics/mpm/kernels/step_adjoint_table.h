#pragma once

#include "physics/mpm/kernels/gather_adjoint_kernels.h"
#include "physics/mpm/kernels/scatter_adjoint_kernels.h"

namespace pliant::PLIANT_ISA {

template <class T>
const AdjointKernels<T>& adjoint_kernels() {
  static constexpr AdjointKernels<T> kKernels = {
      reverse_gather<T>, {reverse_scatter_fixed_corotated<T>, reverse_scatter_neo_hookean<T>, reverse_scatter_any<T>}};
  return kKernels;
}

template const AdjointKernels<float>& adjoint_kernels<float>();
template const AdjointKernels<double>& adjoint_kernels<double>();

}  // namespace pliant::PLIANT_ISA
