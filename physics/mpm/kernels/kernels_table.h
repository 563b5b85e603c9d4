#pragma once

#include "physics/mpm/kernels/elastic_kernels.h"

namespace pliant::PLIANT_ISA {

template <class T>
const MpmKernels<T>& mpm_kernels() {
  static constexpr MpmKernels<T> kKernels = {
      {scatter_fixed_corotated<T>, scatter_neo_hookean<T>, scatter_any<T>},
      add_nodes<T>,
      update_nodes<T>,
      gather<T>,
      stress_of<T>,
      {elastic_impulses_fixed_corotated<T>, elastic_impulses_neo_hookean<T>, elastic_impulses_any<T>},
      follow_nodes<T>,
      add_pairs<T>,
      push_nodes<T>,
      displace_nodes<T>};
  return kKernels;
}

template const MpmKernels<float>& mpm_kernels<float>();
template const MpmKernels<double>& mpm_kernels<double>();

}  // namespace pliant::PLIANT_ISA
