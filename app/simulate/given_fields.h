#pragma once

#include <filesystem>
#include <string>

#include "app/run/progress.h"
#include "app/store/particles.h"
#include "physics/body/make_particles.h"
#include "physics/mpm/particles.h"

namespace pliant {

/// The material of a material.h5, or of a field that another program wrote (material_fields.h), at solid samples in
/// `positions`, scene units: row by row where it was made for these, else that of the nearest of its samples, or of any
/// where it is uniform, of which `progress` is told where these are not as many.  Throws Error{kInput} when they cannot
/// be matched, or lie elsewhere than these.
ElasticSamples given_material(const std::filesystem::path& file, const std::vector<Vec3f>& positions,
                              Progress* progress = nullptr);

/// Says which unit a material is likely in where it is too soft or too light to be one in Pa and kg/m^3; else empty.
std::string unit_doubt(const ElasticSamples& solid);

/// The start of a velocity.h5 for the driving particles: row by row where it was made for these, else what the grid
/// makes of the motion about the nearest of its points.
SimulationState given_start(const std::filesystem::path& file, const ParticleFile& particles, const Particles& body);

}  // namespace pliant
