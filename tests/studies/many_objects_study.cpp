// A plane with SIDE x SIDE balls at 1200 x 900, end to end from id masks written as PNG:
//   many_objects_study OUT_FOLDER [SIDE=20 [VIEWS=24 [WIDTH=1200 [CASE [ITERATIONS]]]]]
// OUT_FOLDER becomes a scene that `pliant segment` takes too.  The masks' ids are shuffled in every view in the second
// case. OUT_FOLDER/truth holds the true ids of every 8th photo, for
//   pliant segment OUT_FOLDER --hold-out --out RUN;  pliant evaluate segmentation RUN/held_out OUT_FOLDER/truth --band
//   2
// CASE: clean, shuffled, or write, where only the folder is made; both cases without it.  Scores are on every 8th
// photo, never learnt from, for objects of at least 300 px in it.  Prints JSON.

#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/render/render.h"
#include "segmentation/associate/associate.h"
#include "segmentation/field/islands.h"
#include "segmentation/field/semantic_field.h"
#include "segmentation/labels/agreement.h"
#include "tests/segmentation/made_scene.h"

using namespace pliant;
using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Objects of fewer than `least` pixels are left out of the truth.
IdImage without_small(IdImage ids, size_t least) {
  std::map<uint32_t, size_t> pixels;
  for (uint32_t id : ids.data) ++pixels[id];
  for (uint32_t& id : ids.data)
    if (pixels[id] < least) id = 0;
  return ids;
}

Json score(const MadeScene& scene, const std::vector<int>& held_out, const Segmentation& segmentation) {
  std::vector<IdImage> truth, predicted;
  std::vector<std::vector<uint32_t>> labels;
  for (int c : held_out) {
    truth.push_back(without_small(cast_ids(scene, scene.cameras[c]), 300));
    predicted.push_back(render_ids(segmentation, scene.cloud, scene.cameras[c]));
  }
  OverlapMatch overlap;  // ids of associated masks have no meaning of their own
  for (size_t v = 0; v < truth.size(); ++v) overlap.add(predicted[v].data, truth[v].data);
  const std::map<uint32_t, uint32_t> match = overlap.match();
  for (IdImage& ids : predicted)
    for (uint32_t& id : ids.data) id = match.count(id) ? match.at(id) : 0;
  const IdAgreement whole = id_agreement(predicted, truth), edge = boundary_agreement(predicted, truth, 2);
  size_t right = 0;
  std::set<uint32_t> found;
  for (size_t p = 0; p < scene.truth.size(); ++p) {
    const auto at = match.find(segmentation.label[p]);
    if (at != match.end() && at->second == scene.truth[p]) {
      ++right;
      found.insert(scene.truth[p]);
    }
  }
  double worst = 1;
  for (const auto& [id, iou] : whole.iou) worst = std::min(worst, iou);
  return {{"classes", segmentation.class_id.size()},
          {"objects_found", found.size()},
          {"objects_scored", whole.iou.size()},
          {"miou", whole.mean},
          {"worst_iou", worst},
          {"boundary_miou", edge.mean},
          {"gaussians_right", static_cast<double>(right) / scene.truth.size()}};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2)
    return std::fprintf(stderr, "usage: %s OUT_FOLDER [SIDE [VIEWS [WIDTH [CASE [ITERATIONS]]]]]\n", argv[0]), 2;
  const fs::path out = argv[1];
  const int side = argc > 2 ? std::atoi(argv[2]) : 20, views = argc > 3 ? std::atoi(argv[3]) : 24,
            width = argc > 4 ? std::atoi(argv[4]) : 1200;
  const std::string only = argc > 5 ? argv[5] : "";
  const float ball_step = 0.06f * 1.9f / static_cast<float>(side);
  const MadeScene scene = made_scene(grid_of_balls(side), views, width, width * 3 / 4, 0.012f, ball_step);
  Json json = {{"balls", side * side}, {"gaussians", scene.cloud.size()}, {"views", views}, {"width", width}};

  fs::create_directories(out / "masks");
  write_ply(out / "splats.ply", scene.cloud);
  write_transforms(out / "transforms.json", scene.cameras);
  write_text(out / "scene.json",
             R"({"splats": "splats.ply", "cameras": "transforms.json", "masks": "masks", "up": [0, 0, 1]})");
  fs::create_directories(out / "truth");
  for (int c = 0; c < views; ++c) {
    const IdImage ids = cast_ids(scene, scene.cameras[c]);
    write_ids(out / "masks" / (scene.cameras[c].name + ".png"), ids);
    if (c % 8 == 0) write_ids(out / "truth" / (scene.cameras[c].name + ".png"), without_small(ids, 300));
  }
  if (only == "write") return 0;

  SemanticOptions options;
  if (argc > 6) options.iterations = std::atoi(argv[6]);
  for (int c = 0; c < views; c += 8) options.held_out.push_back(c);
  const MaskSet masks = load_masks(out / "masks", "", scene.cameras);
  for (const bool shuffled : {false, true}) {
    if (!only.empty() && only != (shuffled ? "shuffled" : "clean")) continue;
    MaskSet used = masks;
    Json entry;
    const double start = now();
    if (shuffled) {
      for (MaskSet::View& view : used.views)
        for (uint32_t& id : view.ids.data)
          if (id != 0) id = 1 + (id * 2654435761u + static_cast<uint32_t>(view.camera) * 40503u) % 8000000u;
      AssociateOptions associated;
      associated.held_out = options.held_out;
      AssociateResult result = associate(associated, scene.cloud, scene.cameras, used);
      used = std::move(result.masks);
      entry["association_seconds"] = now() - start;
    }
    const double middle = now();
    SemanticResult result = fit_semantic_field(options, scene.cloud, scene.cameras, used);
    merge_islands({}, scene.cloud, result.segmentation);
    entry["attribute_seconds"] = now() - middle;
    entry["cached_megabytes"] = result.summary.cached_bytes >> 20;
    const double rendering = now();
    render_ids(result.segmentation, scene.cloud, scene.cameras[0]);
    entry["id_picture_seconds"] = now() - rendering;
    entry.update(score(scene, options.held_out, result.segmentation));
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    entry["peak_megabytes"] = usage.ru_maxrss / 1024;
    json[shuffled ? "shuffled" : "clean"] = entry;
  }
  std::printf("%s\n", json.dump(1).c_str());
}
