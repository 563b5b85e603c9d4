#include "gaussians/io/scene/doubtful.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "gaussians/base/error.h"
#include "gaussians/base/near_plane.h"
#include "gaussians/base/quantile.h"

namespace pliant {
namespace {

constexpr size_t kSample = 4000, kCameras = 12;  // that are looked at, evenly spread

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, value >= 1000 ? "%.0f" : "%.3g", value);
  return text;
}

/// Depths of what the cameras see.
std::vector<double> seen_depths(const GaussianCloud& cloud, const std::vector<Camera>& cameras) {
  std::vector<double> depths;
  const size_t stride = std::max<size_t>(1, cloud.size() / kSample),
               skip = std::max<size_t>(1, cameras.size() / kCameras);
  for (size_t c = 0; c < cameras.size(); c += skip)
    for (size_t i = 0; i < cloud.size(); i += stride) {
      const Camera& camera = cameras[c];
      const Eigen::Vector3d p = camera.cam_from_world * cloud.position[i].cast<double>();
      if (!(p.z() > 0)) continue;
      const double u = camera.fx * p.x() / p.z() + camera.cx, v = camera.fy * p.y() / p.z() + camera.cy;
      if (u >= 0 && v >= 0 && u < camera.width && v < camera.height) depths.push_back(p.z());
    }
  return depths;
}

/// Geometric mean of a Gaussian's standard deviations.
double size_of(const GaussianCloud& cloud, size_t i) { return std::exp(double(cloud.log_scale[i].mean())); }

}  // namespace

std::vector<std::string> doubtful_units(const std::string& where, const GaussianCloud& cloud,
                                        const std::vector<Camera>& cameras, bool orbit) {
  constexpr double kMuch = 0.05, kMost = 0.5, kCoarse = 0.1;
  std::vector<std::string> sentences;
  if (const std::vector<double> depths = seen_depths(cloud, cameras); !depths.empty()) {
    const auto near = static_cast<double>(
        std::count_if(depths.begin(), depths.end(), [](double depth) { return depth < kNearPlane; }));
    const double share = near / static_cast<double>(depths.size());
    const std::string problem = "the cameras see " + number(100 * share) + " % of the Gaussians nearer than " +
                                number(kNearPlane) + " units, and nothing nearer is rendered";
    const double factor = std::pow(10, std::ceil(std::log10(10 * kNearPlane / quantile(depths, 0.5))));
    const std::string remedy =
        "multiply splats and cameras by " + number(factor) + ": `pliant convert IN OUT --scale " + number(factor) + "`";
    if (share > kMost && !orbit) throw input_error(where, "", problem, remedy);
    if (share > kMuch) sentences.push_back(problem + ": " + remedy);
  }
  std::vector<double> sizes, largest;
  for (size_t i = 0; i < cloud.size(); i += std::max<size_t>(1, cloud.size() / kSample)) {
    sizes.push_back(size_of(cloud, i));
    largest.push_back(double(cloud.position[i].cwiseAbs().maxCoeff()));
  }
  if (!sizes.empty()) {
    const double size = quantile(sizes, 0.5), place = quantile(largest, 0.5);
    const double step = std::nextafter(static_cast<float>(place), INFINITY) - static_cast<float>(place);
    if (step > kCoarse * size)
      sentences.push_back("positions around " + number(place) + " are resolved to " + number(step) +
                          " units in single precision, and a typical Gaussian is " + number(size) +
                          " units large: move the scene to the origin before it is trained");
  }
  return sentences;
}

}  // namespace pliant
