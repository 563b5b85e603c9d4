#define PLIANT_ISA baseline
#include "gaussians/render/blend_table.h"
