// Time of one training iteration: render, loss, reverse, Adam on all parameters with three degrees of spherical
// harmonics, on the clouds and the picture of render_benchmark, so that it compares with published trainers.
//
//   train_benchmark --benchmark_repetitions=5 --benchmark_report_aggregates_only=true

#include <benchmark/benchmark.h>
#include <omp.h>

#include "gaussians/base/memory.h"
#include "gaussians/reconstruct/trainer.h"
#include "tests/benchmarks/random_cloud.h"

namespace pliant {
namespace {

// Gaussians, degree of the spherical harmonics, threads.
void iteration(benchmark::State& state) {
  RandomCloudOptions recipe;
  recipe.gaussians = static_cast<int>(state.range(0));
  if (recipe.gaussians > 100'000) {
    recipe.smallest /= 2;
    recipe.largest /= 2;
  }
  omp_set_num_threads(static_cast<int>(state.range(2)));

  TrainingPhotos photos;
  photos.photos.resize(1);
  TrainingPhoto& photo = photos.photos[0];
  photo.camera = look_at({0, -4, 0}, {0, 0, 0}, {0, 0, 1}, 800, 800, 880);
  photo.pixels = ImageU8(800, 800, 3, 128);
  TrainOptions options;
  options.densification = state.range(3) ? Densification::kMcmc : Densification::kNone;
  options.refine_from = 2;  // only the noise of MCMC
  options.coarse_to_fine = false;
  options.iterations = 1'000'000'000;
  options.position_rate = options.final_position_rate = 1e-12f;  // the cloud stays what it is
  options.opacity_rate = options.scale_rate = options.rotation_rate = options.color_rate = 1e-9f;
  Trainer trainer(options, photos, with_sh_degree(random_cloud(recipe), static_cast<int>(state.range(1))));
  for (auto _ : state) benchmark::DoNotOptimize(trainer.step().loss);
  state.counters["iterations/s"] = benchmark::Counter(state.iterations(), benchmark::Counter::kIsRate);
}

void sizes(benchmark::internal::Benchmark* b) {
  for (int n : {100'000, 500'000})
    for (int degree : {0, 3})
      for (int threads : {1, 2}) b->Args({n, degree, threads, 0});
  b->Args({100'000, 3, 2, 1});
  b->ArgNames({"gaussians", "sh", "threads", "mcmc"})->Unit(benchmark::kMillisecond)->UseRealTime();
}
BENCHMARK(iteration)->Apply(sizes);

}  // namespace
}  // namespace pliant

int main(int argc, char** argv) {
  pliant::keep_freed_memory();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
