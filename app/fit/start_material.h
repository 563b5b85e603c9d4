#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/fit/fit_stage.h"
#include "app/store/particles.h"
#include "physics/body/make_particles.h"

namespace pliant {

/// The material from which a fit starts; what it varies are factors of this E(x), of which its prior expects nothing.
struct StartMaterial {
  ElasticSamples solid;  ///< of all solid samples
  Material law;
  double young = 0;                  ///< Pa, of the whole: see mean_young
  std::vector<double> driver_young;  ///< [M] Pa, of the material around each driver
  bool given = false;                ///< E(x) is that of --initial-material
};

/// --initial-material as a file: that of the run's prediction for "predicted", empty without one.  Throws
/// Error{kUsage} where nothing was predicted, or with another scale.
std::string initial_material_file(const RunDirectory& run, const Scene& scene, const FitStage& stage);

/// What sets E, nu and rho of the start: a file; nothing that counts, where there is no physics; else what is known.
SetBy start_set_by(const FitStage& stage);

/// That of in.files["initial_material"], see given_material, else the homogeneous one of command line and scene.
StartMaterial start_material(const FitInputs& in, const ParticleFile& particles, Progress* progress = nullptr);

/// [Pa] by the mean of log E over the samples that move; `young`: [S] of all samples.
double mean_young(const ParticleFile& particles, std::span<const float> young);

}  // namespace pliant
