// Where gradients alone lead.  gradient_start_study OUT.json [ITERATIONS=100]
// A stem of one E is filmed while it swings; exact gradients of E and damping (Adam, a window that grows, as
// PhysDreamer) start from E times each factor, once with the true v0 given and once with v0 = 0 and found too. Reported
// beside the search over log E, which needs no start.

#include <cstdio>
#include <nlohmann/json.hpp>

#include "fitting/fields/part_field.h"
#include "fitting/fields/smooth_field.h"
#include "fitting/fit/fit_clip.h"
#include "gaussians/io/files/json_file.h"
#include "tests/fitting/twin_stem.h"

using namespace pliant;
using nlohmann::json;

namespace {

constexpr int kFrames = 24;

/// Three channels, each a smooth field.
class SmoothVelocity : public Field {
 public:
  explicit SmoothVelocity(std::span<const Vec3f> points) : one_(options(), points) {}
  size_t points() const override { return one_.points(); }
  int channels() const override { return 3; }
  std::vector<double> constant(std::span<const double>) const override {
    return std::vector<double>(3 * one_.parameters(), 0.0);
  }
  std::vector<double> values(std::span<const double> parameters) const override {
    std::vector<double> out(3 * points());
    for (size_t c = 0; c < 3; ++c) {
      const std::vector<double> v = one_.values(parameters.subspan(c * one_.parameters(), one_.parameters()));
      for (size_t i = 0; i < v.size(); ++i) out[3 * i + c] = v[i];
    }
    return out;
  }
  std::vector<double> values_adjoint(std::span<const double> parameters,
                                     std::span<const double> adj_values) const override {
    std::vector<double> out, adj(points());
    for (size_t c = 0; c < 3; ++c) {
      for (size_t i = 0; i < adj.size(); ++i) adj[i] = adj_values[3 * i + c];
      const std::vector<double> by =
          one_.values_adjoint(parameters.subspan(c * one_.parameters(), one_.parameters()), adj);
      out.insert(out.end(), by.begin(), by.end());
    }
    return out;
  }

 private:
  static SmoothFieldOptions options() {
    SmoothFieldOptions options;
    options.sigma = 0.3;
    options.modes = 8;
    options.least = 1e-5;
    options.length = 0.035;
    return options;
  }
  SmoothField one_;
};

/// log10 of what remains of a factor of E after gradients.
double remaining(const fixture::TwinStem& twin, const TrackLoss<float>& tracks, double factor, bool know_velocity,
                 int iterations) {
  Motion<float> motion{twin.particles, twin.kicked(0.4), twin.pins, {}};
  for (float& young : motion.particles.young) young = static_cast<float>(young * factor);
  if (!know_velocity) motion.start = initial_state(motion.particles);
  SimulateOptions& simulate = motion.options.simulate;
  simulate.fps = twin.fps;
  simulate.duration = kFrames / twin.fps;
  simulate.damping_time = twin.damping_time;
  ClipFitOptions options;
  options.material = std::make_shared<PartField>(motion.particles.size(), 1);
  if (!know_velocity) options.velocity = std::make_shared<SmoothVelocity>(motion.particles.position);
  options.gradient.iterations = options.gradient.patience = iterations;
  options.gradient.material_rate = 0.1;
  options.gradient.velocity_rate = 0.1;
  Objective<float> objective;
  objective.terms.push_back({1, std::make_shared<TrackLoss<float>>(tracks)});
  const ClipFit fit = fit_clip(options, motion, objective, {});
  return std::log10(fit.motion.particles.young[0] / twin.particles.young[0]);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: %s OUT.json [ITERATIONS]\n", argv[0]), 2;
  const int iterations = argc > 2 ? std::atoi(argv[2]) : 100;
  const fixture::TwinStem twin;
  const TrackLoss<float> tracks = twin.film(twin.pins, twin.kicked(0.4), true, kFrames, 24, 0.1, 1);
  json rows = json::array();
  for (const double factor : {1 / 30.0, 0.1, 1 / 3.0, 0.7, 1.4, 3.0, 10.0, 30.0}) {
    Particles guess = twin.particles;
    for (float& young : guess.young) young = static_cast<float>(young * factor);
    VibrationFitOptions options;
    options.modes.most = 6;
    options.refine.tolerance = 1e-3;
    options.most_smooth = 6;
    const VibrationFit found = fit_vibration(options, guess, twin.pins, tracks, twin.fps);
    const double search = found.search.minima[0].log10_factor + std::log10(factor),
                 refined = found.log10_factor + std::log10(factor);
    const double known = remaining(twin, tracks, factor, true, iterations),
                 unknown = remaining(twin, tracks, factor, false, iterations);
    rows.push_back({{"start", std::log10(factor)},
                    {"search", search},
                    {"search_and_gauss_newton", refined},
                    {"gradients_true_v0", known},
                    {"gradients_v0_found_too", unknown}});
    std::printf(
        "start x %7.3f: log10 of E over the truth after search %+.3f, Gauss-Newton %+.3f; gradients alone %+.3f with "
        "the true v0, %+.3f with v0 found too\n",
        factor, search, refined, known, unknown);
    std::fflush(stdout);
  }
  write_json(argv[1], {{"iterations", iterations}, {"rows", rows}});
  return 0;
}
