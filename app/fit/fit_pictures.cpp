#include "app/fit/fit_pictures.h"

#include <algorithm>
#include <cmath>

#include "app/report/chart.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

float luminance(const ImageF& picture, int x, int y) {
  return 0.3f * picture(x, y, 0) + 0.6f * picture(x, y, 1) + 0.1f * picture(x, y, 2);
}

}  // namespace

ImageF picture_of_drivers(const FitScene& fit, const std::vector<double>& value, double low, double high,
                          const std::string& label) {
  const DrawnObject<float>& drawn = *fit.drawn;
  CHECK(value.size() == drawn.drivers.size() && low > 0);
  if (high < 1.02 * low) {
    const double middle = std::sqrt(low * high);
    low = middle / 1.6;
    high = middle * 1.6;
  }
  // Blended logarithm and share of Gaussians that follow drivers.
  const size_t background = drawn.background.size();
  const CloudOf<float> all = drawn.at(initial_state(fit.body.particles));
  std::vector<float> features(2 * all.size(), 0.0f);
  for (size_t g = 0; g < drawn.object.size(); ++g) {
    double sum = 0, total = 0;
    for (int k = 0; k < Binding::kCount; ++k) {
      const size_t slot = g * Binding::kCount + k;
      const int driver = drawn.binding.driver[slot];
      if (driver < 0) break;
      sum += drawn.binding.weight[slot] * std::log(value[driver]);
      total += drawn.binding.weight[slot];
    }
    if (!(total > 0)) continue;
    features[2 * (background + g)] = 1;
    features[2 * (background + g) + 1] = static_cast<float>(sum / total);
  }
  const ImageF shares = render(all, fit.video.camera, drawn.render, features, 2).features;
  const ImageF bar = draw_log_bar(low, high, label, fit.still.width);
  ImageF out(fit.still.width, fit.still.height + bar.height, 3);
  for (int y = 0; y < fit.still.height; ++y)
    for (int x = 0; x < fit.still.width; ++x) {
      const float share = std::clamp(shares(x, y, 0), 0.0f, 1.0f),
                  light = std::clamp(luminance(fit.still, x, y), 0.0f, 1.0f);
      const double at =
          share > 1e-3f ? (shares(x, y, 1) / shares(x, y, 0) - std::log(low)) / (std::log(high) - std::log(low)) : 0;
      const Vec3f color = map_color(at) * (0.75f + 0.25f * light);
      for (int c = 0; c < 3; ++c) out(x, y, c) = share * color[c] + (1 - share) * (0.35f + 0.6f * light);
    }
  paste(out, bar, 0, fit.still.height);
  return out;
}

}  // namespace pliant
