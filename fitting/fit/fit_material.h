#pragma once

#include "fitting/fields/smooth_field.h"
#include "fitting/fit/fit_vibration.h"

namespace pliant {

enum class MaterialKind { kUniform, kParts, kSmooth };

struct MaterialFitOptions {
  VibrationFitOptions vibration;     ///< its field is this fit's
  MaterialKind kind = MaterialKind::kUniform;
  std::vector<uint32_t> part;        ///< [N] of the particles, from 0 without gaps, for kParts
  double part_sigma = 0.5;           ///< decades by which a part is expected to differ from the common factor
  SmoothFieldOptions smooth;         ///< for kSmooth, in metres
};

/// What a stage of a fit brought.
struct FitStep {
  std::string name;
  double rms = 0;      ///< of the tracks, in their unit
  double seconds = 0;
};

/// E(x) and the motion that explains the tracks.
struct MaterialFit {
  VibrationFit homogeneous;    ///< the best constant
  VibrationFit found;          ///< with the field; its log10_factor is against the particles that the fit was given
  std::vector<double> young;   ///< [N] Pa
  std::vector<double> sigma;   ///< [N] decades, one standard deviation of log10 E
  double prior_sigma = 0;      ///< [decades] of a particle's E before any track was seen
  Particles particles;         ///< with that E
  std::vector<FitStep> steps;

  /// Whether the tracks, rather than the prior, decide the E of a particle: its variance fell to a quarter.
  bool determined(size_t particle) const { return sigma[particle] < 0.5 * prior_sigma; }
};

/// The homogeneous fit (fit_vibration.h), then once more from there with a field of factors of E.
MaterialFit fit_material(const MaterialFitOptions& options, const Particles& particles, const std::vector<Interaction>& interactions,
                         const TrackLoss<float>& tracks, double fps, const std::function<void(const std::string&)>& progress = {});

}  // namespace pliant
