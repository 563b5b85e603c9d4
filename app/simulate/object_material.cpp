#include "app/simulate/object_material.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/import/physgaussian_config.h"
#include "app/simulate/simulate_stage.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace {

constexpr double kUnusedPoisson = 0.3, kUnusedDensity = 1000;  // where files say these

const std::vector<MaterialConstant> kConstants = {
    {"viscosity_time",
     &Material::viscosity_time,
     "Kelvin-Voigt damping: stress from strain + this * strain rate; all but fluid [s]",
     {Law::kFixedCorotated, Law::kNeoHookean, Law::kHencky, Law::kMetal, Law::kSand, Law::kSnow, Law::kFoam,
      Law::kPlasticine, Law::kViscoelastic}},
    {"yield_stress",
     &Material::yield_stress,
     "Uniaxial yield stress; metal, foam, plasticine [Pa]",
     {Law::kMetal, Law::kFoam, Law::kPlasticine}},
    {"hardening",
     &Material::hardening,
     "Hardening per unit of plastic strain; metal, plasticine (negative: softening) [Pa]",
     {Law::kMetal, Law::kPlasticine}},
    {"plastic_viscosity", &Material::plastic_viscosity, "Viscosity of plastic flow; foam [Pa s]", {Law::kFoam}},
    {"friction_angle", &Material::friction_angle, "Angle of internal friction; sand [degrees]", {Law::kSand}},
    {"critical_compression", &Material::critical_compression, "Largest elastic compression; snow", {Law::kSnow}},
    {"critical_stretch", &Material::critical_stretch, "Largest elastic stretch; snow", {Law::kSnow}},
    {"compaction_hardening", &Material::compaction_hardening, "Compaction hardening xi; snow", {Law::kSnow}},
    {"bulk_modulus", &Material::bulk_modulus, "Bulk modulus; fluid; 0 = from E and nu [Pa]", {Law::kFluid}},
    {"pressure_exponent", &Material::pressure_exponent, "gamma of p = K / gamma (J^-gamma - 1); fluid", {Law::kFluid}},
    {"dynamic_viscosity", &Material::dynamic_viscosity, "Viscosity; fluid [Pa s]", {Law::kFluid}},
    {"branch_shear",
     &Material::branch_shear,
     "Shear modulus of the Maxwell branch; viscoelastic [Pa]",
     {Law::kViscoelastic}},
    {"branch_lambda",
     &Material::branch_lambda,
     "First Lame parameter of the Maxwell branch; viscoelastic [Pa]",
     {Law::kViscoelastic}},
    {"branch_viscosity",
     &Material::branch_viscosity,
     "Viscosity of the Maxwell branch; viscoelastic [Pa s]",
     {Law::kViscoelastic}},
};

/// `where` is how the user writes constants: "--" or "constants.".
void set_constant(const std::string& where, const std::string& name, double value, Law law, Material& material) {
  std::vector<std::string> names;
  for (const MaterialConstant& constant : kConstants) {
    names.push_back(constant.name);
    if (name != constant.name) continue;
    if (!constant.laws.empty() && std::count(constant.laws.begin(), constant.laws.end(), law) == 0) {
      std::string option = name;
      if (where == "--") std::replace(option.begin(), option.end(), '_', '-');
      throw usage_error("material", where + option, std::string("does nothing for the law ") + law_name(law),
                        std::string("leave it out, or choose ") + law_name(constant.laws[0]));
    }
    material.*constant.value = value;
    return;
  }
  throw usage_error("material", where + name, "is unknown", "did you mean '" + nearest_name(name, names) + "'?");
}

}  // namespace

Law parse_law(const std::string& name) {
  const std::vector<std::string> names = law_names();
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end())
    throw usage_error("material", "law", "'" + name + "' is unknown",
                      "did you mean '" + nearest_name(name, names) + "'?");
  return static_cast<Law>(at - names.begin());
}

std::span<const MaterialConstant> material_constants() { return kConstants; }

ObjectMaterial check_material(const Scene& scene, const MaterialValues& command_line, SetBy by) {
  const MaterialValues& file = scene.settings.material;
  const auto value = [](const std::optional<double>& first, const std::optional<double>& second) {
    return first ? first : second;
  };
  auto poisson = value(command_line.poisson, file.poisson), density = value(command_line.density, file.density);
  auto young = value(command_line.young, file.young);
  if (!young && by == SetBy::kFit) young = kUnknownYoung;
  if (by == SetBy::kFields || by == SetBy::kPrediction) {
    const bool predicted = by == SetBy::kPrediction;
    for (const auto& [option, given] : {std::pair{"--young", command_line.young.has_value()},
                                        {"--poisson", command_line.poisson.has_value()},
                                        {"--density", command_line.density.has_value()}})
      if (given)
        throw usage_error("material", option,
                          std::string("does nothing: the material is that of ") +
                              (predicted ? "the prediction" : "a fit or of --material"),
                          predicted ? std::string("give ") + option + " to `pliant predict`, or --young as well"
                                    : "leave it out, or simulate without them (--no-fit)");
    young = kUnknownYoung;
    poisson = kUnusedPoisson;
    density = kUnusedDensity;
  }
  std::string missing;
  if (!young) missing += " --young";
  if (!poisson) missing += " --poisson";
  if (!density) missing += " --density";
  if (!missing.empty())
    throw usage_error("material", missing.substr(1), "unknown for this scene",
                      by == SetBy::kFit ? "give --poisson NU --density RHO[kg/m^3], \"material\" in scene.json, or run "
                                          "`pliant predict`, then `pliant fit` with --initial-material predicted"
                                        : "give --young E[Pa] --poisson NU --density RHO[kg/m^3], \"material\" in "
                                          "scene.json, or run `pliant predict` first");
  validate_material("material", *young, *poisson, *density);

  ObjectMaterial out{*young, *poisson, *density, {}};
  const std::string& law = command_line.law.empty() ? file.law : command_line.law;
  if (!law.empty()) out.material.law = parse_law(law);
  validate_poisson("material", out.material.law, *poisson);
  // Constants belong to the law that stands beside them; those of a file whose law is replaced may not count.
  const Law law_of_file = file.law.empty() ? Law::kFixedCorotated : parse_law(file.law);
  for (const auto& [name, constant] : file.constants)
    set_constant("constants.", name, constant, law_of_file, out.material);
  for (const auto& [name, constant] : command_line.constants)
    set_constant("--", name, constant, out.material.law, out.material);
  validate_material("material", out.material);
  return out;
}

ObjectMaterial check_material(const Scene& scene, const SimulateStage& stage) {
  if (stage.physgaussian.empty())
    return check_material(scene, stage.material, stage.material_file.empty() ? SetBy::kNothing : SetBy::kFields);
  const PhysGaussianConfig config = read_physgaussian_config(stage.physgaussian);
  return {config.young, config.poisson, config.density, {}};
}

void take_law(const nlohmann::json& record, MaterialValues& values) {
  values.law = record["law"];
  for (const MaterialConstant& constant : kConstants)
    if (record.contains(constant.name)) values.constants.insert({constant.name, record[constant.name]});
}

Material law_of_record(const nlohmann::json& record) {
  Material out;
  out.law = parse_law(record["law"].get<std::string>());
  for (const MaterialConstant& constant : kConstants)
    out.*constant.value = record.value(constant.name, out.*constant.value);
  return out;
}

nlohmann::json material_to_json(const ObjectMaterial& m) {
  nlohmann::json out = {
      {"young", m.young}, {"poisson", m.poisson}, {"density", m.density}, {"law", law_name(m.material.law)}};
  const Material standard;
  for (const MaterialConstant& constant : kConstants)
    if (m.material.*constant.value != standard.*constant.value) out[constant.name] = m.material.*constant.value;
  return out;
}

}  // namespace pliant
