#include "app/predict/object_samples.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/run/attach_scene.h"
#include "app/simulate/given_fields.h"
#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/io/splats/ply.h"

namespace pliant {

SolidSamples samples_in_metres(const ParticleFile& file, double metres_per_unit) {
  const float scale = static_cast<float>(metres_per_unit);
  SolidSamples samples;
  double total = 0;
  for (size_t i = 0; i < file.solid_position.size(); ++i) {
    const int driver = file.solid_driver[i];
    const bool thin = driver >= 0 && !file.driving_thickness.empty();
    samples.position.push_back(scale * file.solid_position[i]);
    samples.volume.push_back(scale * scale * scale * file.solid_volume[i]);
    samples.thickness.push_back(thin ? scale * file.driving_thickness[driver] : 0);
    total += samples.volume.back();
  }
  samples.spacing = static_cast<float>(std::cbrt(total / static_cast<double>(samples.size())));
  return samples;
}

std::vector<Vec3f> nearest_colours(const GaussianCloud& object, const std::vector<Vec3f>& positions) {
  std::vector<Vec3f> colours;
  for (const int i : k_nearest(object.position, positions, 1)) {
    const float* sh = object.sh_of(i);
    colours.push_back((Vec3f(sh[0], sh[1], sh[2]) * kSh0 + Vec3f::Constant(0.5f)).cwiseMax(0).cwiseMin(1));
  }
  return colours;
}

MaterialObject fitted_object(const RunDirectory& run, const Scene& scene) {
  if (!is_fitted(run))
    throw usage_error("--add-run", run.path().string(), "has no fit", "run `pliant fit` there first");
  if (const std::string of = fit_is_of(run, scene); !of.empty())
    throw usage_error("--add-run", run.path().string(), "has a fit of " + of, "run `pliant fit` there again");
  const std::string folder = object_folder(run);
  const ParticleFile file = read_particles(run / (folder + "/particles.h5"));
  const ElasticSamples material = given_material(run / (folder + "/material.h5"), file);
  MaterialObject object;
  object.family = extracted(run, {"name"})["name"];
  object.samples = samples_in_metres(file, scene.metres_per_unit);
  object.colour = nearest_colours(read_ply(run / (folder + "/object.ply")), file.solid_position);
  object.up = scene.up.cast<float>();
  object.young = material.young;
  object.poisson = material.poisson;
  object.density = material.density;
  return object;
}

}  // namespace pliant
