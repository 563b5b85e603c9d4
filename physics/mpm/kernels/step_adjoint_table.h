#pragma once

#include "physics/mpm/kernels/elastic_adjoint_kernels.h"
#include "physics/mpm/kernels/gather_adjoint_kernels.h"
#include "physics/mpm/kernels/scatter_adjoint_kernels.h"

namespace pliant::PLIANT_ISA {

template <class T>
void reverse_gather(const AdjointRun<T>& run, const T* velocity, T* patch, const T* old_velocity, T* old_patch) {
  if (run.flip > T(0))
    reverse_gather_run<T, true>(run, velocity, patch, old_velocity, old_patch);
  else
    reverse_gather_run<T, false>(run, velocity, patch, nullptr, nullptr);
}

template <class T>
void reverse_scatter_fixed_corotated(const AdjointRun<T>& run, const T* nodes, const T* old_nodes) {
  reverse_scatter_run<T, Mixture::kUniform>(run, StressKind::kFixedCorotated, nodes, old_nodes);
}
template <class T>
void reverse_scatter_neo_hookean(const AdjointRun<T>& run, const T* nodes, const T* old_nodes) {
  reverse_scatter_run<T, Mixture::kUniform>(run, StressKind::kNeoHookean, nodes, old_nodes);
}
template <class T>
void reverse_scatter_any(const AdjointRun<T>& run, const T* nodes, const T* old_nodes) {
  reverse_scatter_run<T, Mixture::kAny>(run, StressKind::kGiven, nodes, old_nodes);
}

template <class T>
const AdjointKernels<T>& adjoint_kernels() {
  static constexpr AdjointKernels<T> kKernels = {
      reverse_gather<T>,
      {reverse_scatter_fixed_corotated<T>, reverse_scatter_neo_hookean<T>, reverse_scatter_any<T>},
      {elastic_impulses_adjoint_fixed_corotated<T>, elastic_impulses_adjoint_neo_hookean<T>,
       elastic_impulses_adjoint_any<T>},
      follow_nodes_adjoint<T>};
  return kKernels;
}

template const AdjointKernels<float>& adjoint_kernels<float>();
template const AdjointKernels<double>& adjoint_kernels<double>();

}  // namespace pliant::PLIANT_ISA
