#include "app/store/lenses.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/json_file.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr double kMostPixels = 65536;  // of a side

int side(const JsonObject& lens, const char* key) {
  const double value = lens.number(key);
  if (!(value >= 1 && value <= kMostPixels && value == std::floor(value)))
    throw lens.complaint(key, "is " + std::to_string(value), "it must be a number of pixels");
  return static_cast<int>(value);
}

double focal_length(const JsonObject& lens, const char* key) {
  const double value = lens.number(key);
  if (!(value > 0)) throw lens.complaint(key, "is " + std::to_string(value), "it must be positive");
  return value;
}

}  // namespace

void write_lenses(const fs::path& file, const TrainingPhotos& photos) {
  nlohmann::json lenses = nlohmann::json::object();
  for (const TrainingPhoto& photo : photos.photos) {
    const Camera& lens = photo.lens;
    if (lens.width == 0) continue;
    lenses[lens.name] = {
        {"width", lens.width}, {"height", lens.height},        {"fx", lens.fx}, {"fy", lens.fy}, {"cx", lens.cx},
        {"cy", lens.cy},       {"distortion", lens.distortion}};
  }
  if (lenses.empty())
    fs::remove(file);
  else
    write_json(file, lenses);
}

std::optional<Camera> read_lens(const fs::path& file, const Camera& pinhole) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return std::nullopt;
  const nlohmann::json json = read_json(file);
  const JsonObject lenses(json, file.string(), "", Failure::kInput);
  if (!lenses.has(pinhole.name)) return std::nullopt;
  const JsonObject lens = lenses.object(pinhole.name);
  Camera camera = pinhole;
  camera.width = side(lens, "width");
  camera.height = side(lens, "height");
  camera.fx = focal_length(lens, "fx");
  camera.fy = focal_length(lens, "fy");
  camera.cx = lens.number("cx");
  camera.cy = lens.number("cy");
  const std::vector<double> distortion = lens.numbers("distortion", camera.distortion.size());
  std::copy(distortion.begin(), distortion.end(), camera.distortion.begin());
  return camera;
}

}  // namespace pliant
