// Objects found with no masks and no prompts:
//   automatic_study OUT_FOLDER NAME=SCENE ...
// Writes a sheet of ids per scene.  Where selection_truth.json has an object of that name, IoU: of the found object
// that fits best, by pixels over 12 views of another orbit with a rendered membership above 0.5, as selection_study.

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "gaussians/base/orbit.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/scene/scene.h"
#include "gaussians/render/render.h"
#include "segmentation/discover/automatic.h"
#include "segmentation/sheets/objects_sheet.h"
#include "tests/studies/selection_truth.h"

using namespace pliant;

namespace {

std::vector<uint8_t> rendered(const GaussianCloud& cloud, const Camera& camera, const std::vector<float>& membership) {
  const RenderResult picture = render(cloud, camera, {}, membership, 1);
  std::vector<uint8_t> mask(picture.features.data.size());
  for (size_t i = 0; i < mask.size(); ++i) mask[i] = picture.features.data[i] > 0.5f;
  return mask;
}

std::vector<float> membership_of(const std::vector<uint32_t>& label, uint32_t id) {
  std::vector<float> membership(label.size());
  for (size_t p = 0; p < label.size(); ++p) membership[p] = label[p] == id;
  return membership;
}

/// Six views, with ids laid over the lower ones.
ImageF sheet_of(const Scene& scene, const std::vector<uint32_t>& label, uint32_t rest) {
  constexpr int kViews = 3;
  constexpr double kScale = 0.6;
  const Camera first = scene.cameras[0].scaled(kScale);
  ImageF sheet(kViews * first.width, 2 * first.height, 3);
  for (int k = 0; k < kViews; ++k) {
    const Camera camera = scene.cameras[k * scene.cameras.size() / kViews].resized(first.width, first.height);
    const BlendWeights weights = blend_weights(scene.cloud, camera);
    IdImage ids(camera.width, camera.height, 1);
    for (size_t i = 0; i < weights.pixels(); ++i) {
      std::vector<float> sum(rest + 1, 0.0f);
      for (uint32_t e = weights.row_start[i]; e < weights.row_start[i + 1]; ++e)
        sum[label[weights.gaussian[e]]] += weights.weight[e];
      const auto best = std::max_element(sum.begin(), sum.end());
      if (*best > 0.2f) ids.data[i] = static_cast<uint32_t>(best - sum.begin());
    }
    const ImageF color = render(scene.cloud, camera).color, overlay = overlay_ids(color, ids, 0.6f);
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x)
        for (int c = 0; c < 3; ++c) {
          sheet(k * camera.width + x, y, c) = color(x, y, c);
          sheet(k * camera.width + x, camera.height + y, c) = overlay(x, y, c);
        }
  }
  return sheet;
}

void score(const nlohmann::json& entry, const Scene& scene, const AutomaticResult& result) {
  const std::vector<uint8_t> inside = inside_solid(entry.at("solid"), scene.cloud);
  OrbitOptions orbit;
  orbit.views = 48;
  orbit.elevations = {0, 15, 0, 30};
  const std::vector<Camera> all = orbit_cameras(orbit, scene.cloud, scene.up);
  for (const FoundThing& thing : result.found) {
    if (thing.kind != FoundThing::Kind::kObject) continue;
    double sum = 0, least = 1;
    for (int k = 0; k < 12; ++k) {
      const Camera& camera = all[4 * k + 1 + 2 * (k % 2)];
      const auto truth = rendered(scene.cloud, camera, {inside.begin(), inside.end()});
      const auto mask = rendered(scene.cloud, camera, membership_of(result.label, thing.id));
      size_t both = 0, either = 0;
      for (size_t i = 0; i < mask.size(); ++i) {
        both += mask[i] && truth[i];
        either += mask[i] || truth[i];
      }
      const double iou = either ? static_cast<double>(both) / static_cast<double>(either) : 1;
      sum += iou / 12;
      least = std::min(least, iou);
    }
    if (sum > 0.1) std::printf("  %s: IoU with the truth %.3f (least %.3f)\n", thing.name.c_str(), sum, least);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return std::fprintf(stderr, "usage: %s OUT_FOLDER NAME=SCENE ...\n", argv[0]), 2;
  const std::filesystem::path out = argv[1], here = std::filesystem::path(PLIANT_SOURCE_DIR) / "tests/studies";
  std::filesystem::create_directories(out);
  const auto truths = nlohmann::json::parse(std::ifstream(here / "selection_truth.json"));
  for (int a = 2; a < argc; ++a) {
    const std::string text = argv[a], name = text.substr(0, text.find('='));
    const std::string source = text.substr(text.find('=') + 1);
    const Scene scene = load_scene(source, {});
    AutomaticOptions options;
    options.up = scene.up.cast<float>();
    options.solid.footprint.render.antialiased = scene.report.antialiased;
    const AutomaticResult result = find_objects(options, scene.cloud, scene.cameras);
    std::printf("%s: %s (%.1f s)\n", name.c_str(), result.summary.describe().c_str(), result.summary.seconds);
    for (const FoundThing& thing : result.found) {
      size_t count = 0;
      for (uint32_t id : result.label) count += id == thing.id;
      std::printf("  %2u %-10s %6.2f %% %7zu  %s\n", thing.id, thing.name.c_str(), 100 * thing.share, count,
                  thing.how.c_str());
    }
    write_image(out / (name + ".png"), sheet_of(scene, result.label, result.found.back().id));
    if (truths.contains(name)) score(truths.at(name), scene, result);
    std::fflush(stdout);
  }
}
