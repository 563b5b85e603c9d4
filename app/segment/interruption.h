#pragma once

#include <string>

#include "app/run/progress.h"
#include "gaussians/base/error.h"

namespace pliant {

/// Throws Error{kInterrupted} of `stage` where the program was asked to stop.
inline void stop_if_interrupted(const Context& context, const std::string& stage) {
  if (context.interrupted()) throw Error(Failure::kInterrupted, stage, "", "interrupted", "run the same command again");
}

}  // namespace pliant
