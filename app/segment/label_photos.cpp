#include "app/segment/label_photos.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/segment/interruption.h"
#include "app/segment/photo_or_render.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "segmentation/labelling/flow_tracker.h"
#include "segmentation/labelling/label_overlay.h"
#include "segmentation/labelling/label_set.h"
#include "segmentation/labelling/label_tracker.h"
#include "segmentation/sheets/objects_sheet.h"

namespace pliant {
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

std::vector<std::string> names_in(const std::string& text) {
  std::vector<std::string> names;
  std::istringstream in(text);
  for (std::string name; std::getline(in, name, ',');) {
    const size_t begin = name.find_first_not_of(" ."), end = name.find_last_not_of(" .");
    if (begin != std::string::npos) names.push_back(name.substr(begin, end - begin + 1));
  }
  return names;
}

LabelOptions label_options(const LabelStage& stage) {
  LabelOptions options;
  options.names = names_in(stage.text);
  if (stage.models.segmenter.empty()) options.everything = EverythingOptions::weight_free();
  return options;
}

/// What is known of one photo, as it is kept on disk: the record is written last.
void write_photo(const fs::path& stem, const std::string& key, const LabelledPhoto& photo) {
  write_ids(fs::path(stem).concat(".png"), photo.ids);
  json things = json::array();
  for (const LabelledThing& thing : photo.things)
    things.push_back({{"id", thing.id},
                      {"name", thing.name},
                      {"score", thing.score},
                      {"pixels", thing.pixels},
                      {"box", {thing.box.x0, thing.box.y0, thing.box.x1, thing.box.y1}}});
  write_text(fs::path(stem).concat(".json"),
             json{{"key", key}, {"things", things}, {"said", photo.said}}.dump(1) + "\n");
}

std::optional<LabelledPhoto> read_photo_labels(const fs::path& stem, const std::string& key) {
  const fs::path record = fs::path(stem).concat(".json"), picture = fs::path(stem).concat(".png");
  if (!fs::exists(record) || !fs::exists(picture)) return std::nullopt;
  const json read = json::parse(read_text(record), nullptr, false);
  if (read.is_discarded() || read.value("key", "") != key) return std::nullopt;
  LabelledPhoto photo;
  photo.ids = read_ids(picture);
  for (const json& thing : read.at("things")) {
    const auto box = thing.at("box").get<std::vector<float>>();
    photo.things.push_back({thing.at("id"),
                            thing.at("name"),
                            thing.at("score"),
                            {box.at(0), box.at(1), box.at(2), box.at(3)},
                            thing.at("pixels")});
  }
  photo.said = read.at("said").get<std::vector<std::string>>();
  return photo;
}

/// The masks and names that `segment` and a person read.
void write_set(const fs::path& folder, const MaskSet& masks, const std::vector<Camera>& cameras) {
  for (const MaskSet::View& view : masks.views) write_ids(folder / (cameras[view.camera].name + ".png"), view.ids);
  json names = json::object();
  for (const uint32_t id : masks.ids())
    if (masks.names.count(id)) names[std::to_string(id)] = masks.names.at(id);
  write_text(folder / "labels.json", names.dump(1) + "\n");
}

void refuse_nothing(bool nothing, const fs::path& seen) {
  if (nothing)
    throw input_error(seen.string(), "", "nothing was found in any of the photos",
                      "look for something else with --text, try --everything, or give --masks FOLDER");
}

constexpr int kLookEvery = 8;  // photos of a sequence at which the chain looks again

/// The photos as a sequence, see photo_sequence; cannot go on where it was killed, because each photo needs the one
/// before.
MaskSet tracked_labels(const Context& context, const Scene& scene, const LabelOptions& options, const LabelStage& stage,
                       const fs::path& seen) {
  const OpenLabelModels open = open_label_models(stage.models);
  std::unique_ptr<Tracker> tracker = make_tracker(stage.models);
  if (!tracker) tracker = std::make_unique<FlowTracker>();
  LabelTracker labels(options, open.models(), *tracker, kLookEvery);
  MaskSet masks;
  context.progress.begin("label", static_cast<int>(scene.cameras.size()));
  for (const int c : photo_sequence(scene.cameras)) {
    stop_if_interrupted(context, "label");
    const ImageF picture = photo_or_render(scene, c);
    masks.views.push_back({c, labels.next(picture)});
    if (masks.views.size() == 1)
      for (const std::string& sentence : labels.said()) context.progress.say("label: " + sentence);
    write_image(seen / (scene.cameras[c].name + ".jpg"), overlay_ids(picture, masks.views.back().ids));
    context.progress.done(static_cast<int>(masks.views.size()));
  }
  context.progress.end();
  masks.names = labels.names();
  refuse_nothing(masks.ids().empty(), seen);
  if (stage.everything) return masks;
  uint32_t rest = 1;
  for (const uint32_t id : masks.ids()) rest = std::max(rest, id + 1);
  for (MaskSet::View& view : masks.views) std::replace(view.ids.data.begin(), view.ids.data.end(), 0u, rest);
  masks.names[rest] = "rest";
  return masks;
}

json label_photos(const Context& context, const RunDirectory& run, const StageInputs<LabelStage>& in,
                  const std::string& provenance) {
  const Scene& scene = in.scene;
  const LabelStage& stage = in.options;
  const LabelOptions options = label_options(stage);
  const fs::path folder = run / "labelled";
  fs::create_directories(folder / "photos");
  fs::create_directories(folder / "seen");
  if (stage.track) {
    const MaskSet masks = tracked_labels(context, scene, options, stage, folder / "seen");
    write_set(folder, masks, scene.cameras);
    context.progress.say(fmt::format("label: {} objects tracked through {} photos; see {}", masks.ids().size(),
                                     masks.views.size(), (folder / "seen").string()));
    return {{"photos", masks.views.size()}, {"things", masks.ids().size()}};
  }
  OpenLabelModels open;
  const std::string record = sha256_of_text(provenance);
  std::vector<int> cameras;
  std::vector<LabelledPhoto> photos;
  std::map<std::string, int> times;
  context.progress.begin("label", static_cast<int>(scene.cameras.size()));
  for (int c = 0; c < static_cast<int>(scene.cameras.size()); ++c) {
    if (context.interrupted())
      throw Error(Failure::kInterrupted, "label", "", "interrupted", "run the same command to continue");
    const std::string& name = scene.cameras[c].name;
    std::optional<LabelledPhoto> photo;
    if (!context.overwrite) photo = read_photo_labels(folder / "photos" / name, record);
    if (!photo) {
      if (!open.segmenter) open = open_label_models(stage.models);
      const ImageF picture = photo_or_render(scene, c);
      photo = label_photo(options, open.models(), picture);
      write_image(folder / "seen" / (name + ".jpg"), overlay_labels(picture, *photo));
      write_photo(folder / "photos" / name, record, *photo);
    }
    if (c == 0)
      for (const std::string& sentence : photo->said) context.progress.say("label: " + sentence);
    for (const LabelledThing& thing : photo->things) ++times[thing.name.empty() ? "things" : thing.name];
    cameras.push_back(c);
    photos.push_back(std::move(*photo));
    context.progress.done(c + 1);
  }
  context.progress.end();
  refuse_nothing(times.empty(), folder / "seen");
  write_set(folder, gather_labels({.rest = !stage.everything}, cameras, photos), scene.cameras);
  std::string found;
  for (const auto& [name, count] : times) found += fmt::format("{}{} {}", found.empty() ? "" : ", ", count, name);
  context.progress.say(fmt::format("label: {} photos: {}; see {}", photos.size(), found, (folder / "seen").string()));
  return {{"photos", photos.size()}, {"things", times}};
}

}  // namespace

StageInputs<LabelStage> inputs_of(const RunDirectory&, const Scene& scene, const LabelStage& stage) {
  StageInputs<LabelStage> in;
  in.options = stage;
  in.parts = {ScenePart::kCameras, ScenePart::kPhotos};
  if (!all_photographed(scene)) in.parts.insert(ScenePart::kSplats);
  in.scene = only(in.parts, scene);
  add_files(stage.models, in.files);
  in.outputs = {"labelled/labels.json"};
  for (const Camera& camera : scene.cameras) in.outputs.push_back("labelled/" + camera.name + ".png");
  return in;
}

json run_label(const Context& context, RunDirectory& run, const Scene& scene, const LabelStage& stage) {
  return run_stage(context, run, inputs_of(run, scene, stage), label_photos);
}

}  // namespace pliant
