// Speed of the rasteriser on clouds of a stated recipe.  Beside each time: blends per second (Gaussian and pixel), and
// the share of the limit that the machine's multiply-add peak, measured in the same run, sets for that work.
//
//   render_benchmark --benchmark_repetitions=5 --benchmark_report_aggregates_only=true

#include <benchmark/benchmark.h>
#include <omp.h>

#include <map>

#include "gaussians/base/memory.h"
#include "gaussians/render/blend_weights.h"
#include "gaussians/render/render.h"
#include "tests/benchmarks/machine_limits.h"
#include "tests/benchmarks/random_cloud.h"

namespace pliant {
namespace {

// 100k Gaussians with standard deviations of 0.004 to 0.020, or more of them of half the size; opacity 0.05 to 0.95;
// the camera 4 away from a cube of side 2.6, focal length 1.1 widths.
GaussianCloud cloud_of(int n) {
  RandomCloudOptions options;
  options.gaussians = n;
  if (n > 100'000) {
    options.smallest /= 2;
    options.largest /= 2;
  }
  return random_cloud(options);
}

struct Subject {
  GaussianCloud cloud;
  Camera camera = look_at({0, -4, 0}, {0, 0, 0}, {0, 0, 1}, 800, 800, 880);
  std::vector<float> features;
  double blends = 0;
};

const Subject& subject(int n) {
  static std::map<int, Subject> all;
  const auto [it, is_new] = all.try_emplace(n);
  Subject& s = it->second;
  if (is_new) {
    s.cloud = cloud_of(n);
    s.features.resize(static_cast<size_t>(n) * 16);
    for (size_t k = 0; k < s.features.size(); ++k) s.features[k] = static_cast<float>(Random(2, k).uniform(0, 1));
    s.blends = static_cast<double>(blend_weights(s.cloud, s.camera).weight.size());
  }
  return s;
}

const MachineLimits& limits(int threads) {
  static std::map<int, MachineLimits> all;
  const auto [it, is_new] = all.try_emplace(threads);
  if (is_new) it->second = measure_machine(threads);
  return it->second;
}

// Arguments: Gaussians, extra channels, threads.
void report(benchmark::State& state, double flops_per_blend) {
  const Subject& s = subject(static_cast<int>(state.range(0)));
  const MachineLimits& machine = limits(static_cast<int>(state.range(2)));
  // Additions, products and comparisons that are not fused count at half rate: about 0.6 of the peak is usable.
  const double limit = 0.6 * machine.fma_gflops * 1e9 / flops_per_blend;
  const double per_iteration = s.blends * state.iterations();
  state.counters["blends/s"] = benchmark::Counter(per_iteration, benchmark::Counter::kIsRate);
  state.counters["share"] = benchmark::Counter(per_iteration / limit, benchmark::Counter::kIsRate);
  state.counters["fma_GF"] = machine.fma_gflops;
  state.counters["copy_GB/s"] = machine.copy_gb_s;
}

void forward(benchmark::State& state) {
  const Subject& s = subject(static_cast<int>(state.range(0)));
  const int channels = static_cast<int>(state.range(1));
  omp_set_num_threads(static_cast<int>(state.range(2)));
  const std::span<const float> features(s.features.data(), s.cloud.size() * channels);
  for (auto _ : state) benchmark::DoNotOptimize(render(s.cloud, s.camera, {}, features, channels).color.data.data());
  report(state, 23 + 2 * (3 + channels));
}

void forward_backward(benchmark::State& state) {
  const Subject& s = subject(static_cast<int>(state.range(0)));
  const int channels = static_cast<int>(state.range(1));
  omp_set_num_threads(static_cast<int>(state.range(2)));
  const std::span<const float> features(s.features.data(), s.cloud.size() * channels);
  RenderResult adj;
  adj.color = ImageF(800, 800, 3, 0.1f);
  if (channels > 0) adj.features = ImageF(800, 800, channels, 0.1f);
  for (auto _ : state) {
    RenderTape<float> tape;
    const RenderResult picture = render(s.cloud, s.camera, {}, features, channels, &tape);
    benchmark::DoNotOptimize(
        render_adjoint(s.cloud, s.camera, {}, features, channels, picture, adj, &tape).cloud.position.data());
  }
  report(state, 23 + 2 * (3 + channels) + 43 + 4 * (3 + channels));
}

void sizes(benchmark::internal::Benchmark* b) {
  for (int n : {100'000, 500'000})
    for (int channels : {0, 16})
      for (int threads : {1, 2}) b->Args({n, channels, threads});
  b->ArgNames({"gaussians", "extra", "threads"})->Unit(benchmark::kMillisecond)->UseRealTime();
}
BENCHMARK(forward)->Apply(sizes);
BENCHMARK(forward_backward)->Apply(sizes);

}  // namespace
}  // namespace pliant

int main(int argc, char** argv) {
  pliant::keep_freed_memory();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
