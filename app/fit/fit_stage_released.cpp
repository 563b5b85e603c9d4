#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/fit/fit_report.h"
#include "app/import/physdreamer_fields.h"
#include "app/run/attach_scene.h"
#include "app/run/physdreamer_scene.h"
#include "app/simulate/simulate_stage.h"
#include "app/simulate/simulated_body.h"
#include "app/store/material.h"
#include "app/store/velocity.h"
#include "fitting/fields/triplane_field.h"
#include "fitting/fit/fit_material.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kYoungLow = 1;  // that its demo clamps to, in the cube's units

/// [M, channels] values of a field at points of the scene.
std::vector<double> values_at(const PhysDreamerField& stored, const PhysDreamerSpace& space,
                              const std::vector<Vec3f>& points, int threads) {
  TriplaneOptions options;
  options.channels = stored.channels;
  options.resolution = stored.resolution;
  options.features = stored.features;
  options.hidden = stored.hidden;
  options.layers = stored.layers;
  options.threads = std::max(1, threads);
  const auto [low, high] = stored.box.value_or(std::array{space.field_low, space.field_high});
  const std::vector<Vec3f> corners = {low.cast<float>(), high.cast<float>()};
  std::vector<Vec3f> inside;
  for (const Vec3f& x : points) inside.push_back(space.inside(x.cast<double>()).cast<float>());
  return make_triplane_field(options, corners)->values_at(stored.parameters, inside);
}

}  // namespace

json take_released_fields(const Context& context, const RunDirectory& run, const FitInputs& in,
                          const std::string& provenance) {
  const FitStage& stage = in.options;
  const Scene& scene = in.scene;
  const PhysDreamerFolder source = physdreamer_folder(scene).value();
  const ObjectMaterial material = check_material(scene, stage.material, SetBy::kFit);
  const ParticleFile particles = read_particles(in.files.at("particles"));
  const PhysDreamerSpace space = physdreamer_roles({}, source, scene.cloud.position).space;
  const double metres = space.scale * scene.metres_per_unit;  // of the cube's edge
  ElasticSamples solid = solid_material(particles, material);
  // Density stays, and sound takes as long through the object: E grows with the square of the length.
  const std::vector<double> raw = values_at(read_physdreamer_field(in.files.at("material_field"), 1), space,
                                            particles.solid_position, context.threads);
  double low = INFINITY, high = 0, mean = 0;
  for (size_t s = 0; s < raw.size(); ++s) {
    const double young = metres * metres *
                         std::clamp(*stage.released_young + PhysDreamerCode::kYoungStep * raw[s], kYoungLow,
                                    PhysDreamerCode::kYoungHigh);
    solid.young[s] = static_cast<float>(young);
    low = std::min(low, young);
    high = std::max(high, young);
    mean += std::log(young) / static_cast<double>(raw.size());
  }
  write_material(run / in.outputs[0], {solid.young, solid.poisson, solid.density, "released by PhysDreamer", {}, {}},
                 provenance);

  const size_t n = particles.driving_position.size();
  VelocityFile start;
  start.velocity.assign(n, Vec3f::Zero());
  start.displacement.assign(n, Vec3f::Zero());
  start.F.assign(n, Mat3f::Identity());
  start.C.assign(n, Mat3f::Zero());
  start.position = particles.driving_position;
  start.source = "released by PhysDreamer";
  double fastest = 0;
  if (in.files.count("velocity_field")) {
    const std::vector<double> v = values_at(read_physdreamer_field(in.files.at("velocity_field"), 3), space,
                                            particles.driving_position, context.threads);
    for (size_t i = 0; i < n; ++i) {
      start.velocity[i] =
          (metres * PhysDreamerCode::kSpeedStep * Vec3d(v[3 * i], v[3 * i + 1], v[3 * i + 2])).cast<float>();
      fastest = std::max<double>(fastest, start.velocity[i].norm());
    }
  }
  write_velocity(run / in.outputs[1], start, provenance);
  clear_fit_pictures(run);
  context.progress.say(fmt::format(
      "fit: published fields: E from {:.3g} to {:.3g} Pa, initial velocity up to {:.3g} m/s", low, high, fastest));
  const json result = {{"source", "released by PhysDreamer"},
                       {"young_pa", std::exp(mean)},
                       {"young_low_pa", low},
                       {"young_high_pa", high},
                       {"fastest_m_s", fastest},
                       {"edge_of_cube_m", metres}};
  write_text(run / "fit/results.json", result.dump(2) + "\n");
  return result;
}

}  // namespace pliant
