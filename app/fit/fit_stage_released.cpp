#include <fmt/format.h>

#include <algorithm>
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
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kYoungStep = 1000, kSpeedStep = 0.1;  // of the fields' outputs, in the cube's units
constexpr double kYoungLow = 1, kYoungHigh = 5e8;      // that its demo clamps to

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
  const std::vector<Vec3f> corners = {space.field_low.cast<float>(), space.field_high.cast<float>()};
  std::vector<Vec3f> inside;
  for (const Vec3f& x : points) inside.push_back(space.inside(x.cast<double>()).cast<float>());
  return make_triplane_field(options, corners)->values_at(stored.parameters, inside);
}

}  // namespace

json run_released_fit(const Context& context, RunDirectory& run, const Scene& scene, const FitStage& stage) {
  const std::string folder = object_folder(run);
  run.summary("seed", "run `pliant seed` first");
  const std::optional<PhysDreamerFolder> source = physdreamer_folder(scene);
  if (!source)
    throw usage_error("--released-fields", "", "needs a scene folder of PhysDreamer", "run on such a folder");
  if (source->material_field.empty())
    throw input_error((scene.source / "sim_fields.pt").string(), "", "is missing", "copy the released field there");
  const ObjectMaterial material = check_material(scene, stage.material, true);
  StageKey key{"fit",
               {{"material", material_to_json(material)}, {"released_fields", *stage.released_young}},
               {{"particles", run / (folder + "/particles.h5")}, {"material_field", source->material_field}},
               {folder + "/material.h5", folder + "/velocity.h5", "fit/results.json"}};
  if (!source->velocity_field.empty()) key.inputs["velocity_field"] = source->velocity_field;
  const json summary = run.stage(context, key, [&]() -> json {
    const std::string provenance = run.provenance(context, key);
    const ParticleFile particles = read_particles(run / (folder + "/particles.h5"));
    const PhysDreamerSpace space = physdreamer_roles({}, *source, scene.cloud.position).space;
    const double metres = space.scale * scene.metres_per_unit;  // of the cube's edge
    ElasticSamples solid = solid_material(particles, material);
    // Density stays, and sound takes as long through the object: E grows with the square of the length.
    const std::vector<double> raw =
        values_at(read_physdreamer_field(source->material_field, 1), space, particles.solid_position, context.threads);
    double low = INFINITY, high = 0, mean = 0;
    for (size_t s = 0; s < raw.size(); ++s) {
      const double young =
          metres * metres * std::clamp(*stage.released_young + kYoungStep * raw[s], kYoungLow, kYoungHigh);
      solid.young[s] = static_cast<float>(young);
      low = std::min(low, young);
      high = std::max(high, young);
      mean += std::log(young) / static_cast<double>(raw.size());
    }
    write_material(run / (folder + "/material.h5"),
                   {solid.young, solid.poisson, solid.density, "released by PhysDreamer", {}, {}}, provenance);

    const size_t n = particles.driving_position.size();
    VelocityFile start;
    start.velocity.assign(n, Vec3f::Zero());
    start.displacement.assign(n, Vec3f::Zero());
    start.F.assign(n, Mat3f::Identity());
    start.C.assign(n, Mat3f::Zero());
    start.source = "released by PhysDreamer";
    double fastest = 0;
    if (!source->velocity_field.empty()) {
      const std::vector<double> v = values_at(read_physdreamer_field(source->velocity_field, 3), space,
                                              particles.driving_position, context.threads);
      for (size_t i = 0; i < n; ++i) {
        start.velocity[i] = (metres * kSpeedStep * Vec3d(v[3 * i], v[3 * i + 1], v[3 * i + 2])).cast<float>();
        fastest = std::max<double>(fastest, start.velocity[i].norm());
      }
    }
    write_velocity(run / (folder + "/velocity.h5"), start, provenance);
    clear_fit_pictures(run);
    context.progress.say(
        fmt::format("fit: released fields: E from {:.3g} to {:.3g} Pa, start up to {:.3g} m/s", low, high, fastest));
    const json result = {{"source", "released by PhysDreamer"},
                         {"young_pa", std::exp(mean)},
                         {"young_low_pa", low},
                         {"young_high_pa", high},
                         {"fastest_m_s", fastest},
                         {"edge_of_cube_m", metres}};
    write_text(run / "fit/results.json", result.dump(2) + "\n");
    return result;
  });
  write_fit_page(run);
  return summary;
}

}  // namespace pliant
