#include "fitting/observe/frame_clock.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace pliant {
namespace {

constexpr double kGrains[] = {1.0 / 100, 1.0 / 600, 1.0 / 1000};  // s: GIF, QuickTime, Matroska
constexpr double kFinest = 1e-4, kExact = 2e-6;                   // s: least rounding of any file; of a number
constexpr double kEvenStep = 0.1, kGap = 1.5;                     // of the median step
constexpr double kOnBeat = 0.9;                                   // of all stamps
constexpr double kMostRounding = 0.45;                            // of a step, so that no two frames share an instant
constexpr double kMostError = 0.01;                               // of a rate
// Each of them also 1000/1001 times as fast.
constexpr double kCommonRates[] = {10, 12, 12.5, 15, 24, 25, 30, 48, 50, 60, 72, 90, 100, 120, 144, 200, 240, 480, 960};

/// The coarsest rounding that all stamps agree with.
double grain_of(std::span<const double> stamps) {
  for (const double grain : kGrains)
    if (std::all_of(stamps.begin(), stamps.end(),
                    [&](double t) { return std::abs(t - std::round(t / grain) * grain) < kExact; }))
      return grain;
  return 0;
}

double nearest_common(double rate) {
  double nearest = kCommonRates[0];
  for (const double whole : kCommonRates)
    for (const double common : {whole, whole * 1000 / 1001})
      if (std::abs(common - rate) < std::abs(nearest - rate)) nearest = common;
  return nearest;
}

/// The rate of steps that are even but for gaps; `otherwise` where they are not, or as good.
double rate_between_gaps(std::span<const double> stamps, double grain, double otherwise) {
  std::vector<double> steps;
  for (size_t i = 1; i < stamps.size(); ++i) steps.push_back(stamps[i] - stamps[i - 1]);
  std::vector<double> sorted = steps;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>((sorted.size() - 1) / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double median = *middle;
  size_t even = 0, gaps = 0;
  double even_time = 0;
  for (const double step : steps) {
    gaps += step > kGap * median + grain;
    if (std::abs(step - median) > kEvenStep * median + grain) continue;
    ++even;
    even_time += step;
  }
  if (gaps == 0 ? even < steps.size() : 2 * even < steps.size()) return otherwise;
  const double rate = static_cast<double>(even) / even_time;
  // Each run of even steps begins and ends at a rounded instant.
  const double error =
      std::min(kMostError, static_cast<double>(gaps + 1) * std::max(grain, kFinest) / even_time) * rate;
  if (std::abs(otherwise - rate) <= error) return otherwise;
  const double common = nearest_common(rate);
  return std::abs(common - rate) <= error ? common : rate;
}

/// Whether a time stamp is that of a beat of the rate within the rounding.
bool is_beat(double stamp, const FrameClock& clock) {
  const double beat = std::round(stamp * clock.rate) / clock.rate;
  return std::abs(beat - stamp) <= std::min(clock.grain, kMostRounding / clock.rate) + kExact;
}

}  // namespace

double FrameClock::instant(double stamp) const {
  return grain > 0 && is_beat(stamp, *this) ? std::round(stamp * rate) / rate : stamp;
}

FrameClock clock_of(std::span<const double> stamps, double file_rate) {
  if (stamps.size() < 3 || !(file_rate > 0)) return {file_rate, 0};
  FrameClock clock;
  clock.grain = grain_of(stamps);
  clock.rate = rate_between_gaps(stamps, clock.grain, file_rate);
  const auto on_beat = std::count_if(stamps.begin(), stamps.end(), [&](double t) { return is_beat(t, clock); });
  if (static_cast<double>(on_beat) < kOnBeat * static_cast<double>(stamps.size())) clock.grain = 0;
  return clock;
}

}  // namespace pliant
