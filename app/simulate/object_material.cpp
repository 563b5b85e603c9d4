#include "app/simulate/object_material.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/import/physgaussian_config.h"
#include "app/simulate/simulate_stage.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace {

constexpr MaterialConstant kConstants[] = {
    {"viscosity_time", &Material::viscosity_time, "Kelvin-Voigt damping: stress of strain + this * strain rate [s]"},
    {"yield_stress", &Material::yield_stress, "Uniaxial yield stress; metal, foam, plasticine [Pa]"},
    {"hardening", &Material::hardening,
     "Hardening per unit of plastic strain; metal, plasticine (negative: softening) [Pa]"},
    {"plastic_viscosity", &Material::plastic_viscosity, "Viscosity of plastic flow; foam [Pa s]"},
    {"friction_angle", &Material::friction_angle, "Angle of internal friction; sand [degrees]"},
    {"critical_compression", &Material::critical_compression, "Largest elastic compression; snow"},
    {"critical_stretch", &Material::critical_stretch, "Largest elastic stretch; snow"},
    {"compaction_hardening", &Material::compaction_hardening, "Hardening by compaction xi; snow"},
    {"bulk_modulus", &Material::bulk_modulus, "Bulk modulus; fluid; 0 = of E and nu [Pa]"},
    {"pressure_exponent", &Material::pressure_exponent, "gamma of p = K / gamma (J^-gamma - 1); fluid"},
    {"dynamic_viscosity", &Material::dynamic_viscosity, "Viscosity; fluid [Pa s]"},
    {"branch_shear", &Material::branch_shear, "Shear modulus of the relaxing branch; viscoelastic [Pa]"},
    {"branch_lambda", &Material::branch_lambda, "First Lame parameter of the relaxing branch; viscoelastic [Pa]"},
    {"branch_viscosity", &Material::branch_viscosity, "Viscosity of the relaxing branch; viscoelastic [Pa s]"},
};

Law parse_law(const std::string& name) {
  const std::vector<std::string> names = law_names();
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end())
    throw usage_error("material", "law", "'" + name + "' is unknown",
                      "did you mean '" + nearest_name(name, names) + "'?");
  return static_cast<Law>(at - names.begin());
}

void set_constant(const std::string& name, double value, Material& material) {
  std::vector<std::string> names;
  for (const MaterialConstant& constant : kConstants) {
    if (name == constant.name) {
      material.*constant.value = value;
      return;
    }
    names.push_back(constant.name);
  }
  throw usage_error("material", "constants." + name, "is unknown", "did you mean '" + nearest_name(name, names) + "'?");
}

}  // namespace

std::span<const MaterialConstant> material_constants() { return kConstants; }

ObjectMaterial check_material(const Scene& scene, const MaterialValues& command_line, bool young_is_fitted) {
  const MaterialValues& file = scene.settings.material;
  const auto value = [](const std::optional<double>& first, const std::optional<double>& second) {
    return first ? first : second;
  };
  const auto poisson = value(command_line.poisson, file.poisson), density = value(command_line.density, file.density);
  auto young = value(command_line.young, file.young);
  if (!young && young_is_fitted) young = kUnknownYoung;
  std::string missing;
  if (!young) missing += " --young";
  if (!poisson) missing += " --poisson";
  if (!density) missing += " --density";
  if (!missing.empty())
    throw usage_error("material", missing.substr(1), "is not known for this scene",
                      "give --young E[Pa] --poisson NU --density RHO[kg/m^3], or \"material\" in scene.json");
  validate_material("material", *young, *poisson, *density);

  ObjectMaterial out{*young, *poisson, *density, {}};
  const std::string& law = command_line.law.empty() ? file.law : command_line.law;
  if (!law.empty()) out.material.law = parse_law(law);
  for (const auto& [name, constant] : file.constants) set_constant(name, constant, out.material);
  for (const auto& [name, constant] : command_line.constants) set_constant(name, constant, out.material);
  validate_material("material", out.material);
  return out;
}

ObjectMaterial check_material(const Scene& scene, const SimulateStage& stage) {
  if (stage.physgaussian.empty()) return check_material(scene, stage.material);
  const PhysGaussianConfig config = read_physgaussian_config(stage.physgaussian);
  return {config.young, config.poisson, config.density, {}};
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
