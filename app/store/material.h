#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gaussians/base/types.h"
#include "physics/body/make_particles.h"

namespace pliant {

/// material.h5: elastic material of the solid samples of particles.h5.
struct MaterialFile {
  std::vector<float> young, poisson, density;  ///< [S] Pa, 1, kg/m^3
  std::string source;                          ///< where the values come from, a phrase
  std::vector<Vec3f> position;                 ///< [S, 3] scene units; empty: those of particles.h5 beside the file
  std::vector<float> volume;                   ///< [S] units^3; empty like `position`
  std::vector<float> log10_young_sigma = {};   ///< [S] decades, one standard deviation of log10 E; empty: not known
  std::vector<RelaxingBranch> branch = {};     ///< [S] where it varies; empty: the law and its constants do not
};

void write_material(const std::filesystem::path& file, const MaterialFile& material,
                    const std::string& provenance_json);
/// Positions and volumes that the file lacks are taken from particles.h5 beside it when that has as many samples.
/// Values must be possible: young > 0, -1 < poisson < 0.5, density > 0, branch [S, 3] (shear, lambda, viscosity) > 0.
MaterialFile read_material(const std::filesystem::path& file);

}  // namespace pliant
