#pragma once

#include <atomic>
#include <cstdint>

namespace pliant {

/// Meeting point of a fixed number of threads.  Waiting threads spin briefly and then sleep, so that a machine with
/// other work on it loses little; the barriers of OpenMP spin for about a millisecond.
class Barrier {
 public:
  explicit Barrier(int threads) : threads_(threads) {}

  void wait() {
    if (threads_ == 1) return;
    const uint32_t generation = generation_.load(std::memory_order_acquire);
    if (arrived_.fetch_add(1, std::memory_order_acq_rel) + 1 == threads_) {
      arrived_.store(0, std::memory_order_relaxed);
      generation_.fetch_add(1, std::memory_order_release);
      generation_.notify_all();
      return;
    }
    constexpr int kSpins = 4000;
    for (int spin = 0; spin < kSpins; ++spin)
      if (generation_.load(std::memory_order_acquire) != generation) return;
    generation_.wait(generation, std::memory_order_acquire);
  }

 private:
  const int threads_;
  std::atomic<int> arrived_{0};
  std::atomic<uint32_t> generation_{0};
};

/// Hands out 0, 1, 2, ... to the threads of a team.
class Queue {
 public:
  void reset() { next_.store(0, std::memory_order_relaxed); }
  int take() { return next_.fetch_add(1, std::memory_order_relaxed); }

 private:
  alignas(64) std::atomic<int> next_{0};
};

}  // namespace pliant
