#pragma once

#include <functional>

#include "gaussians/base/error.h"

namespace pliant {

/// Asked between the steps of a long piece of work, on any thread: whether to stop.  Empty = never.
using Interrupted = std::function<bool()>;

inline bool is_interrupted(const Interrupted& interrupted) { return interrupted && interrupted(); }

/// Throws Error{kInterrupted} where the demo was asked to stop.
inline void stop_demo_if(bool interrupted) {
  if (interrupted) throw Error(Failure::kInterrupted, "demo", "", "interrupted", "run the same command again");
}

}  // namespace pliant
