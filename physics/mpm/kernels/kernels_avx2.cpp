// Compiled with -mavx2 -mfma where the compiler targets x86-64.
#if defined(__AVX2__)
#define PLIANT_ISA avx2
#include "physics/mpm/kernels/kernels_table.h"
#endif
