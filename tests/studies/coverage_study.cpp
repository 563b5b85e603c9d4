// Do the stated errors of E and damping hold the truth as often as they say?  coverage_study OUT.csv [FIRST=1]
// [LAST=120] Small stems of random stiffness, damping, kick and track error are filmed by one camera and fitted from a
// start that is up to ten times wrong.  Each third has another kind of error: independent ones, ones that drift over
// some frames as a tracker's do, and independent ones of a truth that was simulated on a finer grid.  `pliant evaluate
// calibration OUT.csv` makes the tables.

#include <omp.h>

#include <chrono>
#include <cstdio>
#include <fstream>

#include "tests/fitting/twin_stem.h"

using namespace pliant;

namespace {

constexpr double kDrift = 0.8;  // correlation of a drifting error with that of the frame before
constexpr double kLn10 = 2.302585092994046;

PointTracks with_errors(PointTracks seen, double pixels, double correlation, uint64_t seed) {
  const size_t count = seen.rest.size();
  for (size_t k = 0; k < count; ++k)
    for (int a = 0; a < 2; ++a) {
      Random random(seed, 2 * k + a);
      double error = random.normal();
      for (std::vector<Vec3d>& places : seen.place) {
        places[k][a] += pixels * error;
        error = correlation * error + std::sqrt(1 - correlation * correlation) * random.normal();
      }
    }
  return seen;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: %s OUT.csv [FIRST] [LAST]\n", argv[0]), 2;
  const int first = argc > 2 ? std::atoi(argv[2]) : 1, last = argc > 3 ? std::atoi(argv[3]) : 120;
  std::ofstream out(argv[1]);
  out << "quantity,estimate,truth,low,high\n";
  omp_set_num_threads(1);
  const char* const kinds[] = {"independent", "drifting", "finer"};
  for (int seed = first; seed <= last; ++seed) {
    Random random(17, seed);
    const std::string kind = kinds[seed % 3];
    const double young = 1e4 * std::pow(10, random.uniform(0, 1)), wrong = std::pow(10, random.uniform(-1, 1)),
                 damping = 0.25 * std::pow(6, random.uniform(0, 1)), speed = random.uniform(0.2, 0.6),
                 pixels = 0.05 * std::pow(10, random.uniform(0, 1));
    fixture::TwinStem guess, truth;
    if (kind == "finer") {
      truth.particles = fixture::block<float>(Vec3d(0.02, 0.02, 0.09), 0.006, 0.5, young, 0.3, 1000);
      truth.drivers = truth.particles.position;
    }
    truth.damping_time = damping;
    for (float& E : truth.particles.young) E = static_cast<float>(young);
    for (float& E : guess.particles.young) E = static_cast<float>(wrong * young);
    const TrackLoss<float> seen = truth.film(truth.pins, truth.kicked(speed), true, 30, 12);
    const TrackLoss<float> tracks(with_errors(seen.tracks(), pixels, kind == "drifting" ? kDrift : 0, seed),
                                  guess.drivers, 1, 2);
    VibrationFitOptions options;
    options.modes.most = 6;
    options.search.first = 0;
    const auto begin = std::chrono::steady_clock::now();
    const VibrationFit fit = fit_vibration(options, guess.particles, guess.pins, tracks, guess.fps);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const double log10_young = std::log10(wrong * young) + fit.log10_factor;
    const auto row = [&](const char* name, double estimate, double true_value, double low, double high) {
      out << name << " (" << kind << ")," << estimate << ',' << true_value << ',' << low << ',' << high << std::endl;
    };
    row("log10 E", log10_young, std::log10(young), log10_young - fit.log10_sigma, log10_young + fit.log10_sigma);
    row("ln damping time", std::log(fit.damping_time), std::log(damping), std::log(fit.damping_time_low),
        std::log(fit.damping_time_high));
    std::printf("%d %s: E x %.4f (sigma %.4f), damping x %.3f (%.3f to %.3f), %.2f px of %.2f, %.1f s\n", seed,
                kind.c_str(), std::exp(kLn10 * (log10_young - std::log10(young))), fit.log10_sigma,
                fit.damping_time / damping, fit.damping_time_low / damping, fit.damping_time_high / damping, fit.rms,
                pixels, seconds);
    std::fflush(stdout);
  }
}
