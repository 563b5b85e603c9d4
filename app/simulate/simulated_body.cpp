#include "app/simulate/simulated_body.h"

#include <nlohmann/json.hpp>

#include "app/import/interactions.h"
#include "fitting/fields/uniform_field.h"

namespace pliant {
using nlohmann::json;

std::vector<Interaction> pins_of(const std::string& pinned_json, const Scene& scene) {
  std::vector<Interaction> pins;
  for (const json& row : json::parse(pinned_json)) {
    Interaction pin;
    pin.type = InteractionType::kPin;
    pin.region = parse_region(row, {scene.metres_per_unit, scene.up}, "particles.h5").scaled(scene.metres_per_unit);
    pins.push_back(pin);
  }
  return pins;
}

ObjectTip tip_of(const SimulatedBody& body, const Scene& scene) {
  std::vector<Region> pins;
  for (const Interaction& pin : pins_of(body.file.pinned_json, scene))
    pins.push_back(pin.region.scaled(1 / scene.metres_per_unit));
  return tip_of(body.file, pins, scene.up);
}

GridKind grid_kind(const std::string& solver) {
  if (solver == "eulerian") return GridKind::kEulerian;
  return solver == "lagrangian" ? GridKind::kLagrangian : GridKind::kAutomatic;
}

ElasticSamples solid_material(const ParticleFile& file, const ObjectMaterial& material) {
  return uniform_field(file.solid_position.size(), material.young, material.poisson, material.density);
}

SimulatedBody make_body(ParticleFile file, const Scene& scene, const ElasticSamples& solid, const Material& material) {
  SimulatedBody body;
  body.file = std::move(file);
  ElasticSamples simulated;
  for (size_t s = 0; s < body.file.solid_position.size(); ++s) {
    if (body.file.solid_driver[s] < 0) continue;
    body.samples.position.push_back(body.file.solid_position[s]);
    body.samples.volume.push_back(body.file.solid_volume[s]);
    body.drivers.sample_driver.push_back(body.file.solid_driver[s]);
    simulated.young.push_back(solid.young[s]);
    simulated.poisson.push_back(solid.poisson[s]);
    simulated.density.push_back(solid.density[s]);
    if (!solid.branch.empty()) simulated.branch.push_back(solid.branch[s]);
  }
  body.drivers.position = body.file.driving_position;
  body.drivers.volume = body.file.driving_volume;
  body.drivers.thickness = body.file.driving_thickness;
  body.drivers.rod = body.file.driving_rod;
  body.drivers.cell_size = body.file.cell_size;
  body.particles = make_particles<float>(body.drivers, body.samples, simulated, scene.metres_per_unit);
  body.particles.links = body.file.driving_links;
  give_material(body.drivers, material, body.particles);
  if (!simulated.branch.empty())
    give_branches(branches_of(body.drivers, body.samples, simulated.branch), material, body.particles);
  body.space.scale = scene.metres_per_unit;
  return body;
}

}  // namespace pliant
