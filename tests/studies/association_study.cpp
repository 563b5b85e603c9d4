// Association of masks and the attribute that follows, on a demo scene with known truth:
//   association_study SCENE_FOLDER [CASE ...]
// Every case damages the clean masks of all but every 8th photo, associates, fits the attribute with frozen geometry
// and scores the held-out photos (true masks, never looked at).  "rerasterised" recomputes the blend weights in every
// iteration.  Prints JSON.

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "gaussians/io/scene/scene.h"
#include "segmentation/associate/associate.h"
#include "segmentation/field/islands.h"
#include "segmentation/field/semantic_field.h"
#include "segmentation/labels/agreement.h"
#include "tests/studies/mask_damage.h"

using namespace pliant;
using Json = nlohmann::ordered_json;

namespace {

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

struct Study {
  Scene scene;
  MaskSet masks;  ///< of the photos that are not held out
  std::vector<int> held_out;
  std::vector<IdImage> truth;

  Json score(const Segmentation& segmentation) const {
    std::vector<IdImage> predicted;
    for (int camera : held_out) predicted.push_back(render_ids(segmentation, scene.cloud, scene.cameras[camera]));
    predicted = with_true_ids(std::move(predicted), truth);
    const IdAgreement whole = id_agreement(predicted, truth), edge = boundary_agreement(predicted, truth, 2);
    Json json = {{"miou", whole.mean}, {"boundary_miou", edge.mean}, {"ids", segmentation.class_id.size()}};
    for (const auto& [id, iou] : whole.iou) json["iou"][masks.name_of(id)] = {iou, edge.iou.at(id)};
    return json;
  }

  Json measure(const MaskSet& training, bool with_association, SemanticOptions options = {}) const {
    MaskSet used = training;
    Json json;
    double seconds = 0;
    if (with_association) {
      const double start = now();
      AssociateResult result = associate({}, scene.cloud, scene.cameras, training);
      seconds = now() - start;
      json["association"] = {{"seconds", seconds},
                             {"summary", result.summary.describe()},
                             {"consistency", result.summary.consistency},
                             {"groups", result.summary.groups},
                             {"pixels", pixels(result.masks)}};
      used = std::move(result.masks);
    }
    const double start = now();
    SemanticResult result = fit_semantic_field(options, scene.cloud, scene.cameras, used);
    merge_islands({}, scene.cloud, result.segmentation);
    json["attribute_seconds"] = now() - start;
    json["seconds"] = seconds + now() - start;
    json.update(score(result.segmentation));
    return json;
  }

  /// Agreement of associated masks with the true ones, pixel by pixel where they are labelled.
  Json pixels(const MaskSet& associated) const {
    std::vector<IdImage> ours, theirs;
    for (const MaskSet::View& view : associated.views)
      for (const MaskSet::View& own : masks.views)
        if (own.camera == view.camera) {
          ours.push_back(view.ids);
          theirs.push_back(own.ids);
        }
    const auto match = match_by_overlap(ours, theirs);
    size_t right = 0, wrong = 0, empty = 0;
    for (size_t v = 0; v < ours.size(); ++v)
      for (size_t i = 0; i < ours[v].data.size(); ++i) {
        const uint32_t id = ours[v].data[i];
        if (id == 0)
          ++empty;
        else if (match.count(id) && match.at(id) == theirs[v].data[i])
          ++right;
        else
          ++wrong;
      }
    return {{"right", right}, {"wrong", wrong}, {"unlabelled", empty}};
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: %s SCENE_FOLDER [CASE ...]\n", argv[0]), 2;
  Study study;
  study.scene = load_scene(argv[1]);
  MaskSet all = load_masks(study.scene.settings.masks, study.scene.settings.labels, study.scene.cameras);
  study.masks.names = all.names;
  uint32_t away = 0;
  for (const auto& [id, name] : all.names)
    if (name == "mug") away = id;
  for (MaskSet::View& view : all.views) {
    if (view.camera % 8 == 0) {
      study.held_out.push_back(view.camera);
      study.truth.push_back(view.ids);
    } else
      study.masks.views.push_back(std::move(view));
  }
  const std::vector<std::string> wanted(argv + 2, argv + argc);
  Json json = {{"gaussians", study.scene.cloud.size()}, {"views", study.masks.views.size()}};
  const auto run = [&](const std::string& name, auto&& measure) {
    if (!wanted.empty() && !std::count(wanted.begin(), wanted.end(), name)) return;
    json[name] = measure();
    std::fprintf(stderr, "%s: %.4f %.4f, %.1f s\n", name.c_str(), json[name]["miou"].get<double>(),
                 json[name]["boundary_miou"].get<double>(), json[name]["seconds"].get<double>());
  };
  run("clean", [&] { return study.measure(study.masks, false); });
  run("clean_associated", [&] { return study.measure(study.masks, true); });
  const std::pair<const char*, MaskDamage> cases[] = {
      {"shuffled", {.shuffle = true}},
      {"permuted", {.shuffle = true, .permute = true}},
      {"missing", {.shuffle = true, .missing = 0.2}},
      {"merged_or_split", {.shuffle = true, .merged_or_split = 0.1}},
      {"away", {.shuffle = true, .away = away}},
      {"all", {.shuffle = true, .missing = 0.2, .merged_or_split = 0.1, .away = away}},
      {"all_permuted", {.shuffle = true, .missing = 0.2, .merged_or_split = 0.1, .away = away, .permute = true}},
      {"all_other_damage", {.shuffle = true, .missing = 0.2, .merged_or_split = 0.1, .away = away, .seed = 77}},
  };
  for (const auto& [name, damage] : cases) run(name, [&] { return study.measure(damaged(study.masks, damage), true); });
  run("forty_damages",
      [&] {  // association alone: which share of labelled pixels is wrong, and whether all objects are found
        Json out = {{"miou", 1.0}, {"boundary_miou", 1.0}, {"seconds", 0.0}};
        for (uint64_t seed = 1; seed <= 40; ++seed) {
          const MaskDamage damage{
              .shuffle = true,
              .missing = 0.2,
              .merged_or_split = 0.1,
              .away = all.names.empty() ? 0 : std::next(all.names.begin(), seed % all.names.size())->first,
              .seed = seed};
          const AssociateResult result =
              associate({}, study.scene.cloud, study.scene.cameras, damaged(study.masks, damage));
          const Json pixels = study.pixels(result.masks);
          const double wrong = pixels["wrong"], right = pixels["right"];
          out["objects"].push_back(result.summary.groups);
          out["wrong"].push_back(wrong / (wrong + right));
        }
        return out;
      });
  run("all_not_associated", [&] { return study.measure(damaged(study.masks, cases[5].second), false); });
  run("rerasterised", [&] {
    SemanticOptions options;
    options.memory_bytes = 0;
    return study.measure(study.masks, false, options);
  });
  std::printf("%s\n", json.dump(1).c_str());
}
