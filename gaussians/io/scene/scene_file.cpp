#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/files/paths.h"
#include "gaussians/io/scene/scene.h"
#include "gaussians/io/scene/up_direction.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

std::optional<double> positive(const JsonObject& object, const std::string& key) {
  if (!object.has(key)) return std::nullopt;
  const double value = object.number(key);
  if (!(value > 0)) throw object.complaint(key, "is " + std::to_string(value), "it must be positive");
  return value;
}

VideoReference read_video(const JsonObject& object, const fs::path& folder) {
  object.refuse_unknown({"file", "camera", "fps"});
  VideoReference video;
  video.file = folder / object.text("file");
  video.camera = object.text("camera");
  video.fps = positive(object, "fps").value_or(0);
  return video;
}

SceneFile::Region read_region(const JsonObject& object) {
  object.refuse_unknown({"box", "sphere"});
  if (object.has("box") == object.has("sphere")) {
    throw object.complaint("box", "and sphere are both given or both missing", "give one of them");
  }
  SceneFile::Region region;
  region.sphere = object.has("sphere");
  if (region.sphere) {
    const std::vector<double> v = object.numbers("sphere", 4);
    if (!(v[3] > 0)) throw object.complaint("sphere", "has the radius " + std::to_string(v[3]), "it must be positive");
    region.low = Vec3d(v[0], v[1], v[2]).cast<float>();
    region.high = Vec3f::Constant(static_cast<float>(v[3]));
  } else {
    const std::vector<double> v = object.numbers("box", 6);
    region.low = Vec3d(v[0], v[1], v[2]).cast<float>();
    region.high = Vec3d(v[3], v[4], v[5]).cast<float>();
    if (!(region.low.array() < region.high.array()).all()) {
      throw object.complaint("box", "has a low corner that is not below its high corner on every axis",
                             "give x0, y0, z0, x1, y1, z1 of a box with a volume");
    }
  }
  return region;
}

MaterialValues read_material(const JsonObject& object) {
  object.refuse_unknown({"young", "poisson", "density", "law", "constants"});
  MaterialValues material;
  material.young = positive(object, "young");
  material.density = positive(object, "density");
  if (object.has("poisson")) {
    const double poisson = object.number("poisson");
    if (!(poisson > -1 && poisson < 0.5)) {
      throw object.complaint("poisson", "is " + std::to_string(poisson), "it must be above -1 and below 0.5");
    }
    material.poisson = poisson;
  }
  if (object.has("law")) material.law = object.text("law");
  if (object.has("constants")) {
    const JsonObject constants = object.object("constants");
    for (const std::string& key : constants.keys()) material.constants[key] = constants.number(key);
  }
  return material;
}

/// Three numbers, or the name of an axis.
Eigen::Vector3d read_up(const JsonObject& top, bool named) {
  if (named) {
    const std::string name = top.text("up");
    if (const auto axis = axis_of_name(name)) return *axis;
    throw top.complaint("up", "is '" + name + "'", "give x, y, z, -x, -y or -z, or three numbers [x, y, z]");
  }
  const std::vector<double> v = top.numbers("up", 3);
  const Eigen::Vector3d up(v[0], v[1], v[2]);
  if (!(up.stableNorm() > 1e-9)) throw top.complaint("up", "is zero", "give a direction");
  return up.stableNormalized();
}

Vec3d read_color(const JsonObject& top, const std::string& key) {
  const std::vector<double> v = top.numbers(key, 3);
  const Vec3d color(v[0], v[1], v[2]);
  if (!(color.minCoeff() >= 0 && color.maxCoeff() <= 1))
    throw top.complaint(key, "is outside 0..1", "give red, green and blue in 0..1");
  return color;
}

}  // namespace

bool SceneFile::Region::contains(const Vec3f& x) const {
  return sphere ? (x - low).norm() <= high.x() : Box{low, high}.contains(x);
}

SceneFile read_scene_file(const fs::path& file) {
  const nlohmann::json json = read_json(file);
  const JsonObject top(json, file.string());
  top.refuse_unknown({"splats", "cameras", "photos", "masks", "labels", "video", "up", "metres_per_unit", "support",
                      "object", "pinned", "material", "antialiased", "background"});
  SceneFile scene;
  scene.file = file;
  const fs::path folder = file.parent_path();
  const std::pair<const char*, fs::path*> paths[] = {{"splats", &scene.splats},
                                                     {"cameras", &scene.cameras},
                                                     {"photos", &scene.photos},
                                                     {"masks", &scene.masks},
                                                     {"labels", &scene.labels}};
  for (const auto& [key, path] : paths) {
    if (!top.has(key)) continue;
    *path = tidy_path(folder / top.text(key));
    std::error_code ignored;
    if (!fs::exists(*path, ignored)) {
      throw input_error(file.string(), key, "names " + path->string() + ", which does not exist", "correct the path");
    }
  }
  if (top.has("video")) scene.video = read_video(top.object("video"), folder);
  if (top.has("up")) scene.up = read_up(top, json["up"].is_string());
  scene.metres_per_unit = positive(top, "metres_per_unit");
  if (top.has("support")) scene.support = top.text("support");
  if (top.has("object")) scene.object = top.text("object");
  if (top.has("pinned")) {
    const nlohmann::json& rows = top.array("pinned");
    for (size_t i = 0; i < rows.size(); ++i) {
      scene.pinned.push_back(read_region(JsonObject(rows[i], file.string(), "pinned[" + std::to_string(i) + "]")));
    }
  }
  if (top.has("material")) scene.material = read_material(top.object("material"));
  if (top.has("antialiased")) scene.antialiased = top.flag("antialiased");
  if (top.has("background")) scene.background = read_color(top, "background");
  return scene;
}

}  // namespace pliant
