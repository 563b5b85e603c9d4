#include "app/choose/choose_page.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/choose/choose_assets.h"
#include "app/report/html.h"
#include "app/segment/objects_file.h"
#include "gaussians/io/files/base64.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/webp.h"
#include "gaussians/render/render.h"
#include "segmentation/select/prepared_scene.h"
#include "segmentation/sheets/objects_sheet.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr size_t kMostViews = 8;
constexpr double kLongestSide = 800;  // px
constexpr float kQuality = 80;        // of WebP

}  // namespace

json run_lengths(std::span<const uint32_t> values) {
  json out = json::array();
  for (size_t i = 0; i < values.size();) {
    size_t end = i;
    while (end < values.size() && values[end] == values[i]) ++end;
    out.push_back(values[i]);
    out.push_back(end - i);
    i = end;
  }
  return out;
}

std::vector<int> shown_cameras(const Scene& scene) { return different_cameras(scene.cameras, kMostViews); }

Camera shown_camera(const Scene& scene, int camera) {
  const Camera& full = scene.cameras[camera];
  return full.scaled(std::min(1.0, kLongestSide / std::max(full.width, full.height)));
}

json shown_things(const RunDirectory& run) {
  json things = json::parse(read_text(run / "objects.json"));
  for (json& thing : things) {
    const Vec3f color = id_color(thing.at("id"));
    thing["color"] = {color.x(), color.y(), color.z()};
  }
  return things;
}

json choose_data(const RunDirectory& run, const Scene& scene, const Marks& marks) {
  const Segmentation segmentation = read_objects(run, scene);
  RenderOptions options;
  options.antialiased = scene.report.antialiased;
  options.background = scene.settings.background_color();
  json views = json::array();
  for (const int index : shown_cameras(scene)) {
    const Camera& full = scene.cameras[index];
    const Camera camera = shown_camera(scene, index);
    const ImageU8 picture = to_8_bit(render(scene.cloud, camera, options).color);
    views.push_back(
        {{"camera", index},
         {"name", full.name},
         {"width", camera.width},
         {"height", camera.height},
         {"scale", {static_cast<double>(full.width) / camera.width, static_cast<double>(full.height) / camera.height}},
         {"picture", base64(encode_webp(picture, kQuality))},
         {"ids", run_lengths(render_ids(segmentation, scene.cloud, camera).data)}});
  }
  return {{"title", scene.source.filename().string()},
          {"things", shown_things(run)},
          {"views", views},
          {"marks", marks_json(marks)},
          {"maxGrow", Gesture::kMaxGrow}};
}

LocalServer::Page choose_page(const json& data) {
  std::string html(choose_template());
  fill_mark(html, "/*CHOOSE_STYLE*/", std::string(choose_style()));
  fill_mark(html, "/*SCRIPT*/", in_script(std::string(choose_script())));
  fill_mark(html, "/*DATA*/", json_in_script(data));
  return styled_page(std::move(html));
}

LocalServer::Page styled_page(std::string html) {
  fill_mark(html, "/*STYLE*/", std::string(pages_style()));
  return {
      "text/html; charset=utf-8", std::move(html),
      "default-src 'none'; connect-src 'self'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; "
      "frame-ancestors 'none'"};
}

}  // namespace pliant
