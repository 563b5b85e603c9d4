#include "segmentation/labels/mask_layouts.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>

#include "gaussians/base/error.h"
#include "gaussians/io/images/image_files.h"
#include "gaussians/io/images/image_io.h"

namespace pliant {
namespace fs = std::filesystem;

namespace {

constexpr size_t kFewestIds = 3;  // small values by which masks with IDs are told from binary ones

/// One binary picture: what it shows and in which camera.
struct BinaryMask {
  std::string label;
  int camera = -1;
  fs::path file;
};

std::vector<fs::path> sorted_entries(const fs::path& folder) {
  std::vector<fs::path> entries;
  for (const auto& entry : fs::directory_iterator(folder)) entries.push_back(entry.path());
  std::sort(entries.begin(), entries.end());
  return entries;
}

int camera_named(const std::vector<Camera>& cameras, const std::string& name) {
  for (size_t c = 0; c < cameras.size(); ++c)
    if (cameras[c].name == name) return static_cast<int>(c);
  return -1;
}

std::optional<uint32_t> whole_number(const std::string& text) {
  uint32_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// Cameras whose photos are not in images_train/ beside the masks, by name; empty without that folder.
std::vector<int> novel_cameras(const fs::path& folder, const std::vector<Camera>& cameras) {
  std::vector<int> novel;
  const std::set<std::string> trained = trained_photos(folder);
  if (trained.empty()) return novel;
  for (size_t c = 0; c < cameras.size(); ++c)
    if (!trained.count(fs::path(cameras[c].name).stem().string())) novel.push_back(static_cast<int>(c));
  std::sort(novel.begin(), novel.end(), [&](int a, int b) { return cameras[a].name < cameras[b].name; });
  return novel;
}

/// The binary pictures in the folders of `folder`, by what the folders are named after: cameras, or what is shown.
/// One layout holds for all of them, the one that more files fit.
std::vector<BinaryMask> masks_in_folders(const fs::path& folder, const std::vector<Camera>& cameras) {
  const std::vector<int> novel = novel_cameras(folder, cameras);
  std::vector<BinaryMask> of_cameras, of_labels;
  for (const fs::path& inner : sorted_entries(folder)) {
    if (!fs::is_directory(inner)) continue;
    const std::string name = inner.filename().string();
    int view = camera_named(cameras, name);
    if (const auto number = whole_number(name); view < 0 && number && *number < novel.size()) view = novel[*number];
    for (const fs::path& file : sorted_entries(inner)) {
      if (!is_image_file(file)) continue;
      const std::string stem = file.stem().string();
      if (view >= 0) of_cameras.push_back({stem, view, file});
      if (const int camera = camera_named(cameras, stem); camera >= 0) of_labels.push_back({name, camera, file});
    }
  }
  if (of_cameras.size() == of_labels.size() && !of_labels.empty())
    throw input_error(
        folder.string(), "",
        "has folders and files that are both named like photos (" + of_labels[0].file.string() +
            "): they can be read as <object>/<photo> and as <photo>/<object>",
        "rename what stands for objects, for example " + of_labels[0].label + " to object_" + of_labels[0].label);
  return of_cameras.size() > of_labels.size() ? of_cameras : of_labels;
}

std::vector<BinaryMask> find_masks(const fs::path& folder, const std::vector<Camera>& cameras) {
  std::vector<BinaryMask> masks = masks_in_folders(folder, cameras);
  // JPEG keeps no IDs exactly, but it does tell an object from the rest.
  for (const fs::path& file : sorted_entries(folder))
    if (const int camera =
            is_jpeg_file(file) && !fs::is_directory(file) ? camera_named(cameras, file.stem().string()) : -1;
        camera >= 0)
      masks.push_back({"object", camera, file});
  return masks;
}

/// The largest value in the pictures of each label.  Throws where together they hold values like those of IDs.
std::map<std::string, float> largest_values(const fs::path& folder, const std::vector<BinaryMask>& masks) {
  std::map<std::string, float> largest;
  std::set<float> values;
  float brightest = 0;
  for (const BinaryMask& mask : masks) {
    float& of_label = largest[mask.label];
    if (of_label >= 1) continue;  // no picture has more
    const ImageF picture = read_image(mask.file);
    const bool may_hold_ids = !is_jpeg_file(mask.file);
    float last = 0;
    for (const float value : picture.data) {
      if (may_hold_ids && value != last && value > 0 && values.size() < kFewestIds) values.insert(value);
      last = value;
      of_label = std::max(of_label, value);
    }
    brightest = std::max(brightest, of_label);
  }
  if (values.size() >= kFewestIds && brightest < 0.5f)
    throw input_error(folder.string(), "",
                      "has masks in folders that hold " + std::to_string(kFewestIds) +
                          " or more small values, as ID masks do, where black and white is expected",
                      "put ID masks into one folder, or into folders like those of the photos, and name them like "
                      "the photos; make binary masks white on black");
  return largest;
}

/// Pixels above half of `largest`, the largest value in all pictures of the label: one that does not show the object
/// may hold weak traces of it.
ImageU8 read_binary(const fs::path& file, float largest, const Camera& camera, bool any_size) {
  const ImageF picture = read_image(file);
  check_mask_size(file, picture.width, picture.height, camera, any_size);
  ImageU8 inside(picture.width, picture.height, 1);
  size_t between = 0;
  for (size_t i = 0; i < inside.data.size() && largest > 0; ++i) {
    const float* rgb = picture.data.data() + 3 * i;
    const float brightest = std::max({rgb[0], rgb[1], rgb[2]});
    inside.data[i] = brightest > 0.5f * largest;
    between += std::abs(brightest - 0.5f * largest) < 0.3f * largest;
  }
  if (is_jpeg_file(file) && between * 5 > inside.data.size())
    throw input_error(file.string(), "", "shows more than black and white",
                      "as JPEG, a mask shows one object in white; masks with IDs must be PNG");
  return inside;
}

/// Numbers the labels, and names the ids unless the labels are ids themselves.
std::map<std::string, uint32_t> ids_of_labels(const std::vector<BinaryMask>& masks,
                                              std::map<uint32_t, std::string>& names) {
  std::map<std::string, uint32_t> ids;
  for (const BinaryMask& mask : masks) ids[mask.label] = 0;
  const bool are_ids = std::all_of(ids.begin(), ids.end(), [](const auto& entry) {
    const uint32_t number = whole_number(entry.first).value_or(0);
    return number > 0 && number <= kLargestId;
  });
  uint32_t next = 1;
  for (auto& [label, id] : ids) {
    id = are_ids ? *whole_number(label) : next++;
    if (!are_ids) names[id] = label;
  }
  return ids;
}

}  // namespace

std::set<std::string> trained_photos(const fs::path& masks) {
  // With a slash at its end, a folder would be its own parent.
  const fs::path trained = (masks.has_filename() ? masks : masks.parent_path()).parent_path() / "images_train";
  std::set<std::string> names;
  if (!fs::is_directory(trained)) return names;
  for (const fs::path& file : sorted_entries(trained)) names.insert(file.stem().string());
  return names;
}

void check_mask_size(const fs::path& file, int width, int height, const Camera& camera, bool any_size) {
  if (width == camera.width && height == camera.height) return;
  const std::string sizes = "is " + std::to_string(width) + "x" + std::to_string(height) + ", but camera " +
                            camera.name + " is " + std::to_string(camera.width) + "x" + std::to_string(camera.height);
  if (!any_size) throw input_error(file.string(), "", sizes, "make masks at the size of the photos");
  // A side that was rounded by a pixel is the same shape.
  const double skew = std::abs(1.0 * width * camera.height - 1.0 * height * camera.width);
  if (skew > std::max({width, height, camera.width, camera.height}))
    throw input_error(file.string(), "", sizes, "make masks of the shape of the photos");
}

BinaryMasks load_binary_masks(const fs::path& folder, const std::vector<Camera>& cameras, const FitMask& fit) {
  const std::vector<BinaryMask> found = find_masks(folder, cameras);
  const std::map<std::string, float> largest = largest_values(folder, found);
  BinaryMasks read;
  MaskSet& masks = read.masks;
  const std::map<std::string, uint32_t> ids = ids_of_labels(found, masks.names);
  for (size_t c = 0; c < cameras.size(); ++c) {
    struct Layer {
      uint32_t id;
      ImageU8 inside;
      std::ptrdiff_t pixels;
    };
    std::vector<Layer> layers;
    std::set<uint32_t> shown;
    for (const BinaryMask& mask : found) {
      if (mask.camera != static_cast<int>(c)) continue;
      ImageU8 inside = read_binary(mask.file, largest.at(mask.label), cameras[c], fit != nullptr);
      if (!layers.empty() && (inside.width != layers[0].inside.width || inside.height != layers[0].inside.height))
        throw input_error(mask.file.string(), "",
                          "is " + std::to_string(inside.width) + "x" + std::to_string(inside.height) +
                              ", but another mask of camera " + cameras[c].name + " is " +
                              std::to_string(layers[0].inside.width) + "x" + std::to_string(layers[0].inside.height),
                          "make masks at the size of the photos");
      const auto pixels = std::count(inside.data.begin(), inside.data.end(), 1);
      layers.push_back({ids.at(mask.label), std::move(inside), pixels});
      shown.insert(ids.at(mask.label));
    }
    if (layers.empty()) continue;
    if (shown.size() == ids.size()) read.complete.push_back(masks.views.size());
    std::stable_sort(layers.begin(), layers.end(), [](const Layer& a, const Layer& b) { return a.pixels > b.pixels; });
    IdImage picture(layers[0].inside.width, layers[0].inside.height, 1);
    for (const Layer& layer : layers)
      for (size_t i = 0; i < picture.data.size(); ++i)
        if (layer.inside.data[i]) picture.data[i] = layer.id;
    masks.views.push_back({static_cast<int>(c), fit ? fit(picture, static_cast<int>(c)) : std::move(picture)});
  }
  return read;
}

}  // namespace pliant
