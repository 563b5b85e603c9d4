#include "gaussians/reconstruct/adam_rows.h"

#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"

namespace pliant {

void adam_rows(std::span<float> parameter, std::span<const float> gradient, std::span<const float> rates, long step,
               Moments& moments) {
  constexpr float kBeta1 = 0.9f, kBeta2 = 0.999f, kEpsilon = 1e-15f;
  CHECK(gradient.size() == parameter.size() && moments.first.size() == parameter.size());
  if (parameter.empty()) return;
  const double t = static_cast<double>(step);
  const float first_scale = static_cast<float>(1.0 / (1.0 - std::pow(double(kBeta1), t)));
  const float second_scale = static_cast<float>(1.0 / std::sqrt(1.0 - std::pow(double(kBeta2), t)));
  const std::ptrdiff_t width = static_cast<std::ptrdiff_t>(rates.size()), rows = parameter.size() / width;
  const std::ptrdiff_t chunk = std::max<std::ptrdiff_t>(1, 16384 / width);
  parallel_for((rows + chunk - 1) / chunk, [&](std::ptrdiff_t c) {
    const std::ptrdiff_t begin = c * chunk * width, end = std::min(rows, (c + 1) * chunk) * width;
    for (std::ptrdiff_t row = begin; row < end; row += width) {
      float* x = parameter.data() + row;
      float* m = moments.first.data() + row;
      float* v = moments.second.data() + row;
      const float* g = gradient.data() + row;
      for (std::ptrdiff_t k = 0; k < width; ++k) {
        m[k] = kBeta1 * m[k] + (1 - kBeta1) * g[k];
        v[k] = kBeta2 * v[k] + (1 - kBeta2) * g[k] * g[k];
        x[k] -= rates[k] * first_scale * m[k] / (std::sqrt(v[k]) * second_scale + kEpsilon);
      }
    }
  });
}

}  // namespace pliant
