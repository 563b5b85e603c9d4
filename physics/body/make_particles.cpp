#include "physics/body/make_particles.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "gaussians/base/error.h"

namespace pliant {
ElasticSamples ElasticSamples::homogeneous(size_t count, double young, double poisson, double density) {
  validate_material("material", young, poisson, density);
  return {std::vector<float>(count, static_cast<float>(young)), std::vector<float>(count, static_cast<float>(poisson)),
          std::vector<float>(count, static_cast<float>(density))};
}

ElasticSamples ElasticSamples::select(std::span<const int> indices) const {
  ElasticSamples out;
  for (const int i : indices) {
    CHECK(i >= 0 && static_cast<size_t>(i) < size());
    out.young.push_back(young[i]);
    out.poisson.push_back(poisson[i]);
    out.density.push_back(density[i]);
    if (!branch.empty()) out.branch.push_back(branch[i]);
  }
  return out;
}

void validate_material(const std::string& where, const ElasticSamples& material) {
  if (material.poisson.size() != material.size() || material.density.size() != material.size())
    throw usage_error(where, "", "young, poisson and density differ in length", "give one value each per sample");
  for (size_t i = 0; i < material.size(); ++i)
    validate_material(where, material.young[i], material.poisson[i], material.density[i]);
}

ThinFactors thin_factors(const DrivingParticles& drivers, size_t driver) {
  if (drivers.thickness.empty()) return {};
  const double full = kThinCells * drivers.cell_size, t = drivers.thickness[driver];
  if (!(t > 0 && t < full)) return {};
  const double r = std::max(t / full, kThinnestPart), area = drivers.rod[driver] ? r * r : r;
  return {area, area * r, area * r * r};
}

template <class T>
BasicParticles<T> make_particles(const DrivingParticles& drivers, const SolidSamples& samples,
                                 const ElasticSamples& material, double metres_per_unit) {
  validate_material("material", material);
  if (!(metres_per_unit > 0) || !std::isfinite(metres_per_unit))
    throw usage_error("scene", "metres_per_unit", "is " + std::to_string(metres_per_unit) + ", must be positive",
                      "give the size of a scene unit in meters");
  if (material.size() != samples.size() || drivers.sample_driver.size() != samples.size())
    throw usage_error(
        "material", "",
        "has " + std::to_string(material.size()) + " values for " + std::to_string(samples.size()) + " samples",
        "use the material of these samples");
  const size_t n = drivers.size();
  const double s = metres_per_unit, s3 = s * s * s;
  std::vector<double> volume(n), mass(n), log_young(n), poisson(n);
  for (size_t k = 0; k < samples.size(); ++k) {
    const int d = drivers.sample_driver[k];
    CHECK(d >= 0 && static_cast<size_t>(d) < n);
    const double v = samples.volume[k];
    volume[d] += v;
    mass[d] += v * material.density[k];
    log_young[d] += v * std::log(static_cast<double>(material.young[k]));
    poisson[d] += v * material.poisson[k];
  }
  BasicParticles<T> out;
  out.cell_size = static_cast<T>(drivers.cell_size * s);
  for (size_t d = 0; d < n; ++d) {
    CHECK_MSG(volume[d] > 0, "driving particle without volume");
    const ThinFactors thin = thin_factors(drivers, d);
    out.position.push_back((drivers.position[d].cast<double>() * s).cast<T>());
    out.volume.push_back(static_cast<T>(volume[d] / thin.area * s3));
    out.mass.push_back(static_cast<T>(mass[d] * s3));
    out.young.push_back(static_cast<T>(std::exp(log_young[d] / volume[d]) * thin.stiffness));
    out.poisson.push_back(static_cast<T>(poisson[d] / volume[d]));
  }
  return out;
}

namespace {

/// Whether a law has constants in pascal beside E.
bool has_own_moduli(Law law) {
  return law == Law::kMetal || law == Law::kPlasticine || law == Law::kFoam || law == Law::kFluid ||
         law == Law::kViscoelastic;
}

Material thinned(Material m, const ThinFactors& thin) {
  m.yield_stress *= thin.strength;
  for (double Material::*constant :
       {&Material::hardening, &Material::plastic_viscosity, &Material::bulk_modulus, &Material::dynamic_viscosity,
        &Material::branch_shear, &Material::branch_lambda, &Material::branch_viscosity})
    m.*constant *= thin.stiffness;
  return m;
}

}  // namespace

void give_material(const DrivingParticles& drivers, const Material& common, Particles& particles) {
  constexpr double kSteps = 1000;  // per natural logarithm of the thickness; there are 3000 of sheets and 3000 of rods
  particles.materials = {common};
  particles.material_index.clear();
  if (!has_own_moduli(common.law)) return;
  std::map<std::pair<bool, long>, uint16_t> number;
  std::vector<uint16_t> index(particles.size(), 0);
  for (size_t d = 0; d < particles.size(); ++d) {
    const ThinFactors thin = thin_factors(drivers, d);
    if (thin.area == 1) continue;
    const long step = std::lround(kSteps * std::log(thin.stiffness / thin.strength));
    const auto [at, added] =
        number.insert({{drivers.rod[d] != 0, step}, static_cast<uint16_t>(particles.materials.size())});
    if (added) particles.materials.push_back(thinned(common, thin));
    index[d] = at->second;
  }
  if (!number.empty()) particles.material_index = std::move(index);
}

std::vector<RelaxingBranch> branches_of(const DrivingParticles& drivers, const SolidSamples& samples,
                                        const std::vector<RelaxingBranch>& branch) {
  CHECK(branch.size() == samples.size() && drivers.sample_driver.size() == samples.size());
  std::vector<float> volume(drivers.size());
  for (size_t k = 0; k < samples.size(); ++k) volume[drivers.sample_driver[k]] += samples.volume[k];
  std::vector<RelaxingBranch> out(drivers.size());
  for (size_t k = 0; k < samples.size(); ++k) {
    const int d = drivers.sample_driver[k];
    const float share = static_cast<float>(thin_factors(drivers, d).stiffness) * samples.volume[k] / volume[d];
    out[d].shear += share * branch[k].shear;
    out[d].lambda += share * branch[k].lambda;
    out[d].viscosity += share * branch[k].viscosity;
  }
  return out;
}

void give_branches(const std::vector<RelaxingBranch>& branch, const Material& common, Particles& particles) {
  const size_t n = particles.size();
  CHECK(branch.size() == n);
  if (n > size_t{UINT16_MAX} + 1)
    throw usage_error("material", "branch", "varies over " + std::to_string(n) + " driving particles",
                      "use at most 65536 of them");
  particles.materials.assign(n, common);
  particles.material_index.resize(n);
  for (size_t i = 0; i < n; ++i) {
    Material& m = particles.materials[i];
    m.law = Law::kViscoelastic;
    m.branch_shear = branch[i].shear;
    m.branch_lambda = branch[i].lambda;
    m.branch_viscosity = branch[i].viscosity;
    validate_material("material", m);
    particles.material_index[i] = static_cast<uint16_t>(i);
  }
}

template BasicParticles<float> make_particles(const DrivingParticles&, const SolidSamples&, const ElasticSamples&,
                                              double);
template BasicParticles<double> make_particles(const DrivingParticles&, const SolidSamples&, const ElasticSamples&,
                                               double);

}  // namespace pliant
