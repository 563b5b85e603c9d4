#include <cmath>
#include <nlohmann/json.hpp>

#include "app/evaluate/binary_masks.h"
#include "app/evaluate/evaluate.h"
#include "app/evaluate/metrics.h"
#include "app/report/tables.h"
#include "gaussians/base/error.h"
#include "gaussians/io/images/image_files.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

/// Masks by prompt, of one view.
using Masks = std::map<std::string, fs::path>;

/// Pictures of each folder below `root`, which may lie in test_mask; folders without any are no views.
std::map<std::string, Masks> masks_by_view(const fs::path& root) {
  std::error_code ignored;
  const fs::path folder = fs::is_directory(root / "test_mask", ignored) ? root / "test_mask" : root;
  if (!fs::is_directory(folder, ignored))
    throw input_error(root.string(), "", "is not a folder", "give the folder of a scene's test_mask");
  std::map<std::string, Masks> views;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && !images_in(entry.path()).empty())
      views[entry.path().filename().string()] = pictures_of(entry.path());
  if (views.empty())
    throw input_error(folder.string(), "", "has no folders of masks", "expected VIEW/PROMPT.png, as in LERF-Mask");
  return views;
}

/// Scores of a prompt, one a view.
struct PromptScores {
  std::vector<double> iou, boundary_iou;
};

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

/// Means over views, then over prompts.
json summary_of(const std::map<std::string, PromptScores>& prompts) {
  json out = {{"per_prompt", json::object()}};
  double iou = 0, boundary_iou = 0;
  for (const auto& [prompt, scores] : prompts) {
    out["per_prompt"][prompt] = {{"iou", number_or_null(mean_of(scores.iou))},
                                 {"boundary_iou", number_or_null(mean_of(scores.boundary_iou))},
                                 {"views", scores.iou.size()}};
    iou += mean_of(scores.iou) / static_cast<double>(prompts.size());
    boundary_iou += mean_of(scores.boundary_iou) / static_cast<double>(prompts.size());
  }
  out["miou"] = prompts.empty() ? json() : number_or_null(iou);
  out["boundary_miou"] = prompts.empty() ? json() : number_or_null(boundary_iou);
  return out;
}

/// Two empty sets agree.
double strict_iou(const MaskOverlap& overlap) { return overlap.either > 0 ? overlap.iou() : 1; }

struct NvosScene {
  const char *name, *truth, *reference;
};
/// Ren et al. 2022: the view that is scored, and the one with the scribbles.
constexpr NvosScene kNvosScenes[] = {
    {"fern", "IMG_4027", "IMG_4038"},
    {"flower", "IMG_2962", "IMG_2983"},
    {"fortress", "IMG_1800", "IMG_1821"},
    {"horns_center", "DJI_20200223_163024_597", "DJI_20200223_163055_437"},
    {"horns_left", "DJI_20200223_163024_597", "DJI_20200223_163055_437"},
    {"leaves", "IMG_2997", "IMG_3011"},
    {"orchids", "IMG_4480", "IMG_4479"},
    {"trex", "DJI_20200223_163619_411", "DJI_20200223_163607_906"},
};

/// The image of the first of these names that there is; empty where there is none.
fs::path picture_named(const fs::path& folder, const std::vector<std::string>& names) {
  const std::vector<fs::path> images = images_in(folder);
  for (const std::string& name : names)
    for (const fs::path& image : images)
      if (image.stem() == name) return image;
  return {};
}

}  // namespace

json evaluate_lerf_mask(const fs::path& prediction, const fs::path& truth) {
  const auto theirs = masks_by_view(truth), ours = masks_by_view(prediction);
  std::map<std::string, PromptScores> paper, strict;
  json missing = json::array(), wrong_size = json::array();
  int masks = 0;
  for (const auto& [view, prompts] : theirs)
    for (const auto& [prompt, file] : prompts) {
      ++masks;
      const ImageU8 b = read_mask(file);
      const auto own_view = ours.find(view);
      const bool found = own_view != ours.end() && own_view->second.count(prompt);
      double iou = 0, boundary_iou = 0;
      if (found) {
        ImageU8 a = read_mask(own_view->second.at(prompt));
        const bool same_size = a.width == b.width && a.height == b.height;
        if (!same_size) a = resized_nearest(a, b.width, b.height);
        const MaskOverlap overlap = mask_overlap(a, b), edge = boundary_overlap(a, b, boundary_band(b.width, b.height));
        paper[prompt].iou.push_back(overlap.iou());
        paper[prompt].boundary_iou.push_back(edge.iou());
        if (same_size) {
          iou = strict_iou(overlap);
          boundary_iou = strict_iou(edge);
        } else {
          wrong_size.push_back(view + "/" + prompt);
        }
      } else {
        missing.push_back(view + "/" + prompt);
      }
      strict[prompt].iou.push_back(iou);
      strict[prompt].boundary_iou.push_back(boundary_iou);
    }
  if (missing.size() == static_cast<size_t>(masks))
    throw input_error(prediction.string(), missing[0].get<std::string>(), "is missing, as are all masks of the truth",
                      "expected VIEW/PROMPT.png with the names of the truth");
  json out = summary_of(strict);
  out["kind"] = "lerf-mask";
  out["masks"] = masks;
  out["missing"] = missing;
  out["wrong_size"] = wrong_size;
  out["paper_compatible"] = summary_of(paper);
  return out;
}

json evaluate_nvos(const fs::path& prediction, const fs::path& truth) {
  std::error_code ignored;
  const fs::path folder = fs::is_directory(truth / "masks", ignored) ? truth / "masks" : truth;
  if (!fs::is_directory(prediction, ignored))
    throw input_error(prediction.string(), "", "is not a folder", "give the folder with the masks of the scenes");
  json out = {{"kind", "nvos"}, {"per_scene", json::object()}, {"missing", json::array()}};
  double iou = 0, accuracy = 0, boundary_iou = 0;
  int scenes = 0;
  for (const NvosScene& scene : kNvosScenes) {
    const std::string mask = std::string(scene.truth) + "_mask";
    const fs::path file = picture_named(folder / scene.name, {mask});
    if (file.empty()) continue;
    ++scenes;
    json row = {{"truth_image", scene.truth},
                {"reference_image", scene.reference},
                {"iou", 0.0},
                {"accuracy", 0.0},
                {"boundary_iou", 0.0},
                {"resized", false}};
    const ImageU8 b = read_mask(file);
    fs::path own = picture_named(prediction / scene.name, {mask, scene.truth});
    if (own.empty()) own = picture_named(prediction, {scene.name});
    if (own.empty()) {
      out["missing"].push_back(scene.name);
    } else {
      ImageU8 a = read_mask(own);
      if (a.width != b.width || a.height != b.height) {
        a = resized_nearest(a, b.width, b.height);
        row["resized"] = true;
      }
      const MaskOverlap overlap = mask_overlap(a, b);
      row["iou"] = strict_iou(overlap);
      row["accuracy"] = overlap.accuracy();
      row["boundary_iou"] = strict_iou(boundary_overlap(a, b, boundary_band(b.width, b.height)));
    }
    iou += row["iou"].get<double>();
    accuracy += row["accuracy"].get<double>();
    boundary_iou += row["boundary_iou"].get<double>();
    out["per_scene"][scene.name] = std::move(row);
  }
  if (scenes == 0)
    throw input_error(truth.string(), "masks", "has no mask of an NVOS scene",
                      "expected SCENE/IMAGE_mask.png, for example fern/IMG_4027_mask.png");
  if (out["missing"].size() == static_cast<size_t>(scenes))
    throw input_error(prediction.string(), "", "has no mask of a scene of the truth",
                      "expected SCENE/IMAGE_mask.png, SCENE/IMAGE.png or SCENE.png, for example fern/IMG_4027.png");
  out["scenes"] = scenes;
  out["miou"] = iou / scenes;
  out["accuracy"] = accuracy / scenes;
  out["boundary_miou"] = boundary_iou / scenes;
  return out;
}

}  // namespace pliant
