#include "app/predict/object_samples.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "app/run/attach_scene.h"
#include "app/simulate/given_fields.h"
#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/io/scene/up_direction.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/io/splats/splats.h"
#include "physics/body/interior_fill.h"

namespace pliant {
namespace {

/// Refuses several files of one name, of which a folder lists any first.
std::filesystem::path only_file(std::vector<std::filesystem::path> files, const std::string& what) {
  if (files.size() == 1) return files[0];
  std::sort(files.begin(), files.end());
  throw usage_error("--objects", files[0].string(),
                    "and " + files[1].filename().string() + " are two " + what + " of one name",
                    "leave one of them in the folder");
}

}  // namespace

SolidSamples samples_in_metres(const SolidFile& file, double metres_per_unit) {
  const float scale = static_cast<float>(metres_per_unit);
  SolidSamples samples = file.samples;
  for (Vec3f& x : samples.position) x *= scale;
  for (float& volume : samples.volume) volume *= scale * scale * scale;
  for (float& thickness : samples.thickness) thickness *= scale;
  samples.spacing = static_cast<float>(std::cbrt(samples.total_volume() / static_cast<double>(samples.size())));
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
  const SolidFile file = read_solid(run / (folder + "/solid.h5"));
  const ElasticSamples material = given_material(run / (folder + "/material.h5"), file.samples.position);
  MaterialObject object;
  object.family = extracted(run, {"name"})["name"];
  object.samples = samples_in_metres(file, scene.metres_per_unit);
  object.colour = nearest_colours(read_ply(run / (folder + "/object.ply")), file.samples.position);
  object.up = scene.up.cast<float>();
  object.young = material.young;
  object.poisson = material.poisson;
  object.density = material.density;
  return object;
}

std::vector<MaterialObject> splat_objects(const std::filesystem::path& folder, uint64_t seed) {
  constexpr int kSamples = 4000;
  if (!std::filesystem::is_directory(folder))
    throw usage_error("--objects", folder.string(), "is not a folder", "give a folder of splats with material fields");
  std::map<std::string, std::vector<std::filesystem::path>> splats, fields;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::filesystem::path& file = entry.path();
    std::string stem = file.stem().string();
    const std::string extension = file.extension().string();
    const bool points = extension == ".ply" && std::filesystem::path(stem).extension() == ".field";
    if (points) stem = std::filesystem::path(stem).stem().string();
    if (points || extension == ".npz" || extension == ".h5")
      fields[stem].push_back(file);
    else if (entry.is_regular_file() && !splats_at(file).empty())
      splats[stem].push_back(file);
  }
  std::vector<MaterialObject> objects;
  for (const auto& [name, files] : splats) {
    if (!fields.count(name)) continue;
    const std::filesystem::path file = only_file(files, "splat files"),
                                field = only_file(fields.at(name), "material fields");
    ReadReport report;
    const GaussianCloud cloud = read_splats(file, &report, kFinestLevel);
    FillOptions fill;
    fill.target_count = kSamples;
    fill.seed = seed;
    MaterialObject object;
    object.family = name.substr(0, name.find_first_of("0123456789-_"));
    if (object.family.empty()) object.family = name;
    object.samples = fill_interior(fill, cloud);
    const ElasticSamples material = given_material(field, object.samples.position);
    object.colour = nearest_colours(cloud, object.samples.position);
    object.up = up_of_cloud(cloud, report.z_is_up).up.cast<float>();
    object.young = material.young;
    object.poisson = material.poisson;
    object.density = material.density;
    objects.push_back(std::move(object));
  }
  if (objects.empty())
    throw usage_error("--objects", folder.string(), "holds no splat file with a material field beside it",
                      "name them alike: chair-1.ply and chair-1.npz");
  return objects;
}

}  // namespace pliant
