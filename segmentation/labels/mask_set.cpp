#include "segmentation/labels/mask_set.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "segmentation/labels/mask_layouts.h"

namespace pliant {
namespace fs = std::filesystem;

namespace {

const char* const kBackground = "background";

void add_ids(const IdImage& picture, std::set<uint32_t>& found) {
  uint32_t last = 0;
  for (uint32_t id : picture.data) {
    if (id != last && id != 0) found.insert(id);
    last = id;
  }
}

}  // namespace

std::vector<uint32_t> MaskSet::ids() const {
  std::set<uint32_t> found;
  for (const View& view : views) add_ids(view.ids, found);
  return {found.begin(), found.end()};
}

std::string MaskSet::name_of(uint32_t id) const {
  const auto it = names.find(id);
  return it != names.end() ? it->second : "object_" + std::to_string(id);
}

std::map<uint32_t, std::string> read_label_names(const fs::path& file) {
  const char* remedy = "write a JSON object such as {\"1\": \"flower\", \"2\": \"table\"}";
  nlohmann::json json;
  try {
    json = nlohmann::json::parse(read_text(file));
  } catch (const nlohmann::json::exception& e) {
    throw input_error(file.string(), "", std::string("is not JSON: ") + e.what(), remedy);
  }
  if (!json.is_object()) throw input_error(file.string(), "", "is not a JSON object", remedy);
  std::map<uint32_t, std::string> names;
  for (const auto& [key, value] : json.items()) {
    uint32_t id = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), id);
    if (error != std::errc() || end != key.data() + key.size() || id == 0)
      throw input_error(file.string(), key, "is not an ID, an integer above 0", remedy);
    if (!value.is_string()) throw input_error(file.string(), key, "has a name that is not a string", remedy);
    if (const std::string name = value; !name.empty()) names[id] = name;
  }
  return names;
}

uint32_t free_id(const std::set<uint32_t>& used) {
  const uint32_t last = used.empty() ? 0 : *used.rbegin();
  if (last < kLargestId) return last + 1;
  uint32_t id = 1;
  while (used.count(id)) ++id;
  return id;
}

fs::path labels_of(const fs::path& folder, const fs::path& labels) {
  const fs::path beside = folder / "labels.json";
  return !folder.empty() && fs::exists(beside) ? beside : labels;
}

std::string warning_of_zero(const std::vector<std::string>& classes, double unlabelled) {
  constexpr double kMuch = 0.25;
  if (classes.size() == 1)
    return "all labeled pixels have one ID, so that everything becomes it: add --mask-zero background if ID 0 is the "
           "background";
  if (unlabelled <= kMuch || std::count(classes.begin(), classes.end(), kBackground)) return "";
  return std::to_string(std::lround(100 * unlabelled)) +
         " % of what the photos show has no label and takes its neighbors': add --mask-zero background if ID 0 is the "
         "background";
}

uint32_t label_background(MaskSet& masks, const std::vector<size_t>& views) {
  const std::vector<uint32_t> ids = masks.ids();
  const auto named = std::find_if(masks.names.begin(), masks.names.end(),
                                  [](const auto& entry) { return entry.second == kBackground; });
  const uint32_t background = named != masks.names.end() ? named->first : free_id({ids.begin(), ids.end()});
  for (const size_t v : views) {
    std::vector<uint32_t>& pixels = masks.views[v].ids.data;
    std::replace(pixels.begin(), pixels.end(), 0u, background);
  }
  masks.names[background] = kBackground;
  return background;
}

uint32_t label_background(MaskSet& masks) {
  std::vector<size_t> all(masks.views.size());
  std::iota(all.begin(), all.end(), 0);
  return label_background(masks, all);
}

namespace {

/// A picture in `folder` that has one of the names; empty when there is none.
fs::path picture_named(const fs::path& folder, const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (!name.empty() && fs::is_regular_file(folder / (name + ".png"))) return folder / (name + ".png");
  return {};
}

/// The id picture of a camera in the last folders of its photo, the longest path that there is: of
/// images/cam1/0001.jpg in cam1/.  Empty when there is none but the photo itself.
fs::path mirrored_picture(const fs::path& folder, const Camera& camera) {
  const fs::path photo = camera.photo;
  if (photo.empty()) return {};
  std::error_code ignored;
  fs::path inner = fs::absolute(photo).lexically_normal().parent_path().relative_path();
  while (!inner.empty()) {
    const fs::path file = picture_named(folder / inner, {photo.stem().string(), photo.filename().string()});
    if (!file.empty() && !fs::equivalent(file, photo, ignored)) return file;
    fs::path shorter;
    for (auto part = std::next(inner.begin()); part != inner.end(); ++part) shorter /= *part;
    inner = shorter;
  }
  return {};
}

/// The id pictures of the cameras, empty where there is none: named like a camera or its photo.
std::vector<fs::path> id_pictures(const fs::path& folder, const std::vector<Camera>& cameras) {
  std::vector<fs::path> files;
  std::set<fs::path> inner;  // folders like those of the photos
  for (const Camera& camera : cameras) {
    files.push_back(picture_named(folder, {camera.name, fs::path(camera.photo).filename().string()}));
    if (!files.back().empty()) continue;
    files.back() = mirrored_picture(folder, camera);
    if (!files.back().empty()) inner.insert(files.back().parent_path());
  }
  // A single folder of white pictures may be that of an object.
  std::error_code ignored;
  if (inner.size() != 1 || !fs::equivalent(inner.begin()->parent_path(), folder, ignored)) return files;
  uint32_t largest = 0;
  size_t marked = 0, white = 0;  // pixels that are not 0, and those of the largest value
  for (const fs::path& file : files)
    if (file.parent_path() == *inner.begin())
      for (const uint32_t id : read_ids(file).data) {
        if (id == 0) continue;
        ++marked;
        if (id > largest) white = 0;
        largest = std::max(largest, id);
        white += id == largest;
      }
  // Soft edges and weak traces of an object are fewer than its white; one of several IDs may be 255 as well.
  if ((largest == 0xff || largest == 0xffff || largest == kLargestId) && 2 * white >= marked)
    for (fs::path& file : files)
      if (file.parent_path() == *inner.begin()) file.clear();
  return files;
}

/// Names from `labels`.  Where folders name the objects, ids are numbered here, and a file elsewhere names other ones.
void read_names(const fs::path& folder, const fs::path& labels, MaskSet& masks) {
  std::error_code ignored;
  if (!masks.names.empty() && !fs::equivalent(labels, folder / labels.filename(), ignored))
    masks.warnings.push_back("the folders of the masks name the objects; the names in " + labels.string() +
                             " are not used");
  else
    for (const auto& [id, name] : read_label_names(labels)) masks.names[id] = name;
}

/// Makes what binary pictures show outside of all objects the background, where the views tell, and says so.
void show_background(const std::vector<uint32_t>& ids, const std::vector<size_t>& complete, MaskSet& masks) {
  const bool any = std::any_of(complete.begin(), complete.end(), [&](size_t v) {
    const std::vector<uint32_t>& pixels = masks.views[v].ids.data;
    return std::find(pixels.begin(), pixels.end(), 0u) != pixels.end();
  });
  if (!any) return;
  const std::string objects =
      ids.size() == 1 ? "one object, " + masks.name_of(ids[0]) : std::to_string(ids.size()) + " objects";
  const std::string where = complete.size() == masks.views.size()
                                ? ""
                                : " in the " + std::to_string(complete.size()) + " of " +
                                      std::to_string(masks.views.size()) + " photos that have a mask of every object";
  masks.warnings.push_back("the masks show " + objects + ": pixels outside of " + (ids.size() == 1 ? "it" : "them") +
                           " become the object 'background'" + where);
  label_background(masks, complete);
}

}  // namespace

MaskSet load_masks(const fs::path& folder, const fs::path& labels, const std::vector<Camera>& cameras,
                   const FitMask& fit) {
  if (!fs::is_directory(folder))
    throw input_error(folder.string(), "masks", "is not a folder",
                      "give a folder with one ID mask per photo, or select with --aabb or --sphere");
  constexpr size_t kMostIds = 20000;
  MaskSet masks;
  std::set<uint32_t> found;
  std::vector<std::string> missing;
  const std::vector<fs::path> files = id_pictures(folder, cameras);
  for (size_t c = 0; c < cameras.size(); ++c) {
    const Camera& camera = cameras[c];
    const fs::path& file = files[c];
    if (file.empty()) {
      missing.push_back(camera.name);
      continue;
    }
    IdImage ids = read_ids(file);
    check_mask_size(file, ids.width, ids.height, camera, fit != nullptr);
    add_ids(ids, found);
    if (found.size() > kMostIds)
      throw input_error(folder.string(), "",
                        "has " + std::to_string(found.size()) + " or more different IDs: these look like photos",
                        "give a folder of ID masks");
    masks.views.push_back({static_cast<int>(c), fit ? fit(ids, static_cast<int>(c)) : std::move(ids)});
  }
  std::vector<size_t> complete;  // views of binary pictures that have one of every object
  if (masks.views.empty()) {
    BinaryMasks binary = load_binary_masks(folder, cameras, fit);
    masks = std::move(binary.masks);
    complete = std::move(binary.complete);
    missing.clear();
    for (size_t c = 0; c < cameras.size(); ++c)
      if (std::none_of(masks.views.begin(), masks.views.end(),
                       [&](const MaskSet::View& view) { return view.camera == static_cast<int>(c); }))
        missing.push_back(cameras[c].name);
  }
  if (masks.views.empty())
    throw input_error(folder.string(), "",
                      "contains no mask for any of the " + std::to_string(cameras.size()) + " cameras",
                      "name masks like the photos, for example " +
                          (cameras.empty() ? std::string("0001") : cameras.front().name) + ".png");
  if (!missing.empty()) {
    std::string names;
    for (size_t i = 0; i < missing.size() && i < 5; ++i) names += (i ? ", " : "") + missing[i];
    if (missing.size() > 5) names += ", ...";
    masks.warnings.push_back(std::to_string(missing.size()) + " of " + std::to_string(cameras.size()) +
                             " cameras have no mask in " + folder.string() + ": " + names);
  }
  const std::vector<uint32_t> ids = masks.ids();
  if (ids.empty())
    throw input_error(folder.string(), "", "contains masks without any object: every pixel is 0 (unlabeled)",
                      "give every object an ID above 0; the rest of the scene needs an ID too");
  if (!labels.empty()) read_names(folder, labels, masks);
  show_background(ids, complete, masks);
  return masks;
}

}  // namespace pliant
