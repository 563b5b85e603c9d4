#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/fit/fit_limits.h"
#include "app/store/material.h"
#include "app/store/velocity.h"
#include "fitting/fit/fit_material.h"

namespace pliant {

/// material.h5: each solid sample's E and density times its driving particle's factors, `fitted` against the body, and
/// that particle's Poisson's ratio where it was fitted; samples that are held get `rest_factor`.
MaterialFile fitted_material(const FitScene& scene, const Particles& fitted, double rest_factor,
                             const std::string& source);
/// How E(x) was found, for material.h5: by one factor, where a field was left.
std::string source_of(const StartMaterial& start, const MaterialFit& fit, MaterialKind kind);
/// velocity.h5: how the fitted motion starts.
VelocityFile fitted_velocity(const FitScene& scene, const VibrationFit& found, const Dissipation& losses);

/// What the pictures of a fit show, and what is said on how well it is determined.
FitFindings findings_of(const FitScene& scene, const MaterialFit& fit);
FitEvidence evidence_of(const FitScene& scene, const MaterialFit& fit, const MaterialFitOptions& options, double young);

/// Mean Poisson's ratio and density [kg/m^3] of what moves, by volume, and their ranges where they vary, if they were
/// fitted.
void add_constants_beside(bool poisson, bool density, const FitScene& scene, const MaterialFile& material,
                          nlohmann::json& result);
nlohmann::json curve_to_json(const ModalSearch& search);
nlohmann::json steps_to_json(const std::vector<FitStep>& steps);
nlohmann::json iterations_to_json(const std::vector<GradientFitRow>& rows);

}  // namespace pliant
