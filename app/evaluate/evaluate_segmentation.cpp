#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "app/evaluate/evaluate.h"
#include "app/evaluate/metrics.h"
#include "app/store/segmentation.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/image_io.h"
#include "segmentation/labels/agreement.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

constexpr uint32_t kUnmatched = UINT32_MAX;  // a predicted id whose name the truth does not know
constexpr size_t kMostIds = 255;             // more of them are a photo's colours, where the truth knows less than
constexpr double kLeastKnown = 0.01;         // this of the labelled pixels that have one
using Names = std::map<uint32_t, std::string>;
using Overlaps = std::map<uint32_t, OverlapCount>;

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

/// Which true id a predicted one stands for.
struct Match {
  std::string by = "id";
  std::map<uint32_t, uint32_t> known;

  uint32_t of(uint32_t id) const {
    if (id == 0) return id;
    const auto found = known.find(id);
    return found != known.end() ? found->second : by == "overlap" ? kUnmatched : id;
  }
};

/// Ids of every name.
std::map<std::string, std::vector<uint32_t>> ids_of_names(const Names& names) {
  std::map<std::string, std::vector<uint32_t>> ids;
  for (const auto& [id, name] : names) ids[name].push_back(id);
  return ids;
}

/// By names, unless none is in common: an id of the same name on both sides stays, else the name tells the true id
/// where it is that of one id on either side.  Ids that neither side names stay, other ones stand for nothing.
Match match_names(const Names& ours, const Names& theirs) {
  Match match;
  const auto our_ids = ids_of_names(ours), their_ids = ids_of_names(theirs);
  for (const auto& [id, name] : theirs) match.known[id] = kUnmatched;
  for (const auto& [id, name] : ours) {
    match.known[id] = kUnmatched;
    const auto same = their_ids.find(name);
    if (same == their_ids.end()) continue;
    match.by = "name";
    if (const auto own = theirs.find(id); own != theirs.end() && own->second == name)
      match.known[id] = id;
    else if (same->second.size() == 1 && our_ids.at(name).size() == 1)
      match.known[id] = same->second[0];
  }
  return match.by == "name" ? match : Match();
}

/// Counts labelled positions of the truth into the overlap of each id.
void count(const std::vector<uint32_t>& ours, const std::vector<uint32_t>& theirs, Overlaps& overlap, double& correct,
           double& labelled) {
  for (size_t i = 0, next = 0; i < theirs.size(); i = next) {
    for (next = i + 1; next < theirs.size() && theirs[next] == theirs[i] && ours[next] == ours[i];) ++next;
    if (theirs[i] == 0) continue;
    const size_t run = next - i;
    labelled += static_cast<double>(run);
    overlap[theirs[i]].either += run;
    if (ours[i] == theirs[i]) {
      overlap[theirs[i]].both += run;
      correct += static_cast<double>(run);
    } else if (ours[i] != 0)
      overlap[ours[i]].either += run;
  }
}

/// Width of the contour band: what was asked for, else 2 % of the diagonal.
int band_of(const IdImage& picture, int band) {
  return band > 0 ? band : std::max(1, static_cast<int>(std::lround(0.02 * std::hypot(picture.width, picture.height))));
}

/// miou and per_id over the ids of the truth.
void add_overlaps(json& out, const std::string& key, const Overlaps& overlap, const std::set<uint32_t>& ids,
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

json evaluate_labels(const fs::path& prediction, const fs::path& truth, const SegmentationScore& score) {
  if (score.band > 0 || score.common)
    throw usage_error("evaluate", score.common ? "--common" : "--band", "does nothing for labels of Gaussians",
                      "leave it out, or compare folders of ID masks");
  LabelFile ours = read_labels(prediction);
  const LabelFile theirs = read_labels(truth);
  if (ours.label.size() != theirs.label.size()) {
    throw input_error(prediction.string(), "/label",
                      "has " + std::to_string(ours.label.size()) + " Gaussians but the truth has " +
                          std::to_string(theirs.label.size()),
                      "compare labels of the same splats");
  }
  Match match;
  if (score.match == "auto") match = match_names(ours.names, theirs.names);
  if (score.match == "overlap") {
    OverlapMatch overlaps;
    overlaps.add(ours.label, theirs.label);
    match = {"overlap", overlaps.match()};
  }
  for (uint32_t& id : ours.label) id = match.of(id);
  const std::set<uint32_t> ids = labelled_ids({theirs.label.begin(), theirs.label.end()});
  if (ids.empty()) throw input_error(truth.string(), "/label", "labels no object", "give a file with ids above 0");
  Overlaps overlap;
  double correct = 0, labelled = 0;
  count(ours.label, theirs.label, overlap, correct, labelled);
  json out = {{"kind", "labels"},
              {"gaussians", theirs.label.size()},
              {"labelled", labelled},
              {"accuracy", correct / labelled},
              {"matched_by", match.by}};
  add_overlaps(out, "iou", overlap, ids, theirs.names);
  return out;
}

/// Refuses photos in place of ID masks: their colours are read as more IDs than masks have objects, and hardly any of
/// them is one that the truth knows.
void refuse_photos(const fs::path& folder, size_t predicted_ids, const Overlaps& overlap, double correct,
                   double labelled, const std::set<uint32_t>& true_ids) {
  double all = 0, unknown = 0;
  for (const auto& [id, o] : overlap) {
    all += static_cast<double>(o.either);
    if (!true_ids.count(id)) unknown += static_cast<double>(o.either);
  }
  // A labelled pixel counts for its true id, and once more for another one that is predicted there.
  const double predicted = all - labelled + correct;
  if (predicted_ids > kMostIds && unknown > (1 - kLeastKnown) * predicted)
    throw input_error(folder.string(), "",
                      "has more than " + std::to_string(kMostIds) +
                          " IDs, and those of the truth are not among them: these look like photos, not ID masks",
                      "give the folder of ID masks, or --match overlap for IDs without a meaning");
}

using Pictures = decltype(pictures_of(fs::path()));

/// The predicted picture of that name and size, all 0 when there is none.
IdImage read_like(const Pictures& pictures, const std::string& name, const IdImage& truth) {
  const auto found = pictures.find(name);
  if (found == pictures.end()) return IdImage(truth.width, truth.height, 1);
  IdImage ids = read_ids(found->second);
  if (ids.width != truth.width || ids.height != truth.height) {
    throw input_error(found->second.string(), "",
                      "has " + std::to_string(ids.width) + " x " + std::to_string(ids.height) +
                          " pixels but the truth has " + std::to_string(truth.width) + " x " +
                          std::to_string(truth.height),
                      "make it at the size of the photos");
  }
  return ids;
}

Match match_pictures(const Pictures& ours, const Pictures& theirs) {
  OverlapMatch overlaps;
  for (const auto& [name, file] : theirs) {
    const IdImage truth = read_ids(file);
    if (ours.count(name)) overlaps.add(read_like(ours, name, truth).data, truth.data);
  }
  return {"overlap", overlaps.match()};
}

}  // namespace

json evaluate_segmentation(const fs::path& prediction, const fs::path& truth, const SegmentationScore& score) {
  if (prediction.extension() == ".h5" || truth.extension() == ".h5") return evaluate_labels(prediction, truth, score);
  const auto ours = pictures_of(prediction), theirs = pictures_of(truth);
  const Names names = names_of_folder(truth);
  const Match match = score.match == "overlap" ? match_pictures(ours, theirs)
                      : score.match == "auto"  ? match_names(names_of_folder(prediction), names)
                                               : Match();
  Overlaps overlap, edges;
  std::set<uint32_t> all, predicted;
  double correct = 0, labelled = 0;
  bool unlabelled = false;
  json missing = json::array(), per_view = json::object();
  for (const auto& [name, file] : theirs) {
    if (!ours.count(name)) missing.push_back(name);
    if (!ours.count(name) && score.common) continue;
    const IdImage b = read_ids(file);
    IdImage a = read_like(ours, name, b);
    for (size_t i = 0; i < a.data.size() && predicted.size() <= kMostIds; ++i) predicted.insert(a.data[i]);
    for (uint32_t& id : a.data) id = match.of(id);
    Overlaps here;
    double right = 0, here_labelled = 0;
    count(a.data, b.data, here, right, here_labelled);
    count_boundaries(a, b, band_of(b, score.band), edges);
    const std::set<uint32_t> ids = labelled_ids({b.data.begin(), b.data.end()});
    double sum = 0;
    for (uint32_t id : ids) sum += here[id].iou();
    if (!ids.empty()) per_view[name] = sum / static_cast<double>(ids.size());
    for (const auto& [id, o] : here) {
      overlap[id].both += o.both;
      overlap[id].either += o.either;
    }
    all.insert(ids.begin(), ids.end());
    unlabelled = unlabelled || here_labelled < static_cast<double>(b.data.size());
    correct += right;
    labelled += here_labelled;
  }
  if (missing.size() == theirs.size()) {
    throw input_error(prediction.string(), theirs.begin()->first, "has no image with a name from the truth",
                      "name the images like the photos");
  }
  if (all.empty()) throw input_error(truth.string(), "", "labels no object", "give a folder with ids above 0");
  refuse_photos(prediction, predicted.size(), overlap, correct, labelled, all);
  json extra = json::array();
  for (const auto& [name, file] : ours) {
    if (!theirs.count(name)) extra.push_back(name);
  }
  json out = {{"kind", "masks"},        {"pictures", theirs.size()},      {"missing", missing},
              {"extra", extra},         {"accuracy", correct / labelled}, {"per_view", per_view},
              {"matched_by", match.by}, {"warnings", json::array()}};
  if (all.size() == 1 && unlabelled)
    out["warnings"].push_back(truth.string() +
                              ": labels one object and no background; what is predicted where the truth is 0 does not "
                              "count, so that IoU is the share of the object that was found (use nvos or lerf-mask, "
                              "or masks in which the background has an ID)");
  add_overlaps(out, "iou", overlap, all, names);
  add_overlaps(out, "boundary_iou", edges, all, names);
  out["boundary_miou"] = out["mboundary_iou"];
  out.erase("mboundary_iou");
  return out;
}

}  // namespace pliant
