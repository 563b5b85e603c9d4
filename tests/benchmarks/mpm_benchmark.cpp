// Speed of the material point method on cubes of a stated recipe: particles at random places, 8 to a cell on average,
// E = 1e5 Pa, nu = 0.3, rho = 1000 kg/m^3, falling freely; 10k in 32^3, 100k in 64^3, 1M in 128^3 cells.  Beside each
// rate: nanoseconds per particle of the parts of a step on one thread, and forward and back, and the shares of the
// limits that the machine's multiply-add peak and memory bandwidth, measured in the same run, set for that work.
//
//   mpm_benchmark --benchmark_repetitions=5 --benchmark_report_aggregates_only=true

#include <benchmark/benchmark.h>
#include <omp.h>

#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <tuple>

#include "gaussians/base/memory.h"
#include "gaussians/base/random.h"
#include "physics/mpm/adjoint/step_adjoint.h"
#include "physics/mpm/mpm.h"
#include "tests/benchmarks/machine_limits.h"

namespace pliant {
namespace {

// Least work of one particle in one step: operations with a fused one counting as two (weights twice 60, stress and
// affine terms 110, scatter 351, gather 360, update 70), and bytes of its record read twice and written once.
// On a Lagrangian grid nothing of a particle is written and the update falls away.
constexpr double kFlops = 950, kUpdateFlops = 70, kCorotatedFlops = 400, kBytes = 128 + 2 * 192, kRestBytes = 48;

struct Subject {
  BasicParticles<float> particles;
  BasicSimulationState<float> state;
  std::unique_ptr<Mpm<float>> solver;
  StepLoads<float> loads;
  float dt = 0;
};

Subject make_subject(int n, Law law, bool lagrangian) {
  Subject s;
  const int grid = n > 500'000 ? 128 : n > 50'000 ? 64 : 32;
  const double dx = 1.0 / grid, side = dx * std::cbrt(n / 8.0);
  BasicParticles<float>& p = s.particles;
  p.materials[0].law = law;
  for (int i = 0; i < n; ++i) {
    Random random(1, i);
    p.position.emplace_back(0.5 + side * random.uniform(-0.5, 0.5), 0.5 + side * random.uniform(-0.5, 0.5),
                            0.5 + side * random.uniform(-0.5, 0.5));
  }
  const float volume = static_cast<float>(side * side * side / n);
  p.volume.assign(n, volume);
  p.mass.assign(n, 1000 * volume);
  p.young.assign(n, 1e5f);
  p.poisson.assign(n, 0.3f);
  p.cell_size = static_cast<float>(dx);
  s.state = initial_state(p);
  s.loads.gravity = Vec3<float>(0, 0, -9.81f);
  s.dt = 1e-4f * 64 / static_cast<float>(grid);
  s.solver = std::make_unique<Mpm<float>>(p, dx, Vec3d::Zero(), MpmOptions{.lagrangian = lagrangian});
  s.solver->load(s.state, Vec3d::Constant(-10), Vec3d::Constant(10));
  return s;
}

Subject& subject(int n, Law law, bool lagrangian) {
  static std::map<std::tuple<int, Law, bool>, Subject> all;
  const auto [it, is_new] = all.try_emplace({n, law, lagrangian});
  if (is_new) it->second = make_subject(n, law, lagrangian);
  return it->second;
}

const MachineLimits& limits(int threads) {
  static std::map<int, MachineLimits> all;
  const auto [it, is_new] = all.try_emplace(threads);
  if (is_new) it->second = measure_machine(threads);
  return it->second;
}

void advance(Subject& s, int steps) {
  s.solver->advance(
      steps, s.dt, s.loads, [](int) {}, [] { return true; });
}

// Arguments: particles, law, grid (1 = Lagrangian), threads.
void step(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0)), threads = static_cast<int>(state.range(3));
  const Law law = static_cast<Law>(state.range(1));
  const bool lagrangian = state.range(2) != 0;
  Subject& s = subject(n, law, lagrangian);
  omp_set_num_threads(threads);
  const int steps = std::max(2, 2'000'000 / n);
  advance(s, steps);
  for (auto _ : state) advance(s, steps);
  const MachineLimits& machine = limits(threads);
  const double done = static_cast<double>(n) * steps * static_cast<double>(state.iterations());
  const double bytes = lagrangian ? kRestBytes : kBytes;
  const double flops =
      (lagrangian ? kFlops - kUpdateFlops : kFlops) + (law == Law::kFixedCorotated ? kCorotatedFlops : 0);
  const auto rate = [&](double x) { return benchmark::Counter(x, benchmark::Counter::kIsRate); };
  state.counters["Mp/s"] = rate(done * 1e-6);
  state.counters["fma_share"] = rate(done * flops / (machine.fma_gflops * 1e9));
  state.counters["byte_share"] = rate(done * bytes / (machine.copy_gb_s * 1e9));
  state.counters["fma_GF"] = machine.fma_gflops;
  state.counters["copy_GB/s"] = machine.copy_gb_s;
}

void phases(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  Subject& s = subject(n, static_cast<Law>(state.range(1)), state.range(2) != 0);
  omp_set_num_threads(1);
  double seconds[3] = {};
  const auto now = [] { return std::chrono::steady_clock::now(); };
  const auto timed = [&](double& sum, auto&& part) {
    const auto begin = now();
    part();
    sum += std::chrono::duration<double>(now() - begin).count();
  };
  for (auto _ : state) {
    timed(seconds[0], [&] { s.solver->particles_to_grid(s.dt, s.loads); });
    timed(seconds[1], [&] { s.solver->update_grid(s.dt, s.loads); });
    timed(seconds[2], [&] { s.solver->grid_to_particles(s.dt); });
  }
  const double done = static_cast<double>(n) * static_cast<double>(state.iterations()) * 1e-9;
  state.counters["scatter_ns"] = seconds[0] / done;
  state.counters["nodes_ns"] = seconds[1] / done;
  state.counters["gather_ns"] = seconds[2] / done;
}

// Steps forward, the same steps forward with a tape, and back along it; the rate is that of the last two together.
void forward_and_reverse(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0)), threads = static_cast<int>(state.range(3));
  Subject& s = subject(n, static_cast<Law>(state.range(1)), state.range(2) != 0);
  omp_set_num_threads(threads);
  const int steps = std::max(2, 400'000 / n);
  StepAdjoint<float> adjoint(s.particles, s.solver->data());
  StateGradient<float> gradient = StateGradient<float>::zero(n);
  for (int i = 0; i < n; ++i)
    for (int a = 0; a < 3; ++a) gradient.x[i][a] = static_cast<float>(Random(2, i, a).normal());
  static StepTape<float> tape;
  double seconds[3] = {};
  const auto timed = [&](double& sum, auto&& part) {
    const auto begin = std::chrono::steady_clock::now();
    part();
    sum += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  const auto record = [&] {
    tape.clear();
    s.solver->advance(
        steps, s.dt, s.loads, [](int) {}, [] { return true; }, &tape);
  };
  record();
  for (auto _ : state) {
    timed(seconds[0], [&] { advance(s, steps); });
    timed(seconds[1], record);
    s.solver->store(s.state);
    adjoint.load(gradient, s.state, tape);
    timed(seconds[2], [&] { adjoint.reverse(tape, [](int, const StepLoadsGradient&) {}); });
  }
  const double done = static_cast<double>(n) * steps * static_cast<double>(state.iterations());
  state.counters["Mp/s"] = done * 1e-6 / (seconds[1] + seconds[2]);
  state.counters["forward_ns"] = seconds[0] / done * 1e9;
  state.counters["with_tape_ns"] = seconds[1] / done * 1e9;
  state.counters["reverse_ns"] = seconds[2] / done * 1e9;
  state.counters["reverse/forward"] = seconds[2] / seconds[0];
}

void sizes(benchmark::internal::Benchmark* b, bool threads_too) {
  for (int n : {10'000, 100'000, 1'000'000})
    for (Law law : {Law::kNeoHookean, Law::kFixedCorotated})
      for (int lagrangian : {0, 1})
        for (int threads = 1; threads <= (threads_too ? 2 : 1); ++threads)
          b->Args({n, static_cast<int>(law), lagrangian, threads});
  b->ArgNames({"particles", "law", "lagrangian", "threads"})->Unit(benchmark::kMillisecond)->UseRealTime();
}
BENCHMARK(step)->Apply([](auto* b) { sizes(b, true); });
BENCHMARK(forward_and_reverse)->Apply([](auto* b) { sizes(b, true); });
BENCHMARK(phases)->Apply([](auto* b) { sizes(b, false); });

}  // namespace
}  // namespace pliant

int main(int argc, char** argv) {
  pliant::keep_freed_memory();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
