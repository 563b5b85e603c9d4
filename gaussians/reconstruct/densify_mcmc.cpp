#include "gaussians/reconstruct/densify_mcmc.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "gaussians/base/portable.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

constexpr int kMostCopies = 51;  // of the reference code; the sum below loses digits beyond
constexpr uint64_t kNoiseStream = 0x6e6f697365ull, kMoveStream = 0x6d6f7665ull;

bool is_finite(const GaussianCloud& cloud, size_t i) {
  const float* sh = cloud.sh_of(i);
  bool finite = cloud.position[i].allFinite() && cloud.rotation[i].allFinite() && cloud.log_scale[i].allFinite() &&
                std::isfinite(cloud.opacity_logit[i]);
  for (int k = 0; k < 3 * cloud.sh_count(); ++k) finite = finite && std::isfinite(sh[k]);
  return finite;
}

/// Draws `count` Gaussians by opacity, given its running sum.
std::vector<int> draw_by_opacity(const std::vector<double>& running_sum, size_t count, Random random) {
  std::vector<int> drawn;
  if (running_sum.empty() || !(running_sum.back() > 0)) return drawn;
  for (size_t k = 0; k < count; ++k) {
    const double at = random.uniform() * running_sum.back();
    const auto found = std::upper_bound(running_sum.begin(), running_sum.end(), at);
    drawn.push_back(static_cast<int>(std::min<std::ptrdiff_t>(found - running_sum.begin(), running_sum.size() - 1)));
  }
  return drawn;
}

}  // namespace

SharedOpacity share_opacity(double opacity, int copies) {
  const int n = std::min(copies, kMostCopies);
  const double shared = 1 - std::pow(1 - opacity, 1.0 / n);
  double denominator = 0;
  for (int i = 1; i <= n; ++i) {
    double binomial = 1, power = shared;  // C(i-1, k), shared^(k+1)
    for (int k = 0; k < i; ++k) {
      denominator += (k % 2 ? -1 : 1) * binomial * power / std::sqrt(k + 1.0);
      binomial *= static_cast<double>(i - 1 - k) / (k + 1);
      power *= shared;
    }
  }
  return {shared, opacity / denominator};
}

McmcSummary relocate_and_grow(const TrainOptions& options, size_t wanted, TrainingState& state) {
  GaussianCloud& cloud = state.cloud;
  const size_t n = cloud.size();
  std::vector<int> dead;
  std::vector<double> running_sum(n);
  double sum = 0;
  for (size_t i = 0; i < n; ++i) {
    const float opacity = sigmoid(cloud.opacity_logit[i]);
    if (!is_finite(cloud, i) || opacity <= options.dead_opacity)
      dead.push_back(static_cast<int>(i));
    else
      sum += opacity;
    running_sum[i] = sum;
  }
  McmcSummary summary;
  const size_t added = wanted > n ? wanted - n : 0;
  const std::vector<int> source =
      draw_by_opacity(running_sum, dead.size() + added, Random(options.seed, kMoveStream, state.iteration));
  if (source.empty()) return summary;

  std::vector<int> copies(n, 1);
  for (int i : source) ++copies[i];
  for (size_t i = 0; i < n; ++i) {
    if (copies[i] == 1) continue;
    const SharedOpacity shared = share_opacity(std::min(0.9999, double(sigmoid(cloud.opacity_logit[i]))), copies[i]);
    const double opacity = std::clamp(shared.opacity, double(options.dead_opacity), 1 - 1e-6);
    cloud.opacity_logit[i] = static_cast<float>(std::log(opacity / (1 - opacity)));
    cloud.log_scale[i].array() += static_cast<float>(std::log(shared.scale));
    clear_moments(state, i);
  }
  for (size_t k = 0; k < dead.size(); ++k) copy_gaussian(state, source[k], dead[k]);
  if (added > 0) {
    std::vector<int> rows(n);
    std::iota(rows.begin(), rows.end(), 0);
    rows.insert(rows.end(), source.begin() + dead.size(), source.end());
    keep_gaussians(state, rows);
  }
  summary.moved = dead.size();
  summary.added = added;
  return summary;
}

void explore(const TrainOptions& options, float rate, float extent, TrainingState& state) {
  GaussianCloud& cloud = state.cloud;
  const float scale = options.noise * rate / (extent * extent);
  parallel_for(
      static_cast<std::ptrdiff_t>(cloud.size()),
      [&](std::ptrdiff_t i) {
        const float opacity = sigmoid(cloud.opacity_logit[i]);
        const float share = sigmoid(100.0f * (0.005f - opacity));
        if (share < 1e-3f) return;  // opaque ones stay where they are
        Random random(options.seed ^ kNoiseStream, i, state.iteration);
        const Vec3f normal(random.normal(), random.normal(), random.normal());
        const Mat3f R = rotation_matrix<float>(cloud.rotation[i]);
        const Vec3f variance = (2.0f * cloud.log_scale[i]).array().exp();
        cloud.position[i] += scale * share * (R * variance.cwiseProduct(R.transpose() * normal));
      },
      256);
}

void add_mcmc_regularisers(const TrainOptions& options, float extent, const GaussianCloud& cloud,
                           CloudOf<float>& gradient) {
  const float n = static_cast<float>(cloud.size());
  parallel_for(
      static_cast<std::ptrdiff_t>(cloud.size()),
      [&](std::ptrdiff_t i) {
        const float opacity = sigmoid(cloud.opacity_logit[i]);
        gradient.opacity_logit[i] += options.opacity_weight / n * opacity * (1 - opacity);
        gradient.log_scale[i] += options.scale_weight / (3 * n * extent) * cloud.log_scale[i].array().exp().matrix();
      },
      1024);
}

}  // namespace pliant
