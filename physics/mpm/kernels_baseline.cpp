#define PLIANT_ISA baseline
#include "physics/mpm/kernels_table.h"
