#include "app/simulate/clip_work.h"

#include <fmt/format.h>

#include <cmath>

#include "physics/simulate/simulator.h"

namespace pliant {
namespace {

constexpr double kStepsOfMinute = 10 * kUsualParticleSteps;  // on two slow cores
constexpr double kWorthSaying = 5;                           // minutes

std::string duration_text(double minutes) {
  constexpr double kHour = 60, kDay = 24 * kHour;
  if (minutes < 2 * kHour) return fmt::format("{:.0f} minutes", minutes);
  if (minutes < 2 * kDay) return fmt::format("{:.0f} hours", minutes / kHour);
  return fmt::format("{:.3g} days", minutes / kDay);
}

}  // namespace

std::string describe_work(const SimulateOptions& options, const Particles& particles) {
  const double frames = std::round(options.fps * options.duration), substeps = substeps_at_rest(options, particles),
               steps = frames * substeps, minutes = steps * static_cast<double>(particles.size()) / kStepsOfMinute;
  if (minutes < kWorthSaying) return "";
  const double dx = options.cell_size > 0 ? options.cell_size : static_cast<double>(particles.cell_size);
  const size_t stiffest = fastest_wave(options, particles, dx).particle;
  return fmt::format(
      "E = {:.3g} Pa on cells of {:.3g} m needs time steps of {:.2g} s: {:.3g} steps of {} particles for the clip, "
      "about {} on two cores; a lower Young's modulus, larger cells (seed with fewer --particles) or a shorter "
      "--duration take less",
      particles.young[stiffest], dx, 1 / (options.fps * substeps), steps, particles.size(), duration_text(minutes));
}

}  // namespace pliant
