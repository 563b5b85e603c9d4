#pragma once

#include "gaussians/render/bin_kernels.h"
#include "gaussians/render/blend_kernels.h"
#include "gaussians/render/project_adjoint_kernels.h"

namespace pliant::PLIANT_ISA {

template <class T, bool kCutOffs>
const BlendKernels<T>& blend_kernels() {
  static constexpr BlendKernels<T> kKernels = {
      project<T, kCutOffs>,       project_adjoint<T>,         bin<T, kCutOffs>,          blend<T, kCutOffs>,
      blend_adjoint<T, kCutOffs>, count_weights<T, kCutOffs>, write_weights<T, kCutOffs>};
  return kKernels;
}

template const BlendKernels<float>& blend_kernels<float, true>();
template const BlendKernels<double>& blend_kernels<double, true>();
template const BlendKernels<double>& blend_kernels<double, false>();

}  // namespace pliant::PLIANT_ISA
