#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <vector>

#include "gaussians/io/scene/scene.h"
#include "physics/laws/material.h"

namespace pliant {

/// A constant of a constitutive law as scene files name it; the command line writes it with dashes.
struct MaterialConstant {
  const char* name;
  double Material::*value;
  const char* description;
  std::vector<Law> laws;  ///< that use it; empty = all
};
std::span<const MaterialConstant> material_constants();

/// The law of that name; a usage error lists the names.
Law parse_law(const std::string& name);

/// The homogeneous material of an object.
struct ObjectMaterial {
  double young = 0, poisson = 0, density = 0;  ///< Pa, 1, kg/m^3
  Material material;
};

/// What sets the values of a material besides the command line and the scene file.
enum class SetBy {
  kNothing,
  kFit,        ///< E is found, or will be; kUnknownYoung where nothing tells where to start
  kFields,     ///< E, nu and rho are those of a file: what the scene file says of them does not count, and what the
               ///< command line says is a usage error
  kPrediction  ///< likewise those of a prediction
};

/// The material that simulate will use: command line over scene file.  A usage error names what is missing, unknown or
/// impossible, before any work is done.
ObjectMaterial check_material(const Scene& scene, const MaterialValues& command_line, SetBy by = SetBy::kNothing);

constexpr double kUnknownYoung = 1e5;  ///< Pa, where a fit starts that is told nothing

/// Law and constants of such a record, as if they had been typed.
void take_law(const nlohmann::json& record, MaterialValues& values);
/// Law and constants of such a record.
Material law_of_record(const nlohmann::json& record);
/// {young, poisson, density, law, constants that were changed}, for records.
nlohmann::json material_to_json(const ObjectMaterial& material);

}  // namespace pliant
