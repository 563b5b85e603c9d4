#pragma once

#include <omp.h>

#include <cstddef>
#include <cstdint>
#include <exception>

/// Marks functions that also compile for a device.
#if defined(__CUDACC__)
#define HOST_DEVICE __host__ __device__
#else
#define HOST_DEVICE
#endif

namespace pliant {

/// Calls body(i) for i in [0, n) on all threads in chunks handed out dynamically.  The result may not depend on the
/// order of calls.  The first exception thrown by a body is rethrown here.
template <class Body>
void parallel_for(std::ptrdiff_t n, Body&& body, int chunk = 1) {
  std::exception_ptr error;
#pragma omp parallel for schedule(dynamic, chunk) if (n > chunk)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    try {
      body(i);
    } catch (...) {
#pragma omp critical(pliant_parallel_for)
      if (!error) error = std::current_exception();
    }
  }
  if (error) std::rethrow_exception(error);
}

/// Sum of value(i) over [0, n), equal bit for bit for any number of threads: fixed blocks, summed in order.
template <class T, class Value>
T ordered_sum(std::ptrdiff_t n, T zero, Value&& value) {
  constexpr std::ptrdiff_t kBlock = 4096, kGroup = 256;
  T total = zero;
  for (std::ptrdiff_t group = 0; group < n; group += kBlock * kGroup) {
    T partial[kGroup];
    const std::ptrdiff_t left = n - group;
    const std::ptrdiff_t blocks = left < kBlock * kGroup ? (left + kBlock - 1) / kBlock : kGroup;
    parallel_for(blocks, [&](std::ptrdiff_t b) {
      T sum = zero;
      const std::ptrdiff_t begin = group + b * kBlock;
      const std::ptrdiff_t end = begin + kBlock < n ? begin + kBlock : n;
      for (std::ptrdiff_t i = begin; i < end; ++i) sum += value(i);
      partial[b] = sum;
    });
    for (std::ptrdiff_t b = 0; b < blocks; ++b) total += partial[b];
  }
  return total;
}

}  // namespace pliant
