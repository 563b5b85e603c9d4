#pragma once

#include "gaussians/io/optical_flow.h"
