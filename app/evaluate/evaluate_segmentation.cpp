#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "app/evaluate/evaluate.h"
#include "app/evaluate/metrics.h"
#include "app/store/segmentation.h"
#include "gaussians/base/error.h"
#include "gaussians/io/image_io.h"
#include "gaussians/io/json_file.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

constexpr uint32_t kUnmatched = UINT32_MAX;  // a predicted id whose name the truth does not know
using Names = std::map<uint32_t, std::string>;

struct Overlap {
  double intersection = 0, union_ = 0;
  double iou() const { return union_ > 0 ? intersection / union_ : 1.0; }
};

/// Names of labels.json in the folder or beside it; empty when there is none.
Names names_of_folder(const fs::path& folder) {
  const fs::path whole = fs::absolute(folder / "").lexically_normal().parent_path();
  for (const fs::path& file : {whole / "labels.json", whole.parent_path() / "labels.json"}) {
    std::error_code ignored;
    if (!fs::is_regular_file(file, ignored)) continue;
    const json rows = read_json(file);
    if (!rows.is_object()) throw input_error(file.string(), "", "is not an object id -> name", "correct the file");
    Names names;
    for (const auto& [id, name] : rows.items()) {
      if (!name.is_string() || id.empty() || id.size() > 8 || id.find_first_not_of("0123456789") != std::string::npos) {
        throw input_error(file.string(), id, "is not an entry id -> name", "correct the file");
      }
      names[static_cast<uint32_t>(std::stoul(id))] = name.get<std::string>();
    }
    return names;
  }
  return {};
}

/// Predicted id -> true id of the same name; empty = no name in common, ids are compared as they are.
std::map<uint32_t, uint32_t> match_names(const Names& ours, const Names& theirs) {
  std::map<uint32_t, uint32_t> match;
  bool common = false;
  for (const auto& [our_id, our_name] : ours) {
    match[our_id] = kUnmatched;
    for (const auto& [their_id, their_name] : theirs) {
      if (our_name == their_name) match[our_id] = their_id, common = true;
    }
  }
  if (!common) match.clear();
  return match;
}

uint32_t matched(const std::map<uint32_t, uint32_t>& match, uint32_t id) {
  if (match.empty() || id == 0) return id;
  const auto found = match.find(id);
  return found == match.end() ? kUnmatched : found->second;
}

/// Counts labelled positions of the truth into the overlap of each id.
void count(const std::vector<uint32_t>& ours, const std::vector<uint32_t>& theirs, std::map<uint32_t, Overlap>& overlap, double& correct,
           double& labelled) {
  for (size_t i = 0; i < theirs.size(); ++i) {
    if (theirs[i] == 0) continue;
    ++labelled, correct += ours[i] == theirs[i];
    ++overlap[theirs[i]].union_;
    if (ours[i] == theirs[i]) ++overlap[theirs[i]].intersection;
    else if (ours[i] != 0) ++overlap[ours[i]].union_;
  }
}

/// Pixels of `id` within `distance` of the border of its region.
cv::Mat boundary(const IdImage& ids, uint32_t id, int distance) {
  cv::Mat mask(ids.height, ids.width, CV_8U), inner;
  for (int y = 0; y < ids.height; ++y) {
    for (int x = 0; x < ids.width; ++x) mask.at<uint8_t>(y, x) = ids(x, y) == id;
  }
  const cv::Mat kernel = cv::getStructuringElement(cv::MORPH_RECT, {2 * distance + 1, 2 * distance + 1});
  cv::erode(mask, inner, kernel, {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  return mask - inner;
}

void count_boundaries(const IdImage& ours, const IdImage& theirs, std::map<uint32_t, Overlap>& overlap) {
  const int distance = std::max(1, static_cast<int>(std::lround(0.02 * std::hypot(theirs.width, theirs.height))));
  const std::set<uint32_t> ids(theirs.data.begin(), theirs.data.end());
  for (uint32_t id : ids) {
    if (id == 0) continue;
    const cv::Mat a = boundary(ours, id, distance), b = boundary(theirs, id, distance);
    for (int y = 0; y < theirs.height; ++y) {
      for (int x = 0; x < theirs.width; ++x) {
        if (theirs(x, y) == 0) continue;
        overlap[id].intersection += a.at<uint8_t>(y, x) && b.at<uint8_t>(y, x);
        overlap[id].union_ += a.at<uint8_t>(y, x) || b.at<uint8_t>(y, x);
      }
    }
  }
}

/// miou and per_id over the ids of the truth.
void add_overlaps(json& out, const std::string& key, const std::map<uint32_t, Overlap>& overlap, const std::set<uint32_t>& ids,
                  const Names& names) {
  double sum = 0;
  for (uint32_t id : ids) {
    const auto found = overlap.find(id);
    const double iou = found == overlap.end() ? 0.0 : found->second.iou();
    const auto name = names.find(id);
    json& row = out["per_id"][std::to_string(id)];
    row[key] = iou;
    if (name != names.end()) row["name"] = name->second;
    sum += iou;
  }
  out["m" + key] = sum / static_cast<double>(ids.size());
}

std::set<uint32_t> labelled_ids(const std::set<uint32_t>& all) {
  std::set<uint32_t> ids = all;
  ids.erase(0);
  return ids;
}

json evaluate_labels(const fs::path& prediction, const fs::path& truth) {
  LabelFile ours = read_labels(prediction);
  const LabelFile theirs = read_labels(truth);
  if (ours.label.size() != theirs.label.size()) {
    throw input_error(prediction.string(), "/label", "has " + std::to_string(ours.label.size()) + " Gaussians but the truth has " +
                      std::to_string(theirs.label.size()), "compare labels of the same splats");
  }
  const auto match = match_names(ours.names, theirs.names);
  for (uint32_t& id : ours.label) id = matched(match, id);
  const std::set<uint32_t> ids = labelled_ids({theirs.label.begin(), theirs.label.end()});
  if (ids.empty()) throw input_error(truth.string(), "/label", "labels nothing", "name a file with ids above 0");
  std::map<uint32_t, Overlap> overlap;
  double correct = 0, labelled = 0;
  count(ours.label, theirs.label, overlap, correct, labelled);
  json out = {{"kind", "labels"}, {"gaussians", theirs.label.size()}, {"labelled", labelled}, {"accuracy", correct / labelled},
              {"matched_by", match.empty() ? "id" : "name"}};
  add_overlaps(out, "iou", overlap, ids, theirs.names);
  return out;
}

}  // namespace

json evaluate_segmentation(const fs::path& prediction, const fs::path& truth) {
  if (prediction.extension() == ".h5" || truth.extension() == ".h5") return evaluate_labels(prediction, truth);
  const auto ours = pictures_of(prediction), theirs = pictures_of(truth);
  const Names names = names_of_folder(truth);
  const auto match = match_names(names_of_folder(prediction), names);
  std::map<uint32_t, Overlap> overlap, edges;
  std::set<uint32_t> all;
  double correct = 0, labelled = 0;
  json missing = json::array(), per_view = json::object();
  for (const auto& [name, file] : theirs) {
    const IdImage b = read_ids(file);
    IdImage a(b.width, b.height, 1);
    if (const auto found = ours.find(name); found == ours.end()) {
      missing.push_back(name);
    } else {
      a = read_ids(found->second);
    }
    if (a.width != b.width || a.height != b.height) {
      throw input_error(ours.at(name).string(), "", "has " + std::to_string(a.width) + " x " + std::to_string(a.height) +
                        " pixels but the truth has " + std::to_string(b.width) + " x " + std::to_string(b.height),
                        "make it at the size of the photos");
    }
    for (uint32_t& id : a.data) id = matched(match, id);
    std::map<uint32_t, Overlap> here;
    double right = 0, here_labelled = 0;
    count(a.data, b.data, here, right, here_labelled);
    count_boundaries(a, b, edges);
    const std::set<uint32_t> ids = labelled_ids({b.data.begin(), b.data.end()});
    double sum = 0;
    for (uint32_t id : ids) sum += here[id].iou();
    if (!ids.empty()) per_view[name] = sum / static_cast<double>(ids.size());
    for (const auto& [id, o] : here) overlap[id].intersection += o.intersection, overlap[id].union_ += o.union_;
    all.insert(ids.begin(), ids.end());
    correct += right, labelled += here_labelled;
  }
  if (missing.size() == theirs.size()) {
    throw input_error(prediction.string(), theirs.begin()->first, "has no picture of any name in the truth", "name the pictures like the photos");
  }
  if (all.empty()) throw input_error(truth.string(), "", "labels nothing", "name a folder with ids above 0");
  json extra = json::array();
  for (const auto& [name, file] : ours) {
    if (!theirs.count(name)) extra.push_back(name);
  }
  json out = {{"kind", "masks"}, {"pictures", theirs.size()}, {"missing", missing}, {"extra", extra}, {"accuracy", correct / labelled},
              {"per_view", per_view}, {"matched_by", match.empty() ? "id" : "name"}};
  add_overlaps(out, "iou", overlap, all, names);
  add_overlaps(out, "boundary_iou", edges, all, names);
  out["boundary_miou"] = out["mboundary_iou"], out.erase("mboundary_iou");
  return out;
}

}  // namespace pliant
