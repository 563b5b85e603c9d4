#include "app/render/object_layer.h"

#include <fmt/format.h>

#include <algorithm>

#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/image_io.h"

namespace pliant {
namespace {

constexpr double kBehind = 2;             // diagonals of the object behind its place at rest that have a depth at least
constexpr float kLeastAlpha = 1 / 255.f;  // with less a pixel shows nothing of the object

}  // namespace

double farthest_depth(const Shot& shot, const TrajectoryFile& motion, const Box& object) {
  const double diagonal = object.size().norm();
  double farthest = 0;
  for (size_t k = 0; k < shot.times.size(); ++k) {
    const Camera& camera = shot.cameras[k];
    const double at_rest = (camera.centre() - object.centre().cast<double>()).norm();
    farthest = std::max(farthest, at_rest + kBehind * diagonal);
    for (const Vec3f& x : motion.at(shot.times[k]).position)
      farthest = std::max(farthest, (camera.cam_from_world * x.cast<double>()).z() + diagonal);
  }
  return farthest;
}

ObjectLayer::ObjectLayer(const std::filesystem::path& folder, const std::filesystem::path& video, const Shot& shot,
                         double farthest, double metres_per_unit)
    : folder_(folder),
      shot_(shot),
      video_(video, shot.fps, shot.cameras[0].width, shot.cameras[0].height, VideoCoding::kWithAlpha),
      metres_per_unit_(metres_per_unit),
      farthest_(metres_per_unit * farthest) {
  std::filesystem::create_directories(folder / "color");
  std::filesystem::create_directories(folder / "depth");
}

void ObjectLayer::write(size_t k, const GaussianCloud& object, const RenderOptions& options) {
  const Camera& camera = shot_.cameras[k];
  RenderOptions alone = options;
  alone.background = Vec3f::Zero();
  const RenderResult drawn = render(object, camera, alone);
  ImageF color(camera.width, camera.height, 4), depth(camera.width, camera.height, 1);
  for (size_t p = 0; p < depth.pixels(); ++p) {
    const float alpha = drawn.alpha.data[p];
    color.data[4 * p + 3] = alpha;
    if (alpha < kLeastAlpha) continue;
    for (int c = 0; c < 3; ++c) color.data[4 * p + c] = std::min(drawn.color.data[3 * p + c] / alpha, 1.0f);
    depth.data[p] = static_cast<float>(drawn.depth.data[p] / alpha * metres_per_unit_ / farthest_);
  }
  video_.write(color);
  const std::string name = fmt::format("{:06d}.png", k);
  write_image(folder_ / "color" / name, color);
  write_grey_16(folder_ / "depth" / name, depth);
  nlohmann::json rows = nlohmann::json::array();
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) rows.push_back(camera.cam_from_world.matrix()(i, j));
  frames_.push_back({{"file", name},
                     {"time", shot_.times[k]},
                     {"fx", camera.fx},
                     {"fy", camera.fy},
                     {"cx", camera.cx},
                     {"cy", camera.cy},
                     {"cam_from_world", rows}});
}

void ObjectLayer::close() {
  write_json(folder_ / "layer.json", {{"fps", shot_.fps},
                                      {"width", shot_.cameras[0].width},
                                      {"height", shot_.cameras[0].height},
                                      {"metres_per_unit", metres_per_unit_},
                                      {"metres_per_depth_step", farthest_ / 65535},
                                      {"frames", frames_}});
  video_.close();
}

}  // namespace pliant
