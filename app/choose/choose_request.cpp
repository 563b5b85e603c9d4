#include "app/choose/choose_request.h"

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "app/live/message_fields.h"
#include "gaussians/io/files/utf8.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr size_t kMostMarks = 1000;
constexpr size_t kLongestMark = 20'000;  // bytes
constexpr size_t kLongestLabel = 100;    // characters
constexpr size_t kBytesOfCharacter = 4;  // at most, in UTF-8
constexpr const char* kDescribed = "app/choose/chooser.h";
constexpr int kMostCameras = 1'000'000;

/// The list in a field; empty where it is left out.
json list_in(const json& select, const char* field) {
  if (!select.contains(field)) return json::array();
  if (!select[field].is_array()) throw refused_request(field, "is not a list of marks");
  if (select[field].size() > kMostMarks)
    throw refused_request(field, "has more than " + std::to_string(kMostMarks) + " marks");
  return select[field];
}

Mark mark_of(const json& value) {
  if (!value.is_object() || value.size() != 2 || !value.contains("kind") || !value.contains("text"))
    throw refused_request("marks", "has one without a kind and a text");
  Mark mark{short_text(value["kind"], "kind", kLongestMark), short_text(value["text"], "text", kLongestMark)};
  if (mark.kind == "grow")
    whole_number(json::parse(mark.text, nullptr, false), "grow", -Gesture::kMaxGrow, Gesture::kMaxGrow);
  else if (mark.kind != "box" && mark.kind != "click" && mark.kind != "stroke")
    throw refused_request("kind", "is none of box, click, stroke and grow");
  return mark;
}

Marks marks_of(const json& select) {
  Marks marks;
  for (const json& value : list_in(select, "marks")) marks.push_back(mark_of(value));
  for (const auto& [field, kind] : {std::pair("boxes", "box"), {"clicks", "click"}, {"strokes", "stroke"}})
    for (const json& text : list_in(select, field)) marks.push_back({kind, short_text(text, field, kLongestMark)});
  if (select.contains("grow")) {
    const int64_t rings = whole_number(select["grow"], "grow", -Gesture::kMaxGrow, Gesture::kMaxGrow);
    if (rings != 0) marks.push_back({"grow", std::to_string(rings)});
  }
  const auto grows = [](const Mark& mark) { return mark.kind == "grow"; };
  if (!marks.empty() && std::all_of(marks.begin(), marks.end(), grows))
    throw refused_request("grow", "has no marks to grow");
  if (std::abs(segment_by(marks).grow) > Gesture::kMaxGrow)
    throw refused_request("grow", "is more than " + std::to_string(Gesture::kMaxGrow) + " rings");
  return marks;
}

/// The object that a request names, with its text in `field`.
void read_object(const json& value, const char* field, ChooseRequest& out) {
  if (!value.is_object() || !value.contains("object")) throw refused_request(field, "names no object");
  out.object = static_cast<uint32_t>(whole_number(value["object"], "object", 0, UINT32_MAX));
  if (!value.contains(field)) return;
  out.label = short_text(value[field], field, kLongestLabel * kBytesOfCharacter);
  if (character_count(out.label) > kLongestLabel)
    throw refused_request(field, "is longer than " + std::to_string(kLongestLabel) + " characters");
}

int camera_number(const json& value, const char* field) {
  return static_cast<int>(whole_number(value, field, 0, kMostCameras));
}

}  // namespace

ChooseRequest parse_choose_request(std::string_view text) {
  const json all = parse_message(text, kDescribed);
  if (all.size() != 1) throw refused_request("", "is not one request");
  const std::string& name = all.begin().key();
  const json& value = all.begin().value();
  ChooseRequest out;
  if (name == "select") {
    if (!value.is_object()) throw refused_request(name, "is not an object");
    out.kind = ChooseRequest::Kind::kSelect;
    out.marks = marks_of(value);
    if (value.contains("camera")) out.camera = camera_number(value["camera"], "camera");
  } else if (name == "hover") {
    if (!value.is_array() || value.size() != 3) throw refused_request(name, "is not a camera and a pixel");
    out.kind = ChooseRequest::Kind::kHover;
    out.camera = camera_number(value[0], "hover");
    out.pixel = Vec2f(finite_number(value[1], "hover"), finite_number(value[2], "hover"));
  } else if (name == "make") {
    out.kind = ChooseRequest::Kind::kMake;
    read_object(value, "label", out);
  } else if (name == "name") {
    out.kind = ChooseRequest::Kind::kName;
    read_object(value, "name", out);
    if (out.label.empty()) throw refused_request(name, "has no name");
  } else if ((name == "find" || name == "cancel") && value == true) {
    out.kind = name == "find" ? ChooseRequest::Kind::kFind : ChooseRequest::Kind::kCancel;
  } else {
    throw refused_request(name, "is not known");
  }
  return out;
}

const char* name_of(ChooseRequest::Kind kind) {
  switch (kind) {
    case ChooseRequest::Kind::kSelect:
      return "select";
    case ChooseRequest::Kind::kFind:
      return "find";
    case ChooseRequest::Kind::kMake:
      return "make";
    case ChooseRequest::Kind::kName:
      return "name";
    case ChooseRequest::Kind::kHover:
      return "hover";
    case ChooseRequest::Kind::kCancel:
      break;
  }
  return "cancel";
}

Error refused_request(const std::string& field, const std::string& problem) {
  return usage_error("message", field, problem, std::string("see ") + kDescribed);
}

}  // namespace pliant
