#include "app/fit/start_material.h"

#include <algorithm>
#include <cmath>

#include "app/run/attach_scene.h"
#include "app/simulate/given_fields.h"
#include "app/simulate/simulated_body.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

/// [M] E around each driver: volume-weighted means of log E over its samples.
std::vector<double> young_around_drivers(const ParticleFile& particles, std::span<const float> young) {
  std::vector<double> sum(particles.driving_position.size()), volume(sum.size());
  for (size_t s = 0; s < young.size(); ++s) {
    const int driver = particles.solid_driver[s];
    if (driver < 0) continue;
    sum[driver] += double(particles.solid_volume[s]) * std::log(double(young[s]));
    volume[driver] += particles.solid_volume[s];
  }
  for (size_t i = 0; i < sum.size(); ++i) sum[i] = std::exp(sum[i] / volume[i]);
  return sum;
}

}  // namespace

std::string initial_material_file(const RunDirectory& run, const Scene& scene, const FitStage& stage) {
  if (stage.initial_material != kPredictedMaterial) return stage.initial_material;
  if (!predicts_object(run))
    throw usage_error("fit", stage.typed("initial-material") + " " + kPredictedMaterial,
                      "needs a prediction of the object, and this run has none",
                      "run `pliant predict` first, or give a file");
  if (const std::string of = prediction_is_of(run, scene); !of.empty())
    throw usage_error("fit", stage.typed("initial-material") + " " + kPredictedMaterial, "is " + of,
                      "run `pliant predict` again");
  return (run / (object_folder(run) + "/predicted.h5")).string();
}

SetBy start_set_by(const FitStage& stage) {
  return stage.initial_material.empty() && !stage.kinematic() ? SetBy::kFit : SetBy::kFields;
}

StartMaterial start_material(const FitInputs& in, const ParticleFile& particles, Progress* progress) {
  const auto file = in.files.find("initial_material");
  StartMaterial start;
  start.given = file != in.files.end();
  const ObjectMaterial material = check_material(in.scene, in.options.material, start_set_by(in.options));
  start.law = material.material;
  if (!start.given) {
    start.solid = solid_material(particles, material);
    start.young = material.young;
    start.driver_young.assign(particles.driving_position.size(), material.young);
    return start;
  }
  start.solid = given_material(file->second, particles.solid_position, progress);
  start.young = mean_young(particles, start.solid.young);
  start.driver_young = young_around_drivers(particles, start.solid.young);
  return start;
}

double mean_young(const ParticleFile& particles, std::span<const float> young) {
  double sum = 0;
  size_t moving = 0;
  for (size_t s = 0; s < young.size(); ++s)
    if (particles.solid_driver[s] >= 0) {
      sum += std::log(young[s]);
      ++moving;
    }
  return std::exp(sum / std::max<size_t>(1, moving));
}

}  // namespace pliant
