#pragma once

// Defines the kernels' table of one instruction set.

#include "physics/mpm/step_adjoint_kernels.h"

namespace pliant::PLIANT_ISA {

extern const AdjointKernels<float> kAdjointFloat = {reverse_gather<float>, reverse_scatter<float>};
extern const AdjointKernels<double> kAdjointDouble = {reverse_gather<double>, reverse_scatter<double>};

}  // namespace pliant::PLIANT_ISA
