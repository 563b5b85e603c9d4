#include "fitting/fit/fit_material.h"

#include <cmath>

#include "fitting/fields/part_field.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr double kDecade = 2.302585092994046;

std::shared_ptr<const Field> field_of(const MaterialFitOptions& options, const Particles& particles) {
  switch (options.kind) {
    case MaterialKind::kUniform: return nullptr;
    case MaterialKind::kParts:
      CHECK(options.part.size() == particles.size());
      return std::make_shared<PartField>(options.part, 1);
    case MaterialKind::kSmooth: return std::make_shared<SmoothField>(options.smooth, particles.position);
  }
  return nullptr;
}

}  // namespace

MaterialFit fit_material(const MaterialFitOptions& options, const Particles& particles, const std::vector<Interaction>& interactions,
                         const TrackLoss<float>& tracks, double fps, const std::function<void(const std::string&)>& progress) {
  MaterialFit fit;
  VibrationFitOptions vibration = options.vibration;
  vibration.field = nullptr;
  fit.homogeneous = fit.found = fit_vibration(vibration, particles, interactions, tracks, fps, progress);
  fit.particles = fit.found.fitted(particles);
  fit.sigma = fit.found.young_sigma, fit.prior_sigma = INFINITY;
  fit.steps = {{"search", fit.homogeneous.rms_search, 0}, {"homogeneous", fit.homogeneous.rms, fit.homogeneous.seconds}};
  if (const auto field = field_of(options, particles)) {
    vibration.field = field, vibration.candidates = 1;
    vibration.field_sigma = options.kind == MaterialKind::kParts ? options.part_sigma * kDecade : 1;
    vibration.search.low = -0.3, vibration.search.high = 0.3;
    vibration.search.first = fit.homogeneous.first_frame / fps;
    const Particles base = fit.particles;
    vibration.known_modes = fit.homogeneous.modes.stiffer(std::pow(10.0, fit.homogeneous.log10_factor));
    fit.found = fit_vibration(vibration, base, interactions, tracks, fps, progress);
    fit.steps.push_back({"field", fit.found.rms, fit.found.seconds});
    fit.particles = fit.found.fitted(base, field.get());
    fit.found.log10_factor += fit.homogeneous.log10_factor;
    fit.sigma = fit.found.young_sigma;
    fit.prior_sigma = options.kind == MaterialKind::kParts ? options.part_sigma : options.smooth.sigma / kDecade;
  }
  fit.young.assign(fit.particles.young.begin(), fit.particles.young.end());
  return fit;
}

}  // namespace pliant
