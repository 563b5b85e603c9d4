#include "app/pipeline/sheet_prompts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "gaussians/base/error.h"
#include "gaussians/io/files.h"
#include "gaussians/io/json_file.h"

namespace pliant {
using nlohmann::json;

namespace {

std::vector<std::string> split_at_commas(const std::string& text) {
  std::vector<std::string> words;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return words;
}

double pixel_number(const std::string& option, const std::string& text, const std::string& word) {
  char* stop = nullptr;
  const double value = std::strtod(word.c_str(), &stop);
  if (word.empty() || *stop != 0 || !std::isfinite(value)) throw usage_error(option, text, "holds '" + word + "', which is not a number", "give pixels of objects.png");
  return value;
}

/// The prompt with the camera and pixels that `cells` show at those of the sheet; all lie in the cell of the first one.
std::string resolved(const std::string& option, const std::string& text, std::vector<std::string> words, size_t at, const json& cells) {
  const auto outside = [&](const std::string& x, const std::string& y) {
    return usage_error(option, text, "has the pixel " + x + "," + y + ", where objects.png shows no picture or another one", "choose pixels of one picture of the sheet");
  };
  const json* cell = nullptr;
  for (size_t k = at + 1; k + 1 < words.size(); k += 2) {
    const double x = pixel_number(option, text, words[k]), y = pixel_number(option, text, words[k + 1]);
    const auto holds = [&](const json& c) {
      return x >= c["x"].get<double>() && y >= c["y"].get<double>() && x < c["x"].get<double>() + c["width"].get<double>() &&
             y < c["y"].get<double>() + c["height"].get<double>();
    };
    if (!cell)
      for (const json& candidate : cells)
        if (holds(candidate)) cell = &candidate;
    if (!cell || !holds(*cell)) throw outside(words[k], words[k + 1]);
    const double px = (*cell)["origin"][0].get<double>() + (x - (*cell)["x"].get<double>()) * (*cell)["scale"].get<double>();
    const double py = (*cell)["origin"][1].get<double>() + (y - (*cell)["y"].get<double>()) * (*cell)["scale"].get<double>();
    const json& size = (*cell)["picture"];
    if (px < 0 || py < 0 || px > size[0].get<double>() || py > size[1].get<double>()) throw outside(words[k], words[k + 1]);
    words[k] = fmt::format("{:.2f}", px), words[k + 1] = fmt::format("{:.2f}", py);
  }
  if (cell) words[at] = (*cell)["camera"].get<std::string>();
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : ",") + word;
  return out;
}

/// Cells of objects_sheet.json, checked.
json read_cells(const RunDirectory& run, const std::string& option, const std::string& text) {
  const std::filesystem::path file = run / "objects_sheet.json";
  if (!std::filesystem::exists(file))
    throw usage_error(option, text, "counts pixels of objects.png, which is not there", "segment the scene first, or name a camera");
  const json cells = read_json(file);
  bool good = cells.is_array();
  for (const json& cell : cells) {
    for (const char* key : {"x", "y", "width", "height", "scale"}) good = good && cell.is_object() && cell.contains(key) && cell[key].is_number();
    for (const char* key : {"origin", "picture"})
      good = good && cell.contains(key) && cell[key].is_array() && cell[key].size() == 2 && cell[key][0].is_number() && cell[key][1].is_number();
    good = good && cell.contains("camera") && cell["camera"].is_string();
  }
  if (!good) throw input_error(file.string(), "", "is not what `segment` wrote", "segment the scene again with --overwrite");
  return cells;
}

}  // namespace

void write_sheet_cells(const RunDirectory& run, const std::vector<SheetCell>& cells, const std::vector<Camera>& cameras) {
  json rows = json::array();
  for (const SheetCell& cell : cells) {
    const Camera& camera = cameras[cell.camera];
    rows.push_back({{"x", cell.x}, {"y", cell.y}, {"width", cell.width}, {"height", cell.height}, {"camera", camera.name},
                    {"picture", {camera.width, camera.height}}, {"origin", {cell.origin_x, cell.origin_y}}, {"scale", cell.scale}});
  }
  write_json(run / "objects_sheet.json", rows);
}

SegmentStage with_sheet_prompts(const Context& context, RunDirectory& run, SegmentStage stage) {
  json known = run.note("sheet_prompts"), options = json::object();
  if (run.has("segment")) options = run.manifest()["stages"]["segment"]["options"];
  struct Prompts {
    const char* option;
    const char* key;
    size_t camera;  ///< place of the camera among the words
    std::vector<std::string>& texts;
  };
  for (const Prompts& prompts : {Prompts{"--box", "box", 0, stage.boxes}, {"--click", "click", 0, stage.clicks}, {"--stroke", "stroke", 1, stage.strokes}})
    for (std::string& text : prompts.texts) {
      const std::vector<std::string> words = split_at_commas(text);
      if (words.size() <= prompts.camera || words[prompts.camera] != "sheet") continue;
      const std::string name = std::string(prompts.key) + " " + text;
      // What the result that is there was made from stays what it was.
      if (!context.overwrite && known.is_object() && known.contains(name) && options.contains(prompts.key)) {
        const json& used = options[prompts.key];
        if (std::find(used.begin(), used.end(), known[name]) != used.end()) {
          text = known[name].get<std::string>();
          continue;
        }
      }
      const std::string found = resolved(prompts.option, text, words, prompts.camera, read_cells(run, prompts.option, text));
      context.progress.say("segment: " + text + " of objects.png is " + found);
      known[name] = found;
      text = found;
    }
  run.set_note("sheet_prompts", known);
  return stage;
}

}  // namespace pliant
