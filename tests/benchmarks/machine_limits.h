#pragma once

namespace pliant {

/// What this machine does at most, measured in the same run as a benchmark: a figure means little without it.
struct MachineLimits {
  double fma_gflops = 0;  ///< single precision, a fused operation counting as two, on `threads` threads
  double copy_gb_s = 0;   ///< bytes read plus bytes written, arrays far larger than the caches
};

/// Best of several short trials on `threads` threads.
MachineLimits measure_machine(int threads);

}  // namespace pliant
