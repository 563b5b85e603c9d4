#include "app/choose/choose_request.h"

#include <nlohmann/json.hpp>

#include "app/live/message_fields.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr size_t kMostMarks = 200, kLongestMark = 20'000, kLongestLabel = 100;  // characters
constexpr const char* kDescribed = "app/choose/chooser.h";
constexpr int kMostCameras = 1'000'000;

std::vector<std::string> marks_of(const json& select, const char* field) {
  std::vector<std::string> out;
  if (!select.contains(field)) return out;
  if (!select[field].is_array() || select[field].size() > kMostMarks)
    throw refused_request(field, "is not a list of marks");
  for (const json& mark : select[field]) out.push_back(short_text(mark, field, kLongestMark));
  return out;
}

/// The object that a request names, with its text in `field`.
void read_object(const json& value, const char* field, ChooseRequest& out) {
  if (!value.is_object() || !value.contains("object")) throw refused_request(field, "names no object");
  out.object = static_cast<uint32_t>(whole_number(value["object"], "object", 0, UINT32_MAX));
  if (value.contains(field)) out.label = short_text(value[field], field, kLongestLabel);
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
    out.marks = {marks_of(value, "boxes"), marks_of(value, "clicks"), marks_of(value, "strokes")};
    if (value.contains("grow"))
      out.marks.grow = static_cast<int>(whole_number(value["grow"], "grow", -Gesture::kMaxGrow, Gesture::kMaxGrow));
    if (out.marks.empty() && out.marks.grow != 0) throw refused_request("grow", "has no marks to grow");
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
