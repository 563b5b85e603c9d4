#include "app/page/material_numbers.h"

#include <iterator>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr double Material::*kConstants[] = {
    &Material::viscosity_time,    &Material::yield_stress,         &Material::hardening,
    &Material::plastic_viscosity, &Material::friction_angle,       &Material::critical_compression,
    &Material::critical_stretch,  &Material::compaction_hardening, &Material::bulk_modulus,
    &Material::pressure_exponent, &Material::dynamic_viscosity,    &Material::branch_shear,
    &Material::branch_lambda,     &Material::branch_viscosity};
static_assert(std::size(kConstants) + 1 == kMaterialNumbers);

}  // namespace

std::vector<double> numbers_of(const Material& material) {
  std::vector<double> out = {static_cast<double>(material.law)};
  for (const auto constant : kConstants) out.push_back(material.*constant);
  return out;
}

Material material_of(std::span<const double> numbers) {
  CHECK(numbers.size() == kMaterialNumbers);
  Material out;
  out.law = static_cast<Law>(static_cast<int>(numbers[0]));
  for (size_t k = 0; k < std::size(kConstants); ++k) out.*kConstants[k] = numbers[k + 1];
  return out;
}

}  // namespace pliant
