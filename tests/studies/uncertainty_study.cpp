// Is the stated standard deviation of E(x) true?  uncertainty_study OUT.json [SEEDS=16] [NOISE_PX=0.1] [LENGTH_M=0.03]
// Stems whose ln E is a smooth random field are filmed by one camera with Gaussian errors; each is fitted from a wrong
// homogeneous start.  Pooled over seeds and places that the fit calls determined: the share of errors within one and
// two standard deviations, and the median error.

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "fitting/fit/fit_material.h"
#include "gaussians/io/files/json_file.h"
#include "tests/fitting/twin_stem.h"

using namespace pliant;
using nlohmann::json;

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: %s OUT.json [SEEDS] [NOISE_PX] [LENGTH_M]\n", argv[0]), 2;
  const int seeds = argc > 2 ? std::atoi(argv[2]) : 16;
  const double noise = argc > 3 ? std::atof(argv[3]) : 0.1, length = argc > 4 ? std::atof(argv[4]) : 0.03;
  json rows = json::array();
  std::vector<double> errors;
  size_t within_one = 0, within_two = 0, determined = 0, places = 0;
  for (int seed = argc > 5 ? std::atoi(argv[5]) : 1; seed <= seeds; ++seed) {
    fixture::TwinStem twin;
    MaterialFitOptions options;
    options.kind = MaterialKind::kSmooth;
    options.smooth.sigma = 0.8;
    options.smooth.length = length;
    options.smooth.modes = 24;
    options.vibration.modes.most = 6;
    options.vibration.search.first = 0;
    options.vibration.refine.tolerance = argc > 7 ? std::atof(argv[7]) : 1e-3;
    options.vibration.most_smooth = argc > 6 ? std::atoi(argv[6]) : 6;
    const SmoothField truth(options.smooth, twin.particles.position);
    std::vector<double> z(truth.parameters());
    for (size_t k = 0; k < z.size(); ++k) z[k] = Random(seed, k).normal();
    const std::vector<double> factor = truth.values(z);
    Particles guess = twin.particles;
    for (size_t i = 0; i < guess.size(); ++i) {
      twin.particles.young[i] = static_cast<float>(3e4 * std::exp(factor[i]));
      guess.young[i] = 6e4f;
    }
    const TrackLoss<float> tracks = twin.film(twin.pins, twin.kicked(0.4), true, 24, 24, noise, seed);
    const MaterialFit fit = fit_material(options, guess, twin.pins, tracks, twin.fps);
    // Places: every twelfth particle above the clamp.
    size_t one = 0, two = 0, count = 0;
    std::vector<double> of_seed;
    for (size_t i = 0; i < guess.size(); i += 12) {
      if (twin.particles.position[i].z() < 0.02f) continue;
      ++places;
      if (!fit.determined(i)) continue;
      const double error = std::abs(std::log10(fit.young[i] / twin.particles.young[i]));
      ++count;
      one += error < fit.sigma[i];
      two += error < 2 * fit.sigma[i];
      of_seed.push_back(error);
      errors.push_back(error);
    }
    determined += count;
    within_one += one;
    within_two += two;
    std::sort(of_seed.begin(), of_seed.end());
    const double median = of_seed.empty() ? 0 : of_seed[of_seed.size() / 2];
    rows.push_back({{"seed", seed},
                    {"determined", count},
                    {"median", median},
                    {"within_1_sigma", one},
                    {"within_2_sigma", two},
                    {"damping", fit.found.damping_time / twin.damping_time},
                    {"rms_px", fit.found.rms}});
    std::printf(
        "seed %d: %zu determined, median |dlog10 E| %.3f, within 1 sigma %.2f, 2 sigma %.2f, damping x %.2f, rms %.3f "
        "px\n",
        seed, count, median, count ? double(one) / count : 0, count ? double(two) / count : 0,
        fit.found.damping_time / twin.damping_time, fit.found.rms);
    std::fflush(stdout);
  }
  std::sort(errors.begin(), errors.end());
  const double n = std::max<double>(1, determined);
  const json result = {{"places", places},
                       {"determined", determined},
                       {"within_1_sigma", within_one / n},
                       {"within_2_sigma", within_two / n},
                       {"median", errors.empty() ? 0 : errors[errors.size() / 2]},
                       {"seeds", rows}};
  std::printf("%zu of %zu places determined: %.1f %% within 1 sigma, %.1f %% within 2; median |dlog10 E| %.3f\n",
              determined, places, 100 * within_one / n, 100 * within_two / n, result["median"].get<double>());
  write_json(argv[1], result);
  return 0;
}
