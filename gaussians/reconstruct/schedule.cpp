#include "gaussians/reconstruct/schedule.h"

#include <algorithm>
#include <cmath>

namespace pliant {

double training_progress(const TrainOptions& options, int iteration, double seconds) {
  const double share = options.seconds > 0 ? seconds / options.seconds
                                           : static_cast<double>(iteration) / std::max(1, options.iterations);
  return std::clamp(share, 0.0, 1.0);
}

float exponential_rate(float first, float last, double progress) {
  return static_cast<float>(first * std::pow(static_cast<double>(last) / first, progress));
}

int sh_degree_at(const TrainOptions& options, double progress) {
  return std::min(options.sh_degree, static_cast<int>(progress * 10 * options.sh_degree));
}

int level_at(const TrainOptions& options, double progress, int longest_side) {
  if (!options.coarse_to_fine) return 0;
  const int wanted = progress < 0.125 ? 2 : progress < 0.375 ? 1 : 0;
  int level = 0;
  while (level < wanted && (longest_side >> (level + 1)) >= 200) ++level;
  return level;
}

size_t planned_gaussians(const TrainOptions& options, size_t started_with, size_t budget, double progress) {
  if (started_with >= budget) return started_with;
  const double share =
      std::clamp((progress - options.refine_from) / (options.grow_until - options.refine_from), 0.0, 1.0);
  const double ratio = static_cast<double>(budget) / std::max<size_t>(1, started_with);
  return static_cast<size_t>(started_with * std::pow(ratio, share) + 0.5);
}

}  // namespace pliant
