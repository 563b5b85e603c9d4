#include "gaussians/io/scene/scene.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "gaussians/base/error.h"
#include "gaussians/base/orbit.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/paths.h"
#include "gaussians/io/files/text.h"
#include "gaussians/io/scene/doubtful.h"
#include "gaussians/io/scene/up_direction.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/io/splats/splats.h"

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
    if (fs::is_regular_file(splats, ignored)) {
      largest = number;
      best = splats;
    }
  }
  return best;
}

/// Whether a file of a folder is meant as splats, by content and extension: checkpoints, archives (.usdz, .zip) and
/// point clouds lie beside them.
bool looks_like_splats(const fs::path& file) {
  constexpr std::array<const char*, 6> kExtensions = {".ply", ".splat", ".spz", ".sog", ".ksplat", ".json"};
  if (std::find(kExtensions.begin(), kExtensions.end(), lower_extension(file)) == kExtensions.end() ||
      splats_at(file).empty())
    return false;
  try {
    return !is_point_cloud(file);
  } catch (const Error&) {
    return true;  // its reader says what is damaged
  }
}

/// Of splats in point_cloud/iteration_<n> that of the 3DGS model, else the one in which they lie.
fs::path model_folder_of(const fs::path& splats) {
  const fs::path folder = tidy_path(fs::absolute(splats)).parent_path();
  return folder.filename().string().starts_with("iteration_") ? folder.parent_path().parent_path() : folder;
}

/// Takes the background from the options of the training that 3DGS and PhysGaussian keep in cfg_args.
void read_background_of_model(SceneFile& settings) {
  std::error_code ignored;
  fs::path file = model_folder_of(settings.splats) / "cfg_args";
  if (fs::is_symlink(settings.splats, ignored) && !fs::exists(file, ignored))
    file = model_folder_of(fs::weakly_canonical(settings.splats, ignored)) / "cfg_args";
  if (settings.background || !fs::is_regular_file(file, ignored)) return;
  if (read_text(file).find("white_background=True") == std::string::npos) return;
  settings.background = Vec3d::Ones();
  settings.background_file = file;
}

/// Why no splats were found in a folder.
Error without_splats(const fs::path& folder) {
  const std::vector<fs::path> several = splat_files_in(folder);
  if (several.empty())
    return input_error(folder.string(), "",
                       "contains neither scene.json nor point_cloud/iteration_*/point_cloud.ply nor a splat file",
                       "give a splat file, a 3DGS model folder, or a folder with scene.json");
  std::string names;
  for (const fs::path& file : several) names += (names.empty() ? "" : ", ") + file.filename().string();
  return input_error(folder.string(), "", "contains several splat files: " + names, "give one of them");
}

/// Fills in where splats and cameras are; `found` says that the cameras were found and not named by scene.json.
SceneFile locate(const fs::path& source, bool& found) {
  std::error_code ignored;
  SceneFile scene;
  if (!fs::exists(source, ignored))
    throw input_error(source.string(), "", "does not exist", "check the name of the scene");
  if (!fs::is_directory(source, ignored)) {
    if (source.filename() == "scene.json") {
      scene = read_scene_file(source);
    } else {
      scene.splats = source;
    }
  } else if (fs::is_regular_file(source / "scene.json", ignored)) {
    scene = read_scene_file(source / "scene.json");
  } else {
    scene.splats = splats_of_folder(source);
    if (scene.splats.empty()) throw without_splats(source);
  }
  if (scene.splats.empty()) throw input_error(scene.file.string(), "splats", "is missing", "give the splat file");
  found = scene.cameras.empty();
  if (found && scene.file.empty() && fs::is_directory(source, ignored)) scene.cameras = cameras_in(source);
  if (scene.cameras.empty()) scene.cameras = cameras_of_splats(scene.splats);
  return scene;
}

/// What is doubtful of cameras that were found beside splats of nerfstudio, which normalizes poses before training.
std::string doubtful_frame(const SceneFile& settings) {
  return settings.splats.string() +
         ": was written by nerfstudio, which normalizes the poses before training, so that " +
         settings.cameras.string() +
         ", found beside it, probably does not match; move the splats to a folder without cameras (views on an orbit "
         "are rendered), or train with `--orientation-method none --center-method none --auto-scale-poses False`; "
         "where they match, name them as \"cameras\" of a scene.json";
}

void choose_up(const LoadOptions& options, Scene& scene) {
  if (options.up) {
    if (!(options.up->norm() > 1e-9) || !options.up->allFinite())
      throw usage_error("--up", "", "is not a direction", "give x,y,z");
    scene.up = options.up->stableNormalized();
    scene.up_source = "given by the user";
    return;
  }
  if (scene.settings.up) {
    scene.up = *scene.settings.up;
    scene.up_source = "given by " + scene.settings.file.string();
    return;
  }
  std::optional<UpDirection> found = up_of_cameras(scene.cameras);
  if (!found) found = up_of_cloud(scene.cloud, scene.report.z_is_up);
  scene.up = found->up;
  scene.up_source = found->source;
}

}  // namespace

fs::path splats_of_folder(const fs::path& folder) {
  fs::path splats = splats_of_model(folder);
  if (splats.empty()) splats = splats_at(folder);
  std::error_code ignored;
  // Other point clouds beside it say what its parts do (PhysDreamer).
  if (splats.empty() && fs::is_regular_file(folder / "point_cloud.ply", ignored)) splats = folder / "point_cloud.ply";
  if (!splats.empty()) return splats;
  const std::vector<fs::path> files = splat_files_in(folder);
  return files.size() == 1 ? files[0] : fs::path();
}

std::vector<fs::path> splat_files_in(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.is_regular_file(ignored) && looks_like_splats(entry.path())) found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  return found;
}

fs::path cameras_of_splats(const fs::path& splats) {
  const fs::path beside = cameras_in(splats.parent_path());
  if (!beside.empty()) return beside;
  if (const fs::path model = model_folder_of(splats); model != tidy_path(fs::absolute(splats)).parent_path())
    return cameras_in(model);
  return fs::is_symlink(splats) && fs::exists(splats) ? cameras_of_splats(fs::canonical(splats)) : fs::path();
}

Scene load_scene(const fs::path& source, const LoadOptions& options) {
  Scene scene;
  scene.source = source;
  bool found = false;
  scene.settings = locate(source, found);
  read_background_of_model(scene.settings);
  scene.cloud = read_splats(scene.settings.splats, &scene.report, options.level.value_or(kFinestLevel));
  scene.warnings = scene.report.warnings;
  if (options.antialiased) scene.settings.antialiased = true;
  scene.report.antialiased = scene.settings.antialiased.value_or(scene.report.antialiased);
  if (scene.cloud.size() == 0) {
    throw input_error(scene.settings.splats.string(), "", "contains no usable Gaussians", "give a trained scene");
  }
  if (!scene.settings.cameras.empty()) {
    CameraFile file = read_cameras(scene.settings.cameras, scene.settings.photos);
    scene.cameras = std::move(file.cameras);
    scene.warnings.insert(scene.warnings.end(), file.warnings.begin(), file.warnings.end());
    if (const std::string sentence = other_models(scene.settings.cameras); !sentence.empty())
      scene.warnings.push_back(sentence);
    if (found && scene.report.nerfstudio) scene.warnings.push_back(doubtful_frame(scene.settings));
  }
  choose_up(options, scene);
  if (scene.cameras.empty()) {
    OrbitOptions orbit;
    orbit.views = options.orbit_views.value_or(24);
    orbit.width = options.orbit_width;
    orbit.height = options.orbit_height;
    if (orbit.views < 1 || orbit.width < 1 || orbit.height < 1) {
      throw usage_error("--orbit-views", "", "is not positive", "give at least one view");
    }
    scene.cameras = orbit_cameras(orbit, scene.cloud, scene.up);
    scene.cameras_are_orbit = true;
  }
  for (const std::string& sentence :
       doubtful_units(source.string(), scene.cloud, scene.cameras, scene.cameras_are_orbit))
    scene.warnings.push_back(sentence);
  const std::optional<double> metres =
      options.metres_per_unit ? options.metres_per_unit : scene.settings.metres_per_unit;
  constexpr double kLongest = 1e9;  // m, and its inverse the shortest, that a unit may stand for
  if (metres && !(*metres >= 1 / kLongest && *metres <= kLongest))
    throw usage_error("metres_per_unit", "", "is " + std::to_string(*metres), "give 1e-9 to 1e9");
  scene.metres_per_unit = metres.value_or(1.0);
  scene.object_height = options.object_height;
  scene.scale_is_assumed = !metres && options.object_height == 0;
  return scene;
}

}  // namespace pliant
