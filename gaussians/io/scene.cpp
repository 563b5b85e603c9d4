#include "gaussians/io/scene.h"

#include <algorithm>
#include <charconv>

#include "gaussians/base/error.h"
#include "gaussians/base/orbit.h"
#include "gaussians/io/transforms.h"
#include "gaussians/io/up_direction.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

/// point_cloud/iteration_<largest>/point_cloud.ply of a 3DGS model folder; empty when there is none.
fs::path splats_of_model(const fs::path& folder) {
  const fs::path iterations = folder / "point_cloud";
  std::error_code ignored;
  if (!fs::is_directory(iterations, ignored)) return {};
  fs::path best;
  long long largest = -1;
  for (const auto& entry : fs::directory_iterator(iterations)) {
    const std::string name = entry.path().filename().string(), prefix = "iteration_";
    if (name.rfind(prefix, 0) != 0) continue;
    long long number = -1;
    const auto [end, failed] = std::from_chars(name.data() + prefix.size(), name.data() + name.size(), number);
    if (failed != std::errc() || end != name.data() + name.size() || number <= largest) continue;
    const fs::path splats = entry.path() / "point_cloud.ply";
    if (fs::is_regular_file(splats, ignored)) largest = number, best = splats;
  }
  return best;
}

/// transforms.json of a folder, else the first of its transforms*.json by name; empty when there is none.
fs::path cameras_beside(const fs::path& folder) {
  std::error_code ignored;
  if (fs::is_regular_file(folder / "transforms.json", ignored)) return folder / "transforms.json";
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? fs::path(".") : folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("transforms", 0) == 0 && entry.path().extension() == ".json") found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  return found.empty() ? fs::path() : found.front();
}

/// Fills in where splats and cameras are.
SceneFile locate(const fs::path& source) {
  std::error_code ignored;
  SceneFile scene;
  if (!fs::exists(source, ignored)) throw input_error(source.string(), "", "does not exist", "check the name of the scene");
  if (!fs::is_directory(source, ignored)) {
    if (source.filename() == "scene.json") {
      scene = read_scene_file(source);
    } else {
      scene.splats = source;
    }
  } else if (fs::is_regular_file(source / "scene.json", ignored)) {
    scene = read_scene_file(source / "scene.json");
  } else {
    scene.splats = splats_of_model(source);
    scene.cameras = cameras_beside(source);
    if (scene.splats.empty()) {
      throw input_error(source.string(), "", "holds neither scene.json nor point_cloud/iteration_*/point_cloud.ply",
                        "name a splat file (.ply), a 3DGS model folder, or a folder with scene.json");
    }
  }
  if (scene.splats.empty()) throw input_error(scene.file.string(), "splats", "is missing", "name the splat file");
  if (scene.cameras.empty()) scene.cameras = cameras_beside(scene.splats.parent_path());
  return scene;
}

void choose_up(const LoadOptions& options, Scene& scene) {
  if (options.up) {
    if (!(options.up->norm() > 1e-9) || !options.up->allFinite()) throw usage_error("--up", "", "is not a direction", "give x,y,z");
    scene.up = options.up->normalized(), scene.up_source = "given by the user";
    return;
  }
  if (scene.settings.up) {
    scene.up = *scene.settings.up, scene.up_source = "given by " + scene.settings.file.string();
    return;
  }
  std::optional<UpDirection> found = up_of_cameras(scene.cameras);
  if (!found) found = up_of_support_plane(scene.cloud);
  if (!found) found = UpDirection{{0, -1, 0}, "-y, the usual up of reconstructed scenes, because no support plane is evident"};
  scene.up = found->up, scene.up_source = found->source;
}

}  // namespace

Scene load_scene(const fs::path& source, const LoadOptions& options) {
  Scene scene;
  scene.source = source;
  scene.settings = locate(source);
  if (scene.settings.splats.extension() != ".ply") {
    throw input_error(scene.settings.splats.string(), "splats", "has an extension that is not read", "convert it to a 3DGS .ply");
  }
  scene.cloud = read_ply(scene.settings.splats, &scene.report);
  scene.warnings = scene.report.warnings;
  if (scene.cloud.size() == 0) {
    throw input_error(scene.settings.splats.string(), "element vertex", "holds no usable Gaussian", "name a trained scene");
  }
  if (!scene.settings.cameras.empty()) {
    CameraFile file = read_transforms(scene.settings.cameras, scene.settings.photos);
    scene.cameras = std::move(file.cameras);
    scene.warnings.insert(scene.warnings.end(), file.warnings.begin(), file.warnings.end());
  }
  choose_up(options, scene);
  if (scene.cameras.empty()) {
    OrbitOptions orbit;
    orbit.views = options.orbit_views, orbit.width = options.orbit_width, orbit.height = options.orbit_height;
    if (orbit.views < 1 || orbit.width < 1 || orbit.height < 1) {
      throw usage_error("--orbit-views", "", "is not positive", "give at least one view");
    }
    scene.cameras = orbit_cameras(orbit, scene.cloud, scene.up);
    scene.cameras_are_orbit = true;
  }
  const std::optional<double> metres = options.metres_per_unit ? options.metres_per_unit : scene.settings.metres_per_unit;
  if (metres && !(*metres > 0 && std::isfinite(*metres))) {
    throw usage_error("metres_per_unit", "", "is " + std::to_string(*metres), "it must be positive");
  }
  scene.metres_per_unit = metres.value_or(1.0);
  if (!metres) scene.warnings.push_back("the scale of the scene is unknown: one unit is taken as one metre");
  return scene;
}

}  // namespace pliant
