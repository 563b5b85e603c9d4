#define PLIANT_ISA adjoint_baseline
#include "physics/mpm/step_adjoint_table.h"
