#pragma once

#include <string>

namespace pliant {

/// What helps when a module that links libtorch cannot be loaded; what else to do follows.
inline const std::string kTorchAdvice = "install libtorch-dev and libopenblas0-openmp and build again, or ";

}  // namespace pliant
