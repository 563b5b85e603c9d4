#include "app/simulate/stiffness_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "segmentation/sheets/sides_sheet.h"

namespace pliant {
namespace {

// From darker to lighter, so that the order can be told without colors, and the darkest still reads on the dark sheet.
const Vec3f kRamp[] = {{0.62f, 0.25f, 0.75f}, {0.45f, 0.45f, 0.90f}, {0.25f, 0.62f, 0.80f},
                       {0.20f, 0.75f, 0.58f}, {0.52f, 0.86f, 0.35f}, {0.99f, 0.93f, 0.30f}};
constexpr int kSteps = 6;
constexpr double kTail = 0.02;           // of the samples, at either end, beyond the outer steps
constexpr double kSmallestRange = 0.02;  // decades; less is one value

}  // namespace

ImageF stiffness_sheet(const GaussianCloud& object, const Eigen::Vector3d& up, const std::vector<Vec3f>& positions,
                       const std::vector<float>& young, const std::string& title) {
  CHECK(!young.empty() && positions.size() == young.size());
  std::vector<float> sorted = young;
  std::sort(sorted.begin(), sorted.end());
  const auto at = [&](double share) {
    return sorted[static_cast<size_t>(share * static_cast<double>(sorted.size() - 1))];
  };
  const double low = std::log10(at(kTail)), high = std::log10(at(1 - kTail));
  const bool uniform = high - low < kSmallestRange;
  const int steps = uniform ? 1 : kSteps;
  std::vector<SheetKind> kinds;
  for (int k = 0; k < steps; ++k) {
    const double from = low + (high - low) * k / steps, to = low + (high - low) * (k + 1) / steps;
    const std::string range = uniform ? fmt::format("{:.2g} Pa", std::pow(10, low))
                                      : fmt::format("{:.1e} to {:.1e} Pa", std::pow(10, from), std::pow(10, to));
    kinds.push_back({range, kRamp[uniform ? kSteps / 2 : k], 0});
  }
  const std::vector<int> nearest = k_nearest(positions, object.position, 1);
  std::vector<int> kind(object.size());
  for (size_t g = 0; g < object.size(); ++g) {
    const double step = steps * (std::log10(young[nearest[g]]) - low) / std::max(high - low, 1e-9);
    kind[g] = std::clamp(static_cast<int>(std::floor(step)), 0, steps - 1);
    ++kinds[kind[g]].count;
  }
  return sides_sheet(object, sheet_sides(object, up), kind, kinds, title, {});
}

}  // namespace pliant
