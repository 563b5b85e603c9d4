// Selection in a scene from photos against outlines that a person drew (photo_truth.json):
//   photo_selection_study SCENE PHOTOS NAME OUT_FOLDER MARK...
// SCENE: what `pliant reconstruct PHOTOS` made.  A MARK is V,x,y (a click), fg|bg,V,x0,y0[,x1,y1...] (a stroke) or
// box,V,x0,y0,x1,y1 (a box), in pixels of the scene's photos; after each of them the IoU over the outlined photos, as
// one line of JSON, and overlays (green: both, red: selected alone, blue: outlined alone).  Outlines go through the
// lens of the photos' cameras.

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "app/reconstruct/photo_set.h"
#include "gaussians/base/lens.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/scene/scene.h"
#include "gaussians/render/render.h"
#include "segmentation/select/gesture.h"
#include "segmentation/select/gesture_prompts.h"

using namespace pliant;
using nlohmann::json;

namespace {

constexpr float kWidth = 8;  // px of clicks and strokes

struct Outlined {
  Camera camera;  ///< of the scene
  cv::Mat truth;  ///< [H, W] 0 or 1
};

const Camera& camera_named(const std::vector<Camera>& cameras, const std::string& name) {
  for (const Camera& camera : cameras)
    if (camera.name == name) return camera;
  throw std::runtime_error("no camera " + name);
}

/// The outline, drawn in the photo, as the scene's camera without a lens sees it.
Outlined outlined(const Camera& photo, const Camera& camera, const json& outline) {
  constexpr int kShift = 4;  // of fixed-point coordinates
  std::vector<cv::Point> points;
  for (const json& point : outline) {
    const auto plane = unproject(photo, {point[0].get<double>(), point[1].get<double>()});
    if (!plane) throw std::runtime_error("an outline leaves the lens");
    const double u = camera.fx * plane->x() + camera.cx - 0.5, v = camera.fy * plane->y() + camera.cy - 0.5;
    points.emplace_back(std::lround(u * (1 << kShift)), std::lround(v * (1 << kShift)));
  }
  Outlined out{camera, cv::Mat::zeros(camera.height, camera.width, CV_8U)};
  cv::fillPoly(out.truth, std::vector{points}, cv::Scalar(1), cv::LINE_8, kShift);
  return out;
}

void add_mark(const std::string& text, const std::vector<Camera>& cameras, Gesture& gesture) {
  if (text.starts_with("fg,") || text.starts_with("bg,"))
    add_stroke(text, cameras, kWidth, gesture);
  else if (text.starts_with("box,"))
    add_box(text.substr(4), cameras, gesture);
  else
    add_click(text, cameras, kWidth, gesture);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 6) return std::fprintf(stderr, "usage: %s SCENE PHOTOS NAME OUT_FOLDER MARK...\n", argv[0]), 2;
  const std::filesystem::path out = argv[4];
  std::filesystem::create_directories(out);
  const Scene scene = load_scene(argv[1]);
  const std::vector<Camera> photos = read_photo_cameras(find_photo_set(argv[2])).cameras;
  const json truth = read_json(std::filesystem::path(PLIANT_SOURCE_DIR) / "tests/studies/photo_truth.json").at(argv[3]);
  std::vector<Outlined> views;
  for (const auto& [name, outline] : truth.at("outlines").items())
    views.push_back(outlined(camera_named(photos, name), camera_named(scene.cameras, name), outline));

  const auto start = std::chrono::steady_clock::now();
  const PreparedScene prepared = prepare_scene({}, scene.cloud, scene.cameras);
  std::printf("{\"gaussians\": %zu, \"preparation_s\": %.2f}\n", scene.cloud.size(),
              std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  Gesture gesture;
  for (int k = 5; k < argc; ++k) {
    add_mark(argv[k], scene.cameras, gesture);
    GestureOptions options;
    options.up = scene.up.cast<float>();
    const GestureResult result = select_by_gesture(options, gesture, {}, scene.cloud, scene.cameras, prepared);
    std::vector<float> member(scene.cloud.size());
    for (size_t p = 0; p < member.size(); ++p) member[p] = result.selected(p);
    json row = {{"mark", argv[k]}, {"seconds", result.summary.seconds}, {"iou", json::object()}};
    double sum = 0;
    for (const Outlined& view : views) {
      const RenderResult picture = render(scene.cloud, view.camera, {}, member, 1);
      ImageF overlay = picture.color;
      size_t both = 0, either = 0;
      for (size_t i = 0; i < picture.features.data.size(); ++i) {
        const bool selected = picture.features.data[i] > 0.5f, inside = view.truth.data[i];
        both += selected && inside;
        either += selected || inside;
        if (selected || inside) overlay.data[3 * i + (selected && inside ? 1 : selected ? 0 : 2)] = 1;
      }
      const double iou = static_cast<double>(both) / static_cast<double>(std::max<size_t>(1, either));
      row["iou"][view.camera.name] = iou;
      sum += iou / static_cast<double>(views.size());
      write_image(out / (std::string(argv[3]) + "_" + std::to_string(k - 5) + "_" + view.camera.name + ".png"),
                  overlay);
    }
    row["mean_iou"] = sum;
    std::printf("%s\n", row.dump().c_str());
  }
}
