#include "gaussians/io/scene/describe.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/base/orbit.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/scene/scene.h"
#include "gaussians/io/scene/up_direction.h"
#include "gaussians/io/splats/splats.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

/// Values shortened to the seven digits that a float carries.
double rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.7g", value);
  return std::strtod(text, nullptr);
}

template <class Vector>
json array_of(const Vector& v) {
  return {rounded(v[0]), rounded(v[1]), rounded(v[2])};
}

json describe_splats(const GaussianCloud& cloud, const ReadReport& report) {
  json out = {{"format", report.format},   {"gaussians", cloud.size()},    {"rows", report.rows},
              {"dropped", report.dropped}, {"sh_degree", cloud.sh_degree}, {"antialiased", report.antialiased}};
  if (report.levels > 1) {
    out["levels_of_detail"] = report.levels;
    out["level"] = report.level;
  }
  if (report.object_channels > 0) out["object_feature_channels"] = report.object_channels;
  if (cloud.size() == 0) return out;
  const Box bounds = cloud.bounds();
  out["bounds"] = {{"low", array_of(bounds.low)}, {"high", array_of(bounds.high)}};
  std::vector<float> value(cloud.size());
  Vec3f low, high;
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < cloud.size(); ++i) value[i] = cloud.position[i][axis];
    low[axis] = static_cast<float>(weighted_percentile(value, {}, 0.02));
    high[axis] = static_cast<float>(weighted_percentile(value, {}, 0.98));
  }
  out["bounds_2_98"] = {{"low", array_of(low)}, {"high", array_of(high)}};
  double sum = 0, faint = 0;
  for (size_t i = 0; i < cloud.size(); ++i) {
    value[i] = sigmoid(cloud.opacity_logit[i]);
    sum += value[i];
    faint += value[i] < 1.0f / 255;
  }
  const auto n = static_cast<double>(cloud.size());
  out["opacity"] = {{"mean", rounded(sum / n)},
                    {"median", rounded(weighted_percentile(value, {}, 0.5))},
                    {"invisible_share", rounded(faint / n)}};
  for (size_t i = 0; i < cloud.size(); ++i) value[i] = std::exp(cloud.log_scale[i].maxCoeff());
  out["largest_axis"] = {{"median", rounded(weighted_percentile(value, {}, 0.5))},
                         {"maximum", rounded(*std::max_element(value.begin(), value.end()))}};
  return out;
}

json describe_cameras(const std::vector<Camera>& cameras) {
  json out = {{"count", cameras.size()}};
  if (cameras.empty()) return out;
  std::vector<std::string> sizes;
  double low = INFINITY, high = 0;
  size_t photos = 0;
  for (const Camera& camera : cameras) {
    const std::string size = std::to_string(camera.width) + "x" + std::to_string(camera.height);
    if (std::find(sizes.begin(), sizes.end(), size) == sizes.end()) sizes.push_back(size);
    low = std::min({low, camera.fx, camera.fy});
    high = std::max({high, camera.fx, camera.fy});
    photos += !camera.photo.empty();
  }
  out["sizes"] = sizes;
  out["focal"] = {rounded(low), rounded(high)};
  out["photos"] = photos;
  out["names"] = {cameras.front().name, cameras.back().name};
  for (size_t k = 0; k < kDistortionNames.size(); ++k) {
    const auto [least, most] =
        std::minmax_element(cameras.begin(), cameras.end(),
                            [k](const Camera& a, const Camera& b) { return a.distortion[k] < b.distortion[k]; });
    if (least->distortion[k] != 0 || most->distortion[k] != 0) {
      out["distortion"][kDistortionNames[k]] = {rounded(least->distortion[k]), rounded(most->distortion[k])};
    }
  }
  return out;
}

json describe_settings(const SceneFile& settings) {
  json out = json::object();
  const std::pair<const char*, const fs::path*> paths[] = {{"splats", &settings.splats},
                                                           {"cameras", &settings.cameras},
                                                           {"photos", &settings.photos},
                                                           {"masks", &settings.masks},
                                                           {"labels", &settings.labels}};
  for (const auto& [key, path] : paths) {
    if (!path->empty()) out[key] = path->string();
  }
  if (settings.video) {
    out["video"] = {
        {"file", settings.video->file.string()}, {"camera", settings.video->camera}, {"fps", settings.video->fps}};
  }
  if (!settings.support.empty()) out["support"] = settings.support;
  if (!settings.object.empty()) out["object"] = settings.object;
  if (!settings.pinned.empty()) out["pinned_regions"] = settings.pinned.size();
  if (settings.material.young) out["young"] = *settings.material.young;
  if (settings.material.poisson) out["poisson"] = *settings.material.poisson;
  if (settings.material.density) out["density"] = *settings.material.density;
  if (settings.background) out["background"] = array_of(*settings.background);
  if (!settings.background_file.empty())
    out["background_source"] = "white_background of " + settings.background_file.string();
  if (!settings.material.law.empty()) out["law"] = settings.material.law;
  if (!settings.material.constants.empty()) out["law_constants"] = settings.material.constants;
  return out;
}

void add_lines(const json& value, const std::string& indent, std::string& text) {
  for (const auto& [key, entry] : value.items()) {
    const std::string name = indent + (value.is_array() ? "- " : key + ": ");
    if (entry.is_object() || (entry.is_array() && !entry.empty() && entry[0].is_string())) {
      text += indent + key + ":\n";
      add_lines(entry, indent + "  ", text);
    } else {
      text += name + (entry.is_string() ? entry.get<std::string>() : entry.dump()) + "\n";
    }
  }
}

/// What a scene has besides its splats.
void describe_scene(const Scene& scene, json& out) {
  out["cameras"] = describe_cameras(scene.cameras);
  out["cameras"]["source"] = scene.cameras_are_orbit ? "automatic orbit" : scene.settings.cameras.string();
  out["up"] = array_of(scene.up);
  out["up_source"] = scene.up_source;
  out["settings"] = describe_settings(scene.settings);
  out["warnings"] = scene.warnings;
}

/// Splats with what a command would find beside them.  Where it would refuse them, that is a warning.
void describe_splat_file(const fs::path& path, const fs::path& splats, const LoadOptions& options, json& out) {
  out["kind"] = "splats";
  std::string refused;
  try {
    const Scene scene = load_scene(path, options);
    out["splats"] = describe_splats(scene.cloud, scene.report);
    return describe_scene(scene, out);
  } catch (const Error& error) {
    refused = error.what();
  }
  ReadReport report;
  const GaussianCloud cloud = read_splats(splats, &report, options.level.value_or(kFinestLevel));
  out["splats"] = describe_splats(cloud, report);
  const UpDirection up = cloud.size() > 0 ? up_of_cloud(cloud, report.z_is_up) : UpDirection{};
  out["up"] = array_of(up.up);
  out["up_source"] = up.source;
  out["warnings"] = report.warnings;
  if (cloud.size() > 0) out["warnings"].push_back(refused);
}

void describe_camera_file(const CameraFile& file, json& out) {
  out["cameras"] = describe_cameras(file.cameras);
  out["cameras"]["format"] = file.format;
  out["cameras"]["frames_in_file"] = file.frames;
  out["warnings"] = file.warnings;
}

/// Where cameras and photos are from which a scene is to be trained; none where there are splats or no cameras.
std::optional<SceneFile> photos_at(const fs::path& path, bool scene_file) {
  std::error_code ignored;
  const fs::path folder = fs::is_directory(path, ignored) ? path : path.parent_path();
  SceneFile settings;
  if (scene_file) {
    settings = read_scene_file(folder / "scene.json");
    if (!settings.splats.empty()) return std::nullopt;
  } else {
    if (!fs::is_directory(path, ignored)) return std::nullopt;
    if (const fs::path splats = splats_of_folder(path); !splats.empty() && !is_point_cloud(splats)) return std::nullopt;
  }
  if (settings.cameras.empty()) settings.cameras = cameras_in(folder, ColmapChoice::kLargest);
  if (settings.cameras.empty()) return std::nullopt;
  if (settings.photos.empty()) settings.photos = folder;
  return settings;
}

void describe_photos(const SceneFile& settings, const std::optional<int>& level, json& out) {
  if (level)
    throw usage_error("--level", std::to_string(*level), "does nothing: there are no splats yet", "leave it out");
  out["kind"] = "photos";
  describe_camera_file(read_cameras(settings.cameras, settings.photos, PhotoFit::kEachPhoto), out);
  out["cameras"]["source"] = settings.cameras.string();
  if (const std::string others = other_models(settings.cameras); !others.empty()) out["warnings"].push_back(others);
  out["settings"] = describe_settings(settings);
}

}  // namespace

json describe(const fs::path& path, std::optional<int> level) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) throw input_error(path.string(), "", "does not exist", "check the name");
  json out = {{"file", path.string()}};
  const bool scene_file = path.filename() == "scene.json" || fs::exists(path / "scene.json", ignored);
  const fs::path splats = scene_file ? fs::path() : splats_at(path);
  const fs::path cameras = scene_file || !splats.empty() ? fs::path() : cameras_at(path);
  LoadOptions options;
  options.level = level;
  if (!splats.empty()) {
    describe_splat_file(path, splats, options, out);
  } else if (!cameras.empty()) {
    out["kind"] = "cameras";
    describe_camera_file(read_cameras(cameras), out);
  } else if (const auto photos = photos_at(path, scene_file)) {
    describe_photos(*photos, level, out);
  } else if (fs::is_directory(path, ignored) || scene_file) {
    const Scene scene = load_scene(path, options);
    out["kind"] = "scene";
    out["splats"] = describe_splats(scene.cloud, scene.report);
    describe_scene(scene, out);
    out["metres_per_unit"] = scene.metres_per_unit;
    if (scene.scale_is_assumed)
      out["warnings"].push_back("the scale of the scene is unknown: one unit is assumed to be one meter");
  } else if (const std::string extension = path.extension(); extension == ".ksplat" || extension == ".json") {
    if (extension == ".json") read_cameras(path);
    read_splats(path);
  } else {
    throw input_error(
        path.string(), "", "is of an unknown kind",
        "give splats (.ply, .splat, .spz, .sog, meta.json), cameras (.json, COLMAP, _par.txt), or a scene folder");
  }
  return out;
}

std::string description_text(const json& description) {
  std::string text;
  add_lines(description, "", text);
  return text;
}

}  // namespace pliant
