#define PLIANT_ISA baseline
#include "physics/mpm/kernels/step_adjoint_table.h"
