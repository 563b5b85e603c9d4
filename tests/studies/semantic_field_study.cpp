// The semantic attribute, extraction and repair on the demo scene:
//   semantic_field_study SCENE_FOLDER [OUT_FOLDER [SEED]]
// SCENE_FOLDER is made with that seed when it does not exist.  mIoU is on every 8th photo, which is never optimised on;
// "missing" erases 20 % of the masks (an id in a photo).  Prints JSON; pictures go to OUT_FOLDER.

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "app/demo/make_demo.h"
#include "gaussians/base/random.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/scene/scene.h"
#include "segmentation/field/semantic_field.h"
#include "segmentation/objects/extract.h"
#include "segmentation/repair/repair.h"
#include "segmentation/sheets/objects_sheet.h"

using namespace pliant;
using Json = nlohmann::ordered_json;

namespace {

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Erases a fifth of the masks.
MaskSet with_missing(MaskSet masks) {
  for (MaskSet::View& view : masks.views) {
    std::set<uint32_t> gone;
    for (uint32_t id : std::set<uint32_t>(view.ids.data.begin(), view.ids.data.end()))
      if (Random(11, view.camera, id).uniform() < 0.2) gone.insert(id);
    for (uint32_t& id : view.ids.data)
      if (gone.count(id)) id = 0;
  }
  return masks;
}

struct Study {
  Scene scene;
  MaskSet masks;
  std::vector<int> held_out;
  std::vector<IdImage> truth;

  Json measure(const MaskSet& training, bool vote, int iterations, double rate, Segmentation* out = nullptr) const {
    SemanticOptions options;
    options.start_from_vote = vote;
    options.iterations = iterations;
    options.held_out = held_out;
    if (rate > 0) options.attribute_rate = rate;
    const double start = now();
    SemanticResult result = fit_semantic_field(options, scene.cloud, scene.cameras, training);
    const double seconds = now() - start;
    std::vector<IdImage> predicted;
    for (int camera : held_out)
      predicted.push_back(render_ids(result.segmentation, scene.cloud, scene.cameras[camera]));
    const IdAgreement agreement = id_agreement(predicted, truth);
    Json json = {{"miou", agreement.mean},
                 {"seconds", seconds},
                 {"iterations", iterations},
                 {"cross_entropy", result.summary.cross_entropy},
                 {"grouping", result.summary.grouping},
                 {"unseen", result.summary.unseen},
                 {"cached_megabytes", result.summary.cached_bytes >> 20}};
    for (const auto& [id, iou] : agreement.iou) json["iou"][masks.name_of(id)] = iou;
    if (out) *out = std::move(result.segmentation);
    return json;
  }
};

float luminance(const float* rgb) { return 0.299f * rgb[0] + 0.587f * rgb[1] + 0.114f * rgb[2]; }

/// Largest distance of a hole's mean luminance from that of its ring (6 pixels), in standard deviations of the ring.
double luminance_deviation(const RepairResult& result, const GaussianCloud& background, const GaussianCloud& object,
                           const std::vector<Camera>& cameras) {
  const Observation observation = observe({}, background, object, cameras, result.summary.views);
  double worst = 0;
  for (size_t v = 0; v < result.summary.views.size(); ++v) {
    const HoleView before = find_hole({}, observation, v, background, cameras);
    if (before.pixels < 50) continue;
    const ImageF after = render(result.background, cameras[result.summary.views[v]]).color;
    double hole = 0, sum = 0, squares = 0;
    size_t inside = 0, ring = 0;
    for (int y = 0; y < after.height; ++y)
      for (int x = 0; x < after.width; ++x) {
        const double l = luminance(after.at(x, y));
        if (before.hole(x, y)) {
          hole += l;
          ++inside;
          continue;
        }
        bool near = false;
        for (int j = std::max(0, y - 6); j <= std::min(after.height - 1, y + 6) && !near; ++j)
          for (int i = std::max(0, x - 6); i <= std::min(after.width - 1, x + 6) && !near; ++i)
            near = before.hole(i, j);
        if (near) {
          sum += l;
          squares += l * l;
          ++ring;
        }
      }
    const double mean = sum / ring, sigma = std::sqrt(std::max(1e-8, squares / ring - mean * mean));
    worst = std::max(worst, std::abs(hole / inside - mean) / sigma);
  }
  return worst;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: %s SCENE_FOLDER [OUT_FOLDER [SEED]]\n", argv[0]), 2;
  const std::filesystem::path folder = argv[1], out = argc > 2 ? argv[2] : ".";
  if (!std::filesystem::exists(folder)) {
    DemoOptions demo;
    demo.out = folder;
    demo.video = false;
    if (argc > 3) demo.seed = std::stoull(argv[3]);
    make_demo(demo);
  }
  std::filesystem::create_directories(out);
  Study study;
  study.scene = load_scene(folder);
  const Scene& scene = study.scene;
  study.masks = load_masks(scene.settings.masks, scene.settings.labels, scene.cameras);
  for (const MaskSet::View& view : study.masks.views)
    if (view.camera % 8 == 0) {
      study.held_out.push_back(view.camera);
      study.truth.push_back(view.ids);
    }

  Json json = {{"gaussians", scene.cloud.size()}, {"views", study.masks.views.size()}};
  const MaskSet missing = with_missing(study.masks);
  Segmentation segmentation;
  json["clean"]["from_random"] = study.measure(study.masks, false, 400, 0.05);
  json["clean"]["vote"] = study.measure(study.masks, true, 0, 0);
  json["clean"]["polished"] = study.measure(study.masks, true, SemanticOptions().iterations, 0, &segmentation);
  json["missing"]["from_random"] = study.measure(missing, false, 400, 0.05);
  json["missing"]["vote"] = study.measure(missing, true, 0, 0);
  json["missing"]["polished"] = study.measure(missing, true, SemanticOptions().iterations, 0);

  double start = now();
  auto photo = [&](int camera) { return read_image(scene.cameras[camera].photo); };
  write_image(out / "objects.png", objects_sheet(segmentation, scene.cloud, scene.cameras, photo));
  json["sheet_seconds"] = now() - start;

  ExtractOptions extract_options;
  extract_options.up = scene.up.cast<float>();
  for (size_t c = 0; c < segmentation.class_id.size(); ++c) {
    if (segmentation.class_name[c] == scene.settings.object) extract_options.object = segmentation.class_id[c];
    if (segmentation.class_name[c] == scene.settings.support) extract_options.support = segmentation.class_id[c];
  }
  start = now();
  const ExtractResult parts = extract(extract_options, scene.cloud, segmentation);
  json["extract"] = {{"seconds", now() - start},
                     {"object", parts.object.size()},
                     {"summary", parts.summary.describe()},
                     {"support", parts.summary.support ? study.masks.name_of(*parts.summary.support) : ""},
                     {"contact", parts.contact.found},
                     {"touching", parts.contact.touching},
                     {"band", {parts.contact.band_low, parts.contact.band_high}},
                     {"thickness", parts.contact.thickness},
                     {"size", parts.contact.size}};
  const GaussianCloud object = scene.cloud.select(parts.object), background = scene.cloud.select(parts.background);
  const RepairResult repaired = repair({}, background, object, scene.cameras);
  json["repair"] = {{"seconds", repaired.summary.seconds},
                    {"summary", repaired.summary.describe()},
                    {"before", repaired.summary.hole_before},
                    {"after", repaired.summary.hole_after},
                    {"outside_change", repaired.summary.outside_change},
                    {"unobserved", repaired.summary.unobserved},
                    {"luminance_sigma", luminance_deviation(repaired, background, object, scene.cameras)}};
  write_image(out / "repair.png", repair_sheet(repaired, background, object, scene.cameras));
  for (int camera : {5, 15, 25, 35})
    if (camera < static_cast<int>(scene.cameras.size()))
      write_image(out / ("repaired_" + std::to_string(camera) + ".png"),
                  render(repaired.background, scene.cameras[camera]).color);
  std::printf("%s\n", json.dump(1).c_str());
}
