#include "app/choose/marks.h"

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/segment/object_source.h"
#include "gaussians/base/error.h"

namespace pliant {
using nlohmann::json;

namespace {

/// Where the camera is in a text of which it is the word `at`.
std::pair<size_t, size_t> camera_word(const std::string& text, size_t at) {
  const size_t begin = at == 0 ? 0 : text.find(',') + 1;
  return {begin, std::min(text.find(',', begin), text.size())};
}

/// With '#' in front of the number of the camera: the name of another may be a number.
std::string numbered(std::string text, size_t at) {
  const auto [begin, end] = camera_word(text, at);
  if (end != begin && end < text.size() && text.find_first_not_of("0123456789", begin) == end) text.insert(begin, "#");
  return text;
}

/// With the number of the camera in the place of its name, which may hold commas.
std::string with_camera(std::string text, size_t at, const std::vector<Camera>& cameras, int camera) {
  const auto [begin, end] = camera_word(text, at);
  const std::string named = cameras[camera].name + ",";
  const size_t length = text.compare(begin, named.size(), named) == 0 ? named.size() - 1 : end - begin;
  return text.replace(begin, length, std::to_string(camera));
}

/// The name that edits have given to the selection; none where they have changed anything else.
std::optional<std::string> name_by(const json& edits) {
  std::string name;
  for (const json& edit : edits) {
    const std::string text = edit.value("value", ""), object = text.substr(0, text.find('='));
    if (edit.value("option", "") != "--name" || object.size() == text.size()) return std::nullopt;
    if (object != std::to_string(SelectionShape::kObject) && object != (name.empty() ? "object" : name))
      return std::nullopt;
    name = text.substr(object.size() + 1);
  }
  return name;
}

/// The marks of a stage in cameras of the scene, which are named or numbered.
Marks marks_in_cameras(const SegmentStage& stage, const std::vector<Camera>& cameras) {
  Marks marks;
  Gesture gesture;
  const float width = static_cast<float>(stage.stroke_width);
  for (const std::string& text : stage.boxes) {
    add_box(text, cameras, gesture);
    marks.push_back({"box", with_camera(text, 0, cameras, gesture.boxes.back().camera)});
  }
  for (const std::string& text : stage.clicks) {
    add_click(text, cameras, width, gesture);
    marks.push_back({"click", with_camera(text, 0, cameras, gesture.strokes.back().camera)});
  }
  for (const std::string& text : stage.strokes) {
    add_stroke(text, cameras, width, gesture);
    marks.push_back({"stroke", with_camera(text, 1, cameras, gesture.strokes.back().camera)});
  }
  for (int k = 0; k < std::abs(stage.grow); ++k) marks.push_back({"grow", stage.grow > 0 ? "1" : "-1"});
  return marks;
}

}  // namespace

SegmentStage segment_by(const Marks& marks) {
  SegmentStage stage;
  for (const auto& [kind, text] : marks) {
    if (kind == "box") {
      const std::string box = numbered(text, 0), camera = box.substr(0, camera_word(box, 0).second);
      std::erase_if(stage.boxes, [&](const std::string& other) { return other.starts_with(camera + ","); });
      stage.boxes.push_back(box);
    } else if (kind == "stroke") {
      stage.strokes.push_back(numbered(text, 1));
    } else if (kind == "grow") {
      stage.grow += std::atoi(text.c_str());
    } else if (stage.strokes.empty()) {
      stage.clicks.push_back(numbered(text, 0));
    } else {  // strokes count after clicks
      stage.strokes.push_back("fg," + numbered(text, 0));
    }
  }
  return stage;
}

bool share_one(const Marks& a, const Marks& b) {
  return std::find_first_of(a.begin(), a.end(), b.begin(), b.end(),
                            [](const Mark& x, const Mark& y) { return x == y && x.kind != "grow"; }) != a.end();
}

json marks_json(const Marks& marks) {
  json out = json::array();
  for (const Mark& mark : marks) out.push_back({{"kind", mark.kind}, {"text", mark.text}});
  return out;
}

MadeSelection made_selection(const RunDirectory& run, const Scene& scene) {
  if (!run.has("segment")) return {};
  const json record = run.last_record("segment");
  const auto outputs = record.value("outputs", std::vector<std::string>());
  if (std::find(outputs.begin(), outputs.end(), "selection.png") == outputs.end() ||
      record.value("found", json::object()).contains("stroke_sides"))
    return {};
  SegmentStage stage;
  take_recorded(record.at("options"), options_of(stage));
  const std::optional<std::string> name = name_by(run.note("edits"));
  if (selection_of(stage) || stage.stroke_width != SegmentStage().stroke_width || !name) return {};
  try {
    return {marks_in_cameras(stage, scene.cameras), *name};
  } catch (const Error&) {
    return {};  // of cameras that the scene has no more
  }
}

}  // namespace pliant
