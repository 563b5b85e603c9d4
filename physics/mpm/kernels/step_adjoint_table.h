#pragma once

#include "physics/mpm/kernels/gather_adjoint_kernels.h"
#include "physics/mpm/kernels/lagrangian_adjoint_kernels.h"
#include "physics/mpm/kernels/scatter_adjoint_kernels.h"

namespace pliant::PLIANT_ISA {

template <class T>
void reverse_gather(const AdjointRun<T>& run, const T* velocity, T* patch, const T* old_velocity, T* old_patch) {
  if (run.rest_place)
    reverse_gather_lagrangian<T>(run, patch);
  else if (run.flip > T(0))
    reverse_gather_run<T, true>(run, velocity, patch, old_velocity, old_patch);
  else
    reverse_gather_run<T, false>(run, velocity, patch, nullptr, nullptr);
}

template <class T, Mixture kMixture>
INLINE void reverse_scatter(const AdjointRun<T>& run, StressKind kind, const T* nodes, const T* old_nodes) {
  if (run.rest_place)
    reverse_scatter_lagrangian<T, kMixture>(run, kind, nodes);
  else
    reverse_scatter_run<T, kMixture>(run, kind, nodes, old_nodes);
}
template <class T>
void reverse_scatter_fixed_corotated(const AdjointRun<T>& run, const T* nodes, const T* old_nodes) {
  reverse_scatter<T, Mixture::kUniform>(run, StressKind::kFixedCorotated, nodes, old_nodes);
}
template <class T>
void reverse_scatter_neo_hookean(const AdjointRun<T>& run, const T* nodes, const T* old_nodes) {
  reverse_scatter<T, Mixture::kUniform>(run, StressKind::kNeoHookean, nodes, old_nodes);
}
template <class T>
void reverse_scatter_any(const AdjointRun<T>& run, const T* nodes, const T* old_nodes) {
  reverse_scatter<T, Mixture::kAny>(run, StressKind::kGiven, nodes, old_nodes);
}

template <class T>
const AdjointKernels<T>& adjoint_kernels() {
  static constexpr AdjointKernels<T> kKernels = {
      reverse_gather<T>, {reverse_scatter_fixed_corotated<T>, reverse_scatter_neo_hookean<T>, reverse_scatter_any<T>}};
  return kKernels;
}

template const AdjointKernels<float>& adjoint_kernels<float>();
template const AdjointKernels<double>& adjoint_kernels<double>();

}  // namespace pliant::PLIANT_ISA
