// Largest differences between two splat files, Gaussian by Gaussian, and the PSNR of their pictures.
// Usage: formats_study A B [--turned]   (--turned: B has the axes x right, y up, z back)

#include <cstdio>
#include <nlohmann/json.hpp>

#include "gaussians/base/orbit.h"
#include "gaussians/io/scene/up_direction.h"
#include "gaussians/io/splats/half_turn.h"
#include "gaussians/io/splats/splats.h"
#include "gaussians/render/render.h"

using namespace pliant;

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) return std::fprintf(stderr, "usage: formats_study A B [--turned]\n"), 2;
  GaussianCloud a = read_splats(argv[1]), b = read_splats(argv[2]);
  if (argc == 4) turn_half(b, 0);
  nlohmann::json out = {{"gaussians", {a.size(), b.size()}}, {"sh_degree", {a.sh_degree, b.sh_degree}}};
  if (a.size() == b.size()) {
    double position = 0, log_scale = 0, opacity = 0, colour = 0, harmonics = 0, angle = 0;
    const int sh = 3 * std::min(a.sh_count(), b.sh_count());
    for (size_t i = 0; i < a.size(); ++i) {
      position = std::max<double>(position, (a.position[i] - b.position[i]).cwiseAbs().maxCoeff());
      log_scale = std::max<double>(log_scale, (a.log_scale[i] - b.log_scale[i]).cwiseAbs().maxCoeff());
      opacity = std::max<double>(opacity, std::abs(sigmoid(a.opacity_logit[i]) - sigmoid(b.opacity_logit[i])));
      const double cosine =
          std::abs(a.rotation[i].cast<double>().normalized().dot(b.rotation[i].cast<double>().normalized()));
      angle = std::max(angle, 2 * std::acos(std::min(cosine, 1.0)));
      for (int k = 0; k < sh; ++k) {
        double& largest = k < 3 ? colour : harmonics;
        largest = std::max<double>(largest, std::abs(a.sh_of(i)[k] - b.sh_of(i)[k]));
      }
    }
    out["largest"] = {{"position", position}, {"log_scale", log_scale}, {"opacity", opacity},
                      {"f_dc", colour},       {"f_rest", harmonics},    {"radians", angle}};
  }
  OrbitOptions options;
  options.views = 3;
  options.width = 400;
  options.height = 300;
  for (const Camera& camera : orbit_cameras(options, a, up_of_cloud(a).up)) {
    const ImageF x = render(a, camera, {}).color, y = render(b, camera, {}).color;
    double sum = 0;
    for (size_t k = 0; k < x.data.size(); ++k) sum += std::pow(x.data[k] - y.data[k], 2);
    out["psnr"].push_back(sum > 0 ? nlohmann::json(-10 * std::log10(sum / static_cast<double>(x.data.size())))
                                  : nlohmann::json("equal"));
  }
  std::printf("%s\n", out.dump().c_str());
}
