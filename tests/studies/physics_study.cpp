// Convergence and speed of the elastic solver.  Prints one JSON object per case.
//   physics_study cantilever CELLS [random]   slender beam, CELLS through the height, against Euler-Bernoulli
//   physics_study stem COUNT...               peak deflection of a pushed stem for several particle counts
//   physics_study drift COUNT                 motion of a pinned stem without input
//   physics_study speed COUNT SECONDS         particle-substeps per second for one and for all threads
// grid=eulerian|lagrangian anywhere among them; default: the solver's own choice.

#include <omp.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "physics/body/driving_particles.h"
#include "physics/body/make_particles.h"
#include "physics/simulate/simulate.h"
#include "tests/physics/shapes.h"
#include "tests/studies/study_grid.h"

namespace pliant {
namespace {

constexpr double kPi = 3.14159265358979324;
GridKind grid = GridKind::kAutomatic;

SimulateOptions grid_options() {
  SimulateOptions options;
  options.grid = grid;
  return options;
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Beam with square section h = L / 10 along x, clamped at x = 0 by pinned nodes, eight particles to a cell, loaded
/// from rest by a constant acceleration: the tip swings between 0 and twice its sag with the first frequency.
void cantilever(int cells, bool random) {
  const double length = 0.2, height = 0.1 * length, dx = height / cells, young = 1e6, density = 1000, poisson = 0.3;
  const double foot = 3 * dx;
  Particles p = fixture::block<float>({length + foot, height, height}, dx, random ? 1.0 : 0.0, young, poisson, density);
  const double inertia = std::pow(height, 4) / 12, area = height * height;
  const double frequency =
      1.8751 * 1.8751 / (2 * kPi) * std::sqrt(young * inertia / (density * area * std::pow(length, 4)));
  const double sag = 0.01 * length, load = sag * 8 * young * inertia / (density * area * std::pow(length, 4));

  SimulateOptions options = grid_options();
  options.gravity.setZero();
  options.fps = 60 * frequency;
  options.duration = 1.2 / frequency;
  Interaction pin, gust;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d(foot, 0, 0), Vec3d(1, 0, 0));
  gust.type = InteractionType::kGust;
  gust.vector = Vec3d(0, 0, -load);
  std::vector<double> tip;
  const auto begin = std::chrono::steady_clock::now();
  const auto result = simulate<float>(options, p, {pin, gust}, initial_state(p), [&](const SimulationState& s) {
    double sum = 0;
    int count = 0;
    for (size_t i = 0; i < s.size(); ++i)
      if (p.position[i].x() > foot + length - dx) {
        sum += p.position[i].z() - s.x[i].z();
        ++count;
      }
    tip.push_back(sum / count);
    return true;
  });
  // First peak, then the first return to the lowest point, by parabolas through three samples.
  const auto vertex = [&](size_t k, double sign, double& time) {
    const double a = sign * tip[k - 1], b = sign * tip[k], c = sign * tip[k + 1], bend = a - 2 * b + c;
    time = (static_cast<double>(k) + 0.5 * (a - c) / bend) / options.fps;
    return sign * (b - 0.125 * (a - c) * (a - c) / bend);
  };
  size_t top = 1;
  while (top + 1 < tip.size() && !(tip[top] >= tip[top - 1] && tip[top] > tip[top + 1])) ++top;
  size_t bottom = top + 1;
  while (bottom + 1 < tip.size() && !(tip[bottom] <= tip[bottom - 1] && tip[bottom] < tip[bottom + 1])) ++bottom;
  double peak_time = 0, return_time = 0;
  const double peak = vertex(top, 1, peak_time), low = bottom + 1 < tip.size() ? vertex(bottom, -1, return_time) : 0;
  // Equal decay on both half swings: sag = (peak^2 ...) of x = s (1 - q cos) with x(0) = 0.
  const double q = (peak - low) > 0 ? (peak - low) / peak : 1;  // ratio of successive half swings
  const double measured_sag = peak / (1 + q);
  std::printf(
      "{\"study\": \"cantilever\", \"cells\": %d, \"random\": %s, \"particles\": %zu, \"frequency\": %.5g, "
      "\"frequency_error\": %.4f, \"sag\": %.5g, \"sag_error\": %.4f, \"log_decrement\": %.4f, "
      "\"substeps\": %lld, \"seconds\": %.1f}\n",
      cells, random ? "true" : "false", p.size(), 1 / return_time, 1 / return_time / frequency - 1, measured_sag,
      measured_sag / sag - 1, -2 * std::log(q), static_cast<long long>(result.state.substeps), seconds_since(begin));
}

struct Stem {
  static constexpr double kWidth = 0.02, kLength = 0.2, kFoot = 0.04;
  SolidSamples samples;
  Interaction pin;

  Stem() {
    samples = fixture::solid({kWidth, kWidth, kLength + kFoot}, kWidth / 26, [](const Vec3d& x) {
      return std::hypot(x.x() - 0.5 * kWidth, x.y() - 0.5 * kWidth) < 0.5 * kWidth;
    });
    pin.type = InteractionType::kPin;
    pin.region = Region::half_space(Vec3d(0, 0, kFoot), Vec3d(0, 0, 1));
  }
  Particles particles(int count) const {
    const SimulatedPart part = select_simulated(samples, std::vector<Region>{pin.region}, count);
    const SolidSamples kept = samples.select(part.kept);
    DriverOptions options;
    options.count = count;
    return make_particles<float>(kmeans_drivers(options, kept), kept,
                                 ElasticSamples::homogeneous(kept.size(), 1e6, 0.3, 1000), 1.0);
  }
};

void stem(int count) {
  const Stem stem;
  const Particles p = stem.particles(count);
  SimulateOptions options = grid_options();
  options.duration = 0.25;
  options.fps = 120;
  Interaction push;
  push.type = InteractionType::kPointForce;
  push.vector = Vec3d(0.02, 0, 0);
  push.region = Region::box(Vec3d(-1, -1, Stem::kFoot + 0.8 * Stem::kLength), Vec3d(1, 1, 1));
  double peak = 0;
  const auto begin = std::chrono::steady_clock::now();
  simulate<float>(options, p, {stem.pin, push}, initial_state(p), [&](const SimulationState& s) {
    double sum = 0, mass = 0;
    for (size_t i = 0; i < s.size(); ++i) {
      if (p.position[i].z() < Stem::kFoot + 0.8 * Stem::kLength) continue;
      sum += p.mass[i] * (s.x[i].x() - p.position[i].x());
      mass += p.mass[i];
    }
    peak = std::max(peak, sum / mass);
    return true;
  });
  std::printf(
      "{\"study\": \"stem\", \"particles\": %zu, \"cells_thick\": %.2f, \"volume_error\": %.5f, \"peak\": %.6g, "
      "\"seconds\": %.1f}\n",
      p.size(), Stem::kWidth / p.cell_size,
      stem.samples.total_volume() / (kPi / 4 * Stem::kWidth * Stem::kWidth * (Stem::kLength + Stem::kFoot)) - 1, peak,
      seconds_since(begin));
}

void drift(int count) {
  const Stem stem;
  const Particles p = stem.particles(count);
  SimulateOptions options = grid_options();
  options.duration = 3;
  const auto summary = simulate<float>(options, p, {stem.pin}, initial_state(p)).summary;
  std::printf("{\"study\": \"drift\", \"particles\": %zu, \"drift_over_height\": %.3g, \"seconds\": %.1f}\n", p.size(),
              summary.max_displacement / Stem::kLength, summary.seconds);
}

void speed(int count, double seconds) {
  const double dx = 0.01;
  const int side = std::max(1, static_cast<int>(std::lround(std::cbrt(count / 64.0))));
  const Particles p = fixture::block<float>({side * dx, side * dx, 8 * side * dx}, dx, 1.0, 1e5);
  Interaction pin, gust;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d(0, 0, 2 * dx), Vec3d(0, 0, 1));
  gust.type = InteractionType::kGust;
  gust.vector = Vec3d(1, 0, 0);
  SimulateOptions options = grid_options();
  options.duration = seconds;
  const int most = omp_get_max_threads();
  for (int threads = 1; threads <= most; threads *= 2) {
    omp_set_num_threads(threads);
    const auto summary = simulate<float>(options, p, {pin, gust}, initial_state(p)).summary;
    std::printf(
        "{\"study\": \"speed\", \"particles\": %zu, \"threads\": %d, \"million_particle_substeps_per_second\": "
        "%.2f, \"seconds\": %.2f}\n",
        p.size(), threads, summary.particle_substeps / summary.seconds * 1e-6, summary.seconds);
  }
  omp_set_num_threads(most);
}

}  // namespace
}  // namespace pliant

int main(int argc, char** argv) {
  pliant::grid = pliant::fixture::take_grid(argc, argv);
  const std::string study = argc > 1 ? argv[1] : "";
  const auto number = [&](int k, double otherwise) { return argc > k ? std::atof(argv[k]) : otherwise; };
  if (study == "cantilever") {
    pliant::cantilever(static_cast<int>(number(2, 6)), argc > 3);
  } else if (study == "stem") {
    for (int k = 2; k < argc; ++k) pliant::stem(std::atoi(argv[k]));
  } else if (study == "drift") {
    pliant::drift(static_cast<int>(number(2, 4000)));
  } else if (study == "speed") {
    pliant::speed(static_cast<int>(number(2, 8000)), number(3, 1));
  } else {
    std::fprintf(
        stderr, "usage: physics_study cantilever CELLS [random] | stem COUNT... | drift COUNT | speed COUNT SECONDS\n");
    return 2;
  }
}
