#include "segmentation/sheets/objects_sheet.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr int kCrop = 180, kCaption = 40, kGap = 8;
constexpr size_t kMostObjects = 200;

/// An ImageF's pixels as an OpenCV matrix that shares them.
cv::Mat view_of(ImageF& image) { return cv::Mat(image.height, image.width, CV_32FC3, image.data.data()); }

struct Extent {
  int x0 = INT32_MAX, y0 = INT32_MAX, x1 = -1, y1 = -1;
  size_t pixels = 0;
};

std::map<uint32_t, Extent> extents(const IdImage& ids) {
  std::map<uint32_t, Extent> found;
  for (int y = 0; y < ids.height; ++y)
    for (int x = 0; x < ids.width; ++x) {
      if (ids(x, y) == 0) continue;
      Extent& e = found[ids(x, y)];
      e.x0 = std::min(e.x0, x);
      e.x1 = std::max(e.x1, x);
      e.y0 = std::min(e.y0, y);
      e.y1 = std::max(e.y1, y);
      ++e.pixels;
    }
  return found;
}

void write(cv::Mat& sheet, const std::string& text, int x, int y, double size, const cv::Scalar& color) {
  cv::putText(sheet, text, {x, y}, cv::FONT_HERSHEY_SIMPLEX, size, color, 1, cv::LINE_AA);
}

/// Text shortened until it fits into `width` pixels.
std::string fitted(std::string text, double size, int width) {
  while (text.size() > 1 && cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, nullptr).width > width)
    text.pop_back();
  return text;
}

/// The object's surroundings, squared off; it may reach beyond the picture.
cv::Rect surroundings(const Extent& e) {
  const int side = static_cast<int>(1.25 * std::max(e.x1 - e.x0, e.y1 - e.y0)) + 8;
  return cv::Rect((e.x0 + e.x1 - side) / 2, (e.y0 + e.y1 - side) / 2, side, side);
}

/// That part of the picture, scaled to kCrop.
cv::Mat crop_of(const cv::Mat& picture, const cv::Rect& wanted) {
  const int side = wanted.width;
  const cv::Rect inside = wanted & cv::Rect(0, 0, picture.cols, picture.rows);
  cv::Mat square(side, side, CV_32FC3, cv::Scalar::all(0.15)), out;
  picture(inside).copyTo(square(cv::Rect(inside.x - wanted.x, inside.y - wanted.y, inside.width, inside.height)));
  cv::resize(square, out, {kCrop, kCrop}, 0, 0, side > kCrop ? cv::INTER_AREA : cv::INTER_CUBIC);
  return out;
}

/// The objects with the most Gaussians, as many as a sheet shows, in their order.
std::vector<ObjectEntry> largest_objects(std::vector<ObjectEntry> objects) {
  if (objects.size() <= kMostObjects) return objects;
  const auto larger = [](const auto& a, const auto& b) { return a.gaussians > b.gaussians; };
  std::stable_sort(objects.begin(), objects.end(), larger);
  objects.resize(kMostObjects);
  std::sort(objects.begin(), objects.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  return objects;
}

}  // namespace

Vec3f id_color(uint32_t id) {
  const float hue = std::fmod(0.13f + 0.618034f * static_cast<float>(id % 4096), 1.0f) * 6,
              value = id % 2 ? 1.0f : 0.85f;
  const float rise = hue - std::floor(hue), fall = 1 - rise;
  switch (static_cast<int>(hue) % 6) {
    case 0:
      return value * Vec3f(1, rise, 0);
    case 1:
      return value * Vec3f(fall, 1, 0);
    case 2:
      return value * Vec3f(0, 1, rise);
    case 3:
      return value * Vec3f(0, fall, 1);
    case 4:
      return value * Vec3f(rise, 0, 1);
    default:
      return value * Vec3f(1, 0, fall);
  }
}

ImageF overlay_ids(const ImageF& picture, const IdImage& ids, float strength) {
  CHECK(picture.width == ids.width && picture.height == ids.height && picture.channels == 3);
  ImageF out = picture;
  for (int y = 0; y < ids.height; ++y)
    for (int x = 0; x < ids.width; ++x) {
      const uint32_t id = ids(x, y);
      if (id == 0) continue;
      const bool edge = (x + 1 < ids.width && ids(x + 1, y) != id) || (y + 1 < ids.height && ids(x, y + 1) != id);
      const float mix = edge ? 0.95f : strength;
      const Vec3f color = id_color(id);
      for (int k = 0; k < 3; ++k) out(x, y, k) += mix * (color[k] - out(x, y, k));
    }
  return out;
}

ImageF objects_sheet(const Segmentation& segmentation, const GaussianCloud& cloud, const std::vector<Camera>& cameras,
                     const std::function<ImageF(int camera)>& picture, int max_views, std::vector<SheetCell>* cells) {
  CHECK(!cameras.empty());
  // Where every object is largest, and the view whose smallest shown share over all objects is best.
  struct Best {
    int camera = -1;
    Extent extent;
  };
  std::map<uint32_t, Best> best;
  std::map<int, IdImage> looked_at;
  const int views = std::min<int>(max_views, static_cast<int>(cameras.size()));
  for (int v = 0; v < views; ++v) {
    const int camera = static_cast<int>(static_cast<size_t>(v) * cameras.size() / views);
    IdImage& ids = looked_at[camera] = render_ids(segmentation, cloud, cameras[camera]);
    for (const auto& [id, extent] : extents(ids))
      if (extent.pixels > best[id].extent.pixels) best[id] = {camera, extent};
  }
  int overview = looked_at.begin()->first;
  double most = -1;
  for (const auto& [camera, ids] : looked_at) {
    double shown = 0;
    for (const auto& [id, extent] : extents(ids))
      shown += std::sqrt(static_cast<double>(extent.pixels) / static_cast<double>(best[id].extent.pixels));
    if (shown > most) {
      most = shown;
      overview = camera;
    }
  }

  ImageF top = overlay_ids(picture(overview), looked_at[overview]);
  const int per_row = std::max(1, (std::max(top.width, 4 * (kCrop + kGap)) + kGap) / (kCrop + kGap));
  const int width = std::max(top.width + 2 * kGap, per_row * (kCrop + kGap) + kGap);
  const std::vector<ObjectEntry> objects = largest_objects(list_objects(segmentation, cloud.position));
  const size_t left_out = segmentation.class_id.size() - objects.size();
  const int rows = (static_cast<int>(objects.size()) + per_row - 1) / per_row;
  const int bottom = top.height + 2 * kGap + rows * (kCrop + kCaption + kGap);
  ImageF image(width, bottom + (left_out > 0 ? kCaption : 0), 3, 0.1f);
  cv::Mat sheet = view_of(image);
  if (left_out > 0)
    write(sheet, std::to_string(left_out) + " smaller objects are not shown", kGap, bottom + 16, 0.5,
          cv::Scalar::all(0.8));
  view_of(top).copyTo(sheet(cv::Rect((width - top.width) / 2, kGap, top.width, top.height)));

  std::vector<SheetCell> shown = {{(width - top.width) / 2, kGap, top.width, top.height, overview, 0, 0, 1}};

  std::map<int, cv::Mat> pictures;
  for (size_t k = 0; k < objects.size(); ++k) {
    const ObjectEntry& object = objects[k];
    const int x = kGap + static_cast<int>(k) % per_row * (kCrop + kGap);
    const int y = top.height + 2 * kGap + static_cast<int>(k) / per_row * (kCrop + kCaption + kGap);
    const Vec3f color = id_color(object.id);
    if (const auto it = best.find(object.id); it != best.end()) {
      cv::Mat& photo = pictures[it->second.camera];
      if (photo.empty()) {
        ImageF outlined = overlay_ids(picture(it->second.camera), looked_at[it->second.camera], 0.0f);
        photo = view_of(outlined).clone();
      }
      const cv::Rect part = surroundings(it->second.extent);
      shown.push_back(
          {x, y, kCrop, kCrop, it->second.camera, double(part.x), double(part.y), double(part.width) / kCrop});
      crop_of(photo, part).copyTo(sheet(cv::Rect(x, y, kCrop, kCrop)));
    } else {
      write(sheet, "not visible", x + 8, y + kCrop / 2, 0.45, cv::Scalar::all(0.6));
    }
    const cv::Scalar ink(color[0], color[1], color[2]);
    cv::rectangle(sheet, cv::Rect(x, y, kCrop, kCrop), ink, 1);
    char detail[64];
    std::snprintf(detail, sizeof(detail), "%zu Gaussians  %.2f", object.gaussians, object.score);
    write(sheet, fitted(std::to_string(object.id) + "  " + object.name, 0.5, kCrop), x, y + kCrop + 16, 0.5, ink);
    write(sheet, fitted(detail, 0.4, kCrop), x, y + kCrop + 33, 0.4, cv::Scalar::all(0.8));
  }
  if (cells) *cells = std::move(shown);
  return image;
}

}  // namespace pliant
