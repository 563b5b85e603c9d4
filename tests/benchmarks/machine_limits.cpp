#include "tests/benchmarks/machine_limits.h"

#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <memory>

#include "gaussians/simd/instruction_set.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace pliant {
namespace {

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

constexpr long kRounds = 4'000'000;

#if defined(__x86_64__)
// Ten independent chains hide the latency of four or five cycles on two units.
__attribute__((target("avx2,fma"))) float fma_chains_avx2() {
  __m256 x[10];
  for (int k = 0; k < 10; ++k) x[k] = _mm256_set1_ps(static_cast<float>(k));
  const __m256 a = _mm256_set1_ps(0.9999f), b = _mm256_set1_ps(1e-4f);
  for (long i = 0; i < kRounds; ++i)
    for (int k = 0; k < 10; ++k) x[k] = _mm256_fmadd_ps(x[k], a, b);
  float sum = 0;
  for (int k = 0; k < 10; ++k) sum += _mm256_cvtss_f32(x[k]);
  return sum;
}
#endif

float multiply_add_chains() {
  typedef float Four __attribute__((vector_size(16)));
  Four x[10];
  for (int k = 0; k < 10; ++k) x[k] = Four{} + static_cast<float>(k);
  for (long i = 0; i < kRounds; ++i)
    for (int k = 0; k < 10; ++k) x[k] = x[k] * 0.9999f + 1e-4f;
  float sum = 0;
  for (int k = 0; k < 10; ++k) sum += x[k][0];
  return sum;
}

double fma_rate(int threads) {
  int lanes = 4;
  float (*chains)() = multiply_add_chains;
#if defined(__x86_64__)
  if (best_instruction_set() == InstructionSet::kAvx2) {
    chains = fma_chains_avx2;
    lanes = 8;
  }
#endif
  double best = 0;
  for (int trial = 0; trial < 5; ++trial) {
    const double start = seconds();
    float sink = 0;
#pragma omp parallel num_threads(threads)
    {
      const float mine = chains();
#pragma omp critical
      sink += mine;
    }
    const double flops = 2.0 * 10 * lanes * kRounds * threads + (sink == 12345.0f);
    best = std::max(best, flops / (seconds() - start));
  }
  return best * 1e-9;
}

double copy_rate(int threads) {
  constexpr size_t kBytes = size_t{128} << 20;
  const std::unique_ptr<char[]> from(new char[kBytes]), to(new char[kBytes]);
  std::memset(from.get(), 1, kBytes);
  std::memset(to.get(), 2, kBytes);
  double best = 0;
  for (int trial = 0; trial < 5; ++trial) {
    const double start = seconds();
#pragma omp parallel num_threads(threads)
    {
      const size_t share = kBytes / omp_get_num_threads(), begin = share * omp_get_thread_num();
      std::memcpy(to.get() + begin, from.get() + begin, share);
    }
    best = std::max(best, 2.0 * kBytes / (seconds() - start));
  }
  return best * 1e-9;
}

}  // namespace

MachineLimits measure_machine(int threads) { return {fma_rate(threads), copy_rate(threads)}; }

}  // namespace pliant
