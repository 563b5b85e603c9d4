// What the reverse mode of roll-outs costs and how far it holds: gradients over 1000 substeps against differences, the
// memory and time of a long roll-out, and bits that do not depend on threads.  Writes JSON to standard output.
//
//   adjoint_study [all | long | cost | threads | directions]

#include <omp.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "tests/physics/simulate/adjoint_rollout_case.h"

namespace pliant {
namespace {

using fixture::Input;
using nlohmann::json;

double seconds_of(const std::function<void()>& call) {
  const auto begin = std::chrono::steady_clock::now();
  call();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// A block that is thrown onto a rough ground or bends on a pin, for `substeps` in frames of 50.
fixture::RolloutCase<double> long_case(bool pinned, int substeps) {
  auto c = fixture::moving_block<double>(4);
  c.options.simulate.fps = 1.0 / (50 * 2e-4);
  c.options.simulate.substeps = 50;
  c.options.simulate.duration = substeps * 2e-4;
  if (pinned) {
    c.interactions.push_back(fixture::pin_below(0.004));
  } else {
    c.interactions.push_back(fixture::ground(0, 0.3));
    for (auto& v : c.start.v) v += Vec3d(0.3, 0.1, -0.2);
  }
  return c;
}

/// Directions in which all inputs of one kind change, by reverse mode and by differences.
json directions(const fixture::RolloutCase<double>& c, int count, double step) {
  const RolloutGradient<double> gradient = c.gradient();
  json result;
  double product = 0, reverse_squares = 0, difference_squares = 0;
  for (const auto& [kind, name] : fixture::kInputs) {
    const std::vector<double> at = c.get(kind), g = c.part(gradient, kind);
    if (at.empty()) continue;
    double worst = 0, one_product = 0, one_reverse = 0, one_difference = 0;
    for (int d = 0; d < count; ++d) {
      std::vector<double> plus = at, minus = at;
      double slope = 0;
      for (size_t k = 0; k < at.size(); ++k) {
        const double u = Random(17, k, d).normal() / std::sqrt(static_cast<double>(at.size()));
        plus[k] += step * u;
        minus[k] -= step * u;
        slope += g[k] * u;
      }
      const double difference = (c.with(kind, plus).value() - c.with(kind, minus).value()) / (2 * step);
      one_product += slope * difference;
      one_reverse += slope * slope;
      one_difference += difference * difference;
      worst = std::max(worst, std::abs(slope - difference) / std::max(std::abs(slope), std::abs(difference)));
    }
    result[name] = {{"cosine", one_product / std::sqrt(one_reverse * one_difference)}, {"worst_relative", worst}};
    product += one_product;
    reverse_squares += one_reverse;
    difference_squares += one_difference;
  }
  result["all"] = {{"cosine", product / std::sqrt(reverse_squares * difference_squares)}};
  return result;
}

/// Particles of a stated number in float, swinging on a pin.
fixture::RolloutCase<float> large_case(int n, int frames, int substeps, Law law) {
  fixture::RolloutCase<float> c;
  const double cells = std::cbrt(n / 8.0), dx = 0.01;
  c.particles = fixture::block<float>(Vec3d::Constant(std::round(2 * cells) / 2 * dx), dx, 0.9, 2e4, 0.3, 1000);
  c.particles.materials[0].law = law;
  c.start = initial_state(c.particles);
  for (size_t i = 0; i < c.start.size(); ++i)
    c.start.v[i] = Vec3f(0.3f * c.start.x[i].z() / (float(cells * dx)), 0.f, 0.f);
  c.options.simulate.fps = 1 / (substeps * 2e-4);
  c.options.simulate.substeps = substeps;
  c.options.simulate.duration = frames * substeps * 2e-4;
  c.interactions.push_back(fixture::pin_below(0.012));
  return c;
}

json cost(int n, int frames, int substeps, Law law, size_t memory) {
  auto c = large_case(n, frames, substeps, law);
  c.options.memory = memory;
  Rollout<float> forward;
  const double rollout_seconds =
      seconds_of([&] { forward = rollout(c.options, c.particles, c.interactions, c.start); });
  const RolloutGradient<float> g =
      rollout_adjoint<float>(c.options, c.particles, c.interactions, forward, c.cotangent());
  const double work = static_cast<double>(c.particles.size()) * frames * substeps * 1e-9;
  return {{"particles", c.particles.size()},
          {"frames", frames},
          {"substeps", substeps},
          {"law", law_name(law)},
          {"threads", omp_get_max_threads()},
          {"forward_ns", forward.summary.seconds / work},
          {"rollout_ns", rollout_seconds / work},
          {"recompute_ns", g.forward_seconds / work},
          {"reverse_ns", g.reverse_seconds / work},
          {"reverse_over_forward", g.reverse_seconds / forward.summary.seconds},
          {"megabytes", static_cast<double>(g.bytes) / (1 << 20)},
          {"peak_megabytes", peak_megabytes()}};
}

bool equal_for_threads() {
  const auto c = large_case(30'000, 2, 20, Law::kFixedCorotated);
  omp_set_num_threads(1);
  const RolloutGradient<float> one = c.gradient();
  bool equal = true;
  for (const int threads : {2, 3, 4}) {
    omp_set_num_threads(threads);
    const RolloutGradient<float> g = c.gradient();
    equal &= one.start.x == g.start.x && one.start.v == g.start.v && one.start.C == g.start.C &&
             one.start.F == g.start.F && one.young == g.young && one.poisson == g.poisson && one.mass == g.mass;
  }
  return equal;
}

}  // namespace
}  // namespace pliant

int main(int argc, char** argv) {
  using namespace pliant;
  const std::string part = argc > 1 ? argv[1] : "all";
  json result;
  const int threads = omp_get_max_threads();
  // First, so that the peak is its own.
  if (part == "long" || part == "all") result["long"] = cost(10'000, 24, 200, Law::kFixedCorotated, size_t{512} << 20);
  if (part == "cost" || part == "all") {
    for (const Law law : {Law::kFixedCorotated, Law::kNeoHookean})
      for (const int n : {10'000, 100'000})
        for (const int t : {1, 2}) {
          omp_set_num_threads(t);
          result["cost"].push_back(cost(n, 2, n > 50'000 ? 10 : 50, law, size_t{1} << 30));
        }
    omp_set_num_threads(threads);
  }
  if (part == "threads" || part == "all") result["equal_bits_for_1_2_3_4_threads"] = equal_for_threads();
  omp_set_num_threads(threads);
  if (part == "directions" || part == "all")
    for (const int substeps : {60, 300, 1000})
      for (const bool pinned : {true, false})
        result["directions"][std::to_string(substeps) + (pinned ? " pinned" : " on the ground")] =
            directions(long_case(pinned, substeps), 8, 1e-6);
  std::cout << result.dump(1) << "\n";
  return 0;
}
