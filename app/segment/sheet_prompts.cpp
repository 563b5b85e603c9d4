#include "app/segment/sheet_prompts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "segmentation/sheets/sides_sheet.h"

namespace pliant {
using nlohmann::json;

namespace {

/// A picture of the run directory on which gestures can be made.
struct Sheet {
  const char* word;  ///< in place of a camera
  const char* picture;
  const char* cells;
};
constexpr Sheet kSheets[] = {{"sheet", "objects.png", "objects_sheet.json"},
                             {"selection", "selection.png", "selection_sheet.json"}};
const Sheet& kSelection = kSheets[1];

std::vector<std::string> split_at_commas(const std::string& text) {
  std::vector<std::string> words;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return words;
}

double pixel_number(const Sheet& sheet, const std::string& option, const std::string& text, const std::string& word) {
  char* stop = nullptr;
  const double value = std::strtod(word.c_str(), &stop);
  if (word.empty() || *stop != 0 || !std::isfinite(value))
    throw usage_error(option, text, "holds '" + word + "', which is not a number",
                      std::string("give pixels of ") + sheet.picture);
  return value;
}

/// The prompt with the camera and pixels that `cells` show at those of the sheet; all lie in the cell of the first one.
std::string resolved(const Sheet& sheet, const std::string& option, const std::string& text,
                     std::vector<std::string> words, size_t at, const json& cells) {
  const auto outside = [&](const std::string& x, const std::string& y) {
    return usage_error(option, text,
                       "has the pixel " + x + "," + y + ", where " + sheet.picture + " shows no image or another one",
                       "choose pixels of one image of the sheet");
  };
  const json* cell = nullptr;
  for (size_t k = at + 1; k + 1 < words.size(); k += 2) {
    const double x = pixel_number(sheet, option, text, words[k]), y = pixel_number(sheet, option, text, words[k + 1]);
    const auto holds = [&](const json& c) {
      return x >= c["x"].get<double>() && y >= c["y"].get<double>() &&
             x < c["x"].get<double>() + c["width"].get<double>() &&
             y < c["y"].get<double>() + c["height"].get<double>();
    };
    if (!cell)
      for (const json& candidate : cells)
        if (holds(candidate)) cell = &candidate;
    if (!cell || !holds(*cell)) throw outside(words[k], words[k + 1]);
    const double px =
        (*cell)["origin"][0].get<double>() + (x - (*cell)["x"].get<double>()) * (*cell)["scale"].get<double>();
    const double py =
        (*cell)["origin"][1].get<double>() + (y - (*cell)["y"].get<double>()) * (*cell)["scale"].get<double>();
    const json& size = (*cell)["picture"];
    if (px < 0 || py < 0 || px > size[0].get<double>() || py > size[1].get<double>())
      throw outside(words[k], words[k + 1]);
    words[k] = fmt::format("{:.2f}", px);
    words[k + 1] = fmt::format("{:.2f}", py);
  }
  if (cell) words[at] = (*cell)["camera"].get<std::string>();
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : ",") + word;
  return out;
}

/// The cells of a sheet, checked.
json read_cells(const RunDirectory& run, const Sheet& sheet, const std::string& option, const std::string& text) {
  const std::filesystem::path file = run / sheet.cells;
  if (!std::filesystem::exists(file))
    throw usage_error(option, text, std::string("refers to pixels of ") + sheet.picture + ", which does not exist",
                      &sheet == &kSelection ? "select with --box or --click first, or give a camera"
                                            : "segment the scene first, or give a camera");
  const json cells = read_json(file);
  bool good = cells.is_array();
  for (const json& cell : cells) {
    for (const char* key : {"x", "y", "width", "height", "scale"})
      good = good && cell.is_object() && cell.contains(key) && cell[key].is_number();
    for (const char* key : {"origin", "picture"})
      good = good && cell.contains(key) && cell[key].is_array() && cell[key].size() == 2 && cell[key][0].is_number() &&
             cell[key][1].is_number();
    good = good && cell.contains("camera") && cell["camera"].is_string();
  }
  if (!good)
    throw input_error(file.string(), "", "was not written by `segment`",
                      "delete it and segmentation.h5, and segment the scene again");
  return cells;
}

json cell_json(const SheetCell& cell, const Camera& camera) {
  return {{"x", cell.x},
          {"y", cell.y},
          {"width", cell.width},
          {"height", cell.height},
          {"camera", camera.name},
          {"picture", {camera.width, camera.height}},
          {"origin", {cell.origin_x, cell.origin_y}},
          {"scale", cell.scale}};
}

/// The cameras of `cells` that sides_json gave.
std::vector<Camera> cameras_of(const json& cells, const std::string& file) {
  std::vector<Camera> cameras;
  try {
    for (const json& cell : cells) {
      Camera camera;
      camera.name = cell.at("camera");
      camera.width = cell.at("picture").at(0);
      camera.height = cell.at("picture").at(1);
      camera.fx = cell.at("focal").at(0);
      camera.fy = cell.at("focal").at(1);
      camera.cx = cell.at("centre").at(0);
      camera.cy = cell.at("centre").at(1);
      for (int k = 0; k < 12; ++k) camera.cam_from_world.matrix()(k / 4, k % 4) = cell.at("cam_from_world").at(k);
      cameras.push_back(camera);
    }
  } catch (const json::exception& wrong) {
    throw input_error(file, "", std::string("was not written by `segment`: ") + wrong.what(),
                      "delete it and segmentation.h5, and segment the scene again");
  }
  return cameras;
}

}  // namespace

json sides_json(const std::vector<Camera>& sides) {
  json rows = json::array();
  for (const SheetCell& cell : side_cells(sides)) {
    const Camera& camera = sides[cell.camera];
    json row = cell_json(cell, camera), pose = json::array();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 4; ++j) pose.push_back(camera.cam_from_world.matrix()(i, j));
    // Intrinsics [px] and rows of cam_from_world.
    row["focal"] = {camera.fx, camera.fy};
    row["centre"] = {camera.cx, camera.cy};
    row["cam_from_world"] = pose;
    rows.push_back(row);
  }
  return rows;
}

std::vector<Camera> with_sides(const SegmentStage& stage, const std::vector<Camera>& sides,
                               std::vector<Camera> cameras) {
  for (const Camera& side : sides)
    for (const auto* texts : {&stage.boxes, &stage.clicks, &stage.strokes})
      if (std::any_of(texts->begin(), texts->end(), [&](const std::string& text) {
            return ("," + text).find("," + side.name + ",") != std::string::npos;
          })) {
        cameras.push_back(side);
        break;
      }
  return cameras;
}

void write_selection_cells(const RunDirectory& run, const std::vector<Camera>& sides) {
  write_json(run / kSelection.cells, sides_json(sides));
}

void write_sheet_cells(const RunDirectory& run, const std::vector<SheetCell>& cells,
                       const std::vector<Camera>& cameras) {
  json rows = json::array();
  for (const SheetCell& cell : cells) rows.push_back(cell_json(cell, cameras[cell.camera]));
  write_json(run / "objects_sheet.json", rows);
}

SheetPrompts with_sheet_prompts(const Context& context, RunDirectory& run, const SegmentStage& given) {
  SheetPrompts out{given, {}};
  SegmentStage& stage = out.stage;
  json known = run.note("sheet_prompts"), options = json::object(), shown = json::array();
  if (const json record = run.last_record("segment"); !record.is_null()) {
    options = record["options"];
    shown = record.value("found", json::object()).value("stroke_sides", shown);
  }
  struct Prompts {
    const char* option;
    const char* key;
    size_t camera;  ///< place of the camera among the words
    std::vector<std::string>& texts;
  };
  for (const Prompts& prompts : {Prompts{"--box", "box", 0, stage.boxes},
                                 {"--click", "click", 0, stage.clicks},
                                 {"--stroke", "stroke", 1, stage.strokes}})
    for (std::string& text : prompts.texts) {
      const std::vector<std::string> words = split_at_commas(text);
      const auto sheet = std::find_if(std::begin(kSheets), std::end(kSheets), [&](const Sheet& s) {
        return words.size() > prompts.camera && words[prompts.camera] == s.word;
      });
      if (sheet == std::end(kSheets)) continue;
      const std::string name = std::string(prompts.key) + " " + text;
      json cells;
      // What the result that is there was made from stays what it was.
      const json used = options.value(prompts.key, json::array());
      if (known.is_object() && known.contains(name) && std::find(used.begin(), used.end(), known[name]) != used.end()) {
        text = known[name].get<std::string>();
        cells = shown;
      } else {
        cells = read_cells(run, *sheet, prompts.option, text);
        const std::string found = resolved(*sheet, prompts.option, text, words, prompts.camera, cells);
        context.progress.say("segment: " + text + " of " + sheet->picture + " is " + found);
        known[name] = found;
        text = found;
      }
      if (&*sheet == &kSelection && out.sides.empty()) out.sides = cameras_of(cells, (run / sheet->cells).string());
    }
  run.set_note("sheet_prompts", known);
  return out;
}

}  // namespace pliant
