#include "app/fit/fit_outcome.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace pliant {
using nlohmann::json;

namespace {

/// E of the material at the drivers.  That of the particles is lower or higher where parts thinner than the cells bend.
std::vector<double> fitted_young(const FitScene& scene, const MaterialFit& fit) {
  const Particles& before = scene.body.particles;
  std::vector<double> young;
  for (size_t i = 0; i < before.size(); ++i)
    young.push_back(scene.start.driver_young[i] * fit.young[i] / before.young[i]);
  return young;
}

}  // namespace

MaterialFile fitted_material(const FitScene& scene, const Particles& fitted, double rest_factor,
                             const std::string& source) {
  const ElasticSamples& start = scene.start.solid;
  MaterialFile out{start.young, start.poisson, start.density, source, {}, {}};
  out.branch = start.branch;
  // Factors of E of the particles hold for their samples too, whose E does not know of thin parts' equivalent
  // stiffness.
  const Particles& before = scene.body.particles;
  for (size_t s = 0; s < out.young.size(); ++s) {
    const int driver = scene.body.file.solid_driver[s];
    out.young[s] =
        static_cast<float>(out.young[s] * (driver >= 0 ? fitted.young[driver] / before.young[driver] : rest_factor));
    if (driver < 0) continue;
    if (fitted.poisson[driver] != before.poisson[driver]) out.poisson[s] = fitted.poisson[driver];
    out.density[s] *= fitted.mass[driver] / before.mass[driver];
  }
  return out;
}

std::string source_of(const StartMaterial& start, const MaterialFit& fit, MaterialKind kind) {
  const auto name = [](MaterialKind of) {
    switch (of) {
      case MaterialKind::kUniform:
        return "homogeneous";
      case MaterialKind::kParts:
        return "by parts";
      case MaterialKind::kSmooth:
        return "a smooth field";
      case MaterialKind::kTriplanes:
        return "triplanes";
      case MaterialKind::kKan:
        return "a KAN";
    }
    return "";
  };
  const MaterialKind found = fit.field_left ? MaterialKind::kUniform : kind;
  if (!start.given) return std::string(name(found)) + ", fitted to the reference video";
  const std::string factors = found == MaterialKind::kUniform ? "one factor" : fmt::format("factors ({})", name(found));
  return "the initial material times " + factors + ", fitted to the reference video";
}

VelocityFile fitted_velocity(const FitScene& fit, const VibrationFit& found, const Dissipation& losses) {
  VelocityFile out;
  out.position = fit.body.file.driving_position;
  out.velocity = found.start.v;
  out.F = found.start.F;
  out.C = found.start.C;
  for (size_t i = 0; i < found.start.size(); ++i)
    out.displacement.push_back(found.start.x[i] - fit.body.particles.position[i]);
  out.time = fit.video.start + found.time;
  out.damping_time = found.damping_time;
  out.source = "fitted to the reference video";
  if (losses.whole > 0) out.whole_damping_time = 1 / losses.whole;
  return out;
}

FitFindings findings_of(const FitScene& scene, const MaterialFit& fit) {
  FitFindings out;
  const VibrationFit &constant = fit.homogeneous, &found = fit.found;
  out.young = scene.start.young * std::pow(10.0, found.log10_factor);
  out.young_of_driver = fitted_young(scene, fit);
  out.sigma_of_driver = fit.sigma;
  for (const double factor : constant.search.log10_factor)
    out.search_young.push_back(scene.start.young * std::pow(10.0, factor));
  out.search_unexplained = constant.search.unexplained;
  for (const FitStep& step : fit.steps)
    out.refinements.push_back(
        {step.name, step.by_gradients ? "loss of the compared frames" : "track RMSE [px]", step.loss});
  return out;
}

FitEvidence evidence_of(const FitScene& scene, const MaterialFit& fit, const MaterialFitOptions& options,
                        double young) {
  const VibrationFit& found = fit.found;
  FitEvidence out;
  out.stated_fps = scene.video.source_fps;
  out.young = young;
  out.log10_sigma = found.log10_sigma;
  out.rms = found.rms;
  out.rms_still = found.rms_rest;
  out.periods = fit.homogeneous.search.periods;
  out.damping_time = found.damping_time;
  out.damping_low = found.damping_time_low;
  out.damping_high = found.damping_time_high;
  out.losses = fit.losses;
  const double seconds = (scene.used - fit.homogeneous.search.first_frame) / scene.video.fps;
  out.strongest_hz = seconds > 0 ? fit.homogeneous.search.periods / seconds : 0;
  for (size_t k = 0; k < fit.homogeneous.candidate_factor.size(); ++k) {
    out.rival_factor.push_back(std::pow(10.0, fit.homogeneous.candidate_factor[k] - fit.homogeneous.log10_factor));
    out.rival_rms.push_back(fit.homogeneous.candidate_rms[k] * found.rms / std::max(fit.homogeneous.rms, 1e-12));
  }
  const std::vector<double>& after = fit.homogeneous.candidate_rms;
  if (!after.empty()) out.refined = static_cast<int>(std::ranges::min_element(after) - after.begin());
  const ModalSearch& search = fit.homogeneous.search;
  for (const FitView* view : scene.views()) out.displaced = std::max(out.displaced, view->displaced);
  out.start = scene.video.start + search.first_frame / scene.video.fps;
  out.start_late = search.late;
  out.pushed_away = search.away;
  out.search_end = search.end;
  out.searched = !search.log10_factor.empty();
  out.one_stiffness = options.kind == MaterialKind::kUniform;
  out.start_given = scene.start.given;
  out.poisson_fitted = options.poisson;
  out.density_fitted = options.density;
  out.errors_known = !fit.sigma.empty();
  out.by_gradients = !fit.iterations.empty();
  out.field_left = fit.field_left;
  double whole = 0, undecided = 0;
  for (size_t i = 0; i < fit.sigma.size(); ++i) {
    const double volume = scene.body.particles.volume[i];
    whole += volume;
    undecided += fit.determined(i) ? 0 : volume;
  }
  out.undecided_volume = whole > 0 ? undecided / whole : 0;
  return out;
}

void add_constants_beside(bool poisson, bool density, const FitScene& scene, const MaterialFile& material,
                          json& result) {
  const ParticleFile& file = scene.body.file;
  const auto add = [&](const std::string& name, const std::string& unit, const std::vector<float>& values) {
    double sum = 0, volume = 0, low = INFINITY, high = 0;
    for (size_t s = 0; s < values.size(); ++s) {
      if (file.solid_driver[s] < 0) continue;
      sum += double(file.solid_volume[s]) * values[s];
      volume += file.solid_volume[s];
      low = std::min<double>(low, values[s]);
      high = std::max<double>(high, values[s]);
    }
    result[name + unit] = sum / volume;
    if (high > low * (1 + 1e-5)) result[name + "_range" + unit] = {low, high};
  };
  if (poisson) add("poisson", "", material.poisson);
  if (density) add("density", "_kg_m3", material.density);
}

json curve_to_json(const ModalSearch& search) {
  json rows = json::array();
  for (size_t i = 0; i < search.log10_factor.size(); ++i)
    rows.push_back({search.log10_factor[i], search.unexplained[i]});
  return rows;
}

json steps_to_json(const std::vector<FitStep>& steps) {
  json rows = json::array();
  for (const FitStep& step : steps) {
    rows.push_back({{"name", step.name}, {"rms_px", step.rms}, {"seconds", step.seconds}});
    if (!step.stopped_by.empty())
      rows.back().update({{"converged", step.converged}, {"stopped_by", step.stopped_by}, {"loss", step.loss}});
  }
  return rows;
}

json iterations_to_json(const std::vector<GradientFitRow>& rows) {
  json out = json::array();
  for (const GradientFitRow& row : rows)
    out.push_back({{"frames", row.frames},
                   {"loss", row.loss},
                   {"rollout_s", row.rollout_seconds},
                   {"frames_s", row.frames_seconds},
                   {"reverse_s", row.reverse_seconds},
                   {"field_s", row.field_seconds}});
  return out;
}

}  // namespace pliant
