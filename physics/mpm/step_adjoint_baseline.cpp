#define PLIANT_ISA baseline
#include "physics/mpm/step_adjoint_table.h"
