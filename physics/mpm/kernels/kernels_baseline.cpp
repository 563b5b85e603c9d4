#define PLIANT_ISA baseline
#include "physics/mpm/kernels/kernels_table.h"
