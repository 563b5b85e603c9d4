#include "gaussians/reconstruct/densify_classic.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

constexpr uint64_t kSplitStream = 0x73706c6974ull;
constexpr float kSplitShrink = 1.6f;  // of the reference code

/// Moves Gaussian i to a point drawn from what it was, and makes it smaller.
void shrink_into(const GaussianCloud& before, size_t from, Random random, GaussianCloud& cloud, size_t i) {
  const Vec3f normal(random.normal(), random.normal(), random.normal());
  const Vec3f deviation = before.log_scale[from].array().exp();
  cloud.position[i] =
      before.position[from] + rotation_matrix<float>(before.rotation[from]) * deviation.cwiseProduct(normal);
  cloud.log_scale[i] = before.log_scale[from].array() - std::log(kSplitShrink);
}

}  // namespace

void gather_screen_gradient(std::span<const Vec2f> screen, int width, int height, TrainingState& state) {
  CHECK(screen.size() == state.cloud.size());
  state.screen_gradient.resize(screen.size(), 0.0f);
  state.times_seen.resize(screen.size(), 0.0f);
  const Vec2f half(0.5f * width, 0.5f * height);
  parallel_for(
      static_cast<std::ptrdiff_t>(screen.size()),
      [&](std::ptrdiff_t i) {
        if (screen[i].isZero()) return;
        state.screen_gradient[i] += screen[i].cwiseProduct(half).norm();
        state.times_seen[i] += 1;
      },
      4096);
}

ClassicSummary clone_split_prune(const TrainOptions& options, float extent, size_t budget, TrainingState& state) {
  const size_t n = state.cloud.size();
  state.screen_gradient.resize(n, 0.0f);
  state.times_seen.resize(n, 0.0f);
  std::vector<int> wanted;
  std::vector<float> mean(n, 0.0f);
  std::vector<uint8_t> keep(n, 1);
  ClassicSummary summary;
  for (size_t i = 0; i < n; ++i) {
    const float opacity = sigmoid(state.cloud.opacity_logit[i]);
    keep[i] = opacity > options.dead_opacity && state.cloud.position[i].allFinite();
    summary.pruned += !keep[i];
    if (state.times_seen[i] > 0) mean[i] = state.screen_gradient[i] / state.times_seen[i];
    if (keep[i] && mean[i] > options.screen_gradient) wanted.push_back(static_cast<int>(i));
  }
  std::stable_sort(wanted.begin(), wanted.end(), [&](int a, int b) { return mean[a] > mean[b]; });
  const size_t left = n - summary.pruned, room = budget > left ? budget - left : 0;
  wanted.resize(std::min(wanted.size(), room));

  std::vector<int> rows;
  for (size_t i = 0; i < n; ++i)
    if (keep[i]) rows.push_back(static_cast<int>(i));
  std::vector<size_t> place(n);
  for (size_t k = 0; k < rows.size(); ++k) place[rows[k]] = k;
  const size_t first_new = rows.size();
  rows.insert(rows.end(), wanted.begin(), wanted.end());
  const GaussianCloud before = state.cloud;
  keep_gaussians(state, rows);
  for (size_t k = 0; k < wanted.size(); ++k) {
    const size_t from = wanted[k], made = first_new + k;
    clear_moments(state, made);
    if (before.log_scale[from].maxCoeff() <= std::log(options.split_scale * extent)) {
      ++summary.cloned;
      continue;
    }
    ++summary.split;
    clear_moments(state, place[from]);
    shrink_into(before, from, Random(options.seed ^ kSplitStream, 2 * from, state.iteration), state.cloud, place[from]);
    shrink_into(before, from, Random(options.seed ^ kSplitStream, 2 * from + 1, state.iteration), state.cloud, made);
  }
  state.screen_gradient.assign(state.cloud.size(), 0.0f);
  state.times_seen.assign(state.cloud.size(), 0.0f);
  return summary;
}

void reset_opacities(TrainingState& state) {
  const float most = logit(0.01f);
  for (float& opacity : state.cloud.opacity_logit) opacity = std::min(opacity, most);
  std::fill(state.opacity_logit.first.begin(), state.opacity_logit.first.end(), 0.0f);
  std::fill(state.opacity_logit.second.begin(), state.opacity_logit.second.end(), 0.0f);
}

}  // namespace pliant
