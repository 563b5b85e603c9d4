#include "gaussians/reconstruct/training_photos.h"

#include <algorithm>
#include <array>
#include <list>
#include <memory>
#include <mutex>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/photo.h"
#include "gaussians/reconstruct/undistort.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr int kMostNamed = 10;  // photos that are named one by one in warnings

std::string size_text(int width, int height) { return std::to_string(width) + " x " + std::to_string(height); }

/// What became of one photo.
struct Loaded {
  std::optional<TrainingPhoto> photo;
  std::string problem;  // why it is left out
  std::string unclear;  // an orientation that sizes cannot tell
  bool turned = false, fitted = false, scaled = false, undistorted = false, composited = false;
};

/// Turns the picture when only then it has the shape of the camera.  False when it has another shape either way.
bool orient(Photo& photo, const Camera& camera, Loaded& loaded) {
  const int width = photo.pixels.width, height = photo.pixels.height;
  if (same_shape(camera, width, height)) {
    if (photo.orientation != 1 && (photo.orientation < 5 || width == height)) {
      loaded.unclear = camera.photo + ": the orientation flag is " + std::to_string(photo.orientation) +
                       " and does not change the size; the camera is assumed to be that of the stored pixels";
    }
    return true;
  }
  if (photo.orientation < 5 || !same_shape(camera, height, width)) return false;
  photo.pixels = oriented(photo.pixels, photo.orientation);
  if (!photo.alpha.empty()) photo.alpha = oriented(photo.alpha, photo.orientation);
  return loaded.turned = true;
}

void composite(const Vec3f& background, Photo& photo) {
  for (size_t i = 0; i < photo.alpha.data.size(); ++i) {
    const float alpha = photo.alpha.data[i] / 255.0f;
    for (int c = 0; c < 3; ++c) {
      uint8_t& value = photo.pixels.data[3 * i + c];
      value = static_cast<uint8_t>(std::clamp(alpha * value + (1 - alpha) * 255 * background[c] + 0.5f, 0.0f, 255.0f));
    }
  }
}

cv::Mat view_of(const ImageU8& image) {
  return cv::Mat(image.height, image.width, CV_8UC(image.channels), const_cast<uint8_t*>(image.data.data()));
}

void scale_down(int longest_side, TrainingPhoto& photo, Loaded& loaded) {
  const int longest = std::max(photo.pixels.width, photo.pixels.height);
  if (longest_side <= 0 || longest <= longest_side) return;
  const double scale = static_cast<double>(longest_side) / longest;
  const Camera camera = photo.camera.scaled(scale);
  const auto smaller = [&](const ImageU8& image) {
    ImageU8 small(camera.width, camera.height, image.channels);
    cv::Mat target = view_of(small);
    cv::resize(view_of(image), target, target.size(), 0, 0, cv::INTER_AREA);
    return small;
  };
  photo.pixels = smaller(photo.pixels);
  if (!photo.alpha.empty()) photo.alpha = smaller(photo.alpha);
  photo.camera = camera;
  loaded.scaled = true;
}

/// The maps of the lenses met last; photos of one camera share them.  Different lenses are computed at the same time.
class Lenses {
 public:
  std::shared_ptr<const Undistortion> of(const Camera& camera) {
    Key key = {camera.fx, camera.fy, camera.cx, camera.cy, double(camera.width), double(camera.height)};
    std::copy(camera.distortion.begin(), camera.distortion.end(), key.begin() + 6);
    const std::shared_ptr<Known> known = entry(key);
    const std::lock_guard lock(known->mutex);
    if (!known->map) known->map = std::make_shared<Undistortion>(make_undistortion(camera));
    return known->map;
  }

 private:
  using Key = std::array<double, 12>;
  struct Known {
    std::mutex mutex;
    std::shared_ptr<const Undistortion> map;
  };
  static constexpr size_t kMostKnown = 8;

  std::shared_ptr<Known> entry(const Key& key) {
    const std::lock_guard lock(mutex_);
    const auto found =
        std::find_if(known_.begin(), known_.end(), [&](const auto& known) { return known.first == key; });
    if (found != known_.end()) {
      known_.splice(known_.begin(), known_, found);
    } else {
      known_.emplace_front(key, std::make_shared<Known>());
      if (known_.size() > kMostKnown) known_.pop_back();
    }
    return known_.front().second;
  }

  std::mutex mutex_;
  std::list<std::pair<Key, std::shared_ptr<Known>>> known_;  // last used first
};

void undo_lens(Lenses& lenses, TrainingPhoto& photo, Loaded& loaded) {
  if (photo.camera.distortion == Camera().distortion) return;
  photo.lens = photo.camera;
  const auto lens = lenses.of(photo.camera);
  const Camera& pinhole = lens->pinhole;
  photo.pixels = undistorted(*lens, photo.pixels);
  if (!photo.alpha.empty()) photo.alpha = undistorted(*lens, photo.alpha);
  if (!lens->all_inside) {
    photo.weight = ImageU8(pinhole.width, pinhole.height, 1);
    for (size_t i = 0; i < lens->seen.size(); ++i) photo.weight.data[i] = lens->seen[i].allFinite() ? 255 : 0;
  }
  photo.camera.width = pinhole.width;
  photo.camera.height = pinhole.height;
  photo.camera.fx = pinhole.fx;
  photo.camera.fy = pinhole.fy;
  photo.camera.cx = pinhole.cx;
  photo.camera.cy = pinhole.cy;
  photo.camera.distortion = {};
  loaded.undistorted = true;
}

Loaded load_photo(const PhotoOptions& options, const Camera& camera, Lenses& lenses) {
  Loaded loaded;
  Photo stored = read_photo(camera.photo);
  if (!orient(stored, camera, loaded)) {
    loaded.problem = camera.photo + ": has " + size_text(stored.pixels.width, stored.pixels.height) +
                     " pixels, but its camera has another aspect ratio, " + size_text(camera.width, camera.height) +
                     (same_shape(camera, stored.pixels.height, stored.pixels.width)
                          ? ": the photo was rotated, or the camera's width and height are swapped"
                          : "");
    return loaded;
  }
  if (!stored.alpha.empty()) {
    composite(options.background, stored);
    loaded.composited = true;
  }
  TrainingPhoto photo;
  photo.camera = camera;
  photo.pixels = std::move(stored.pixels);
  photo.alpha = std::move(stored.alpha);
  loaded.fitted = photo.pixels.width != camera.width || photo.pixels.height != camera.height;
  if (loaded.fitted) photo.camera = camera.resized(photo.pixels.width, photo.pixels.height);
  scale_down(options.longest_side, photo, loaded);
  undo_lens(lenses, photo, loaded);
  if (std::min(photo.camera.width, photo.camera.height) < kSmallestSide) {
    loaded.problem = camera.photo + ": is " + size_text(photo.camera.width, photo.camera.height) +
                     " pixels as it is trained on, and a side needs at least " + std::to_string(kSmallestSide) +
                     (loaded.scaled ? ": give a larger --max-image-size" : "");
    return loaded;
  }
  photo.changed = loaded.turned || loaded.scaled || loaded.undistorted || loaded.composited;
  loaded.photo = std::move(photo);
  return loaded;
}

/// "NAME: 3 of 50 photos WHAT", once for all of them.
void say_how_many(const std::vector<Loaded>& loaded, bool Loaded::*what, const std::string& where,
                  const std::string& sentence, std::vector<std::string>& warnings) {
  const auto count = std::count_if(loaded.begin(), loaded.end(), [&](const Loaded& l) { return l.photo && l.*what; });
  if (count == 0) return;
  warnings.push_back(where + ": " + std::to_string(count) + " of " + std::to_string(loaded.size()) + " photos " +
                     sentence);
}

void say_each(const std::vector<Loaded>& loaded, std::string Loaded::*what, const std::string& ending,
              std::vector<std::string>& warnings) {
  int count = 0;
  for (const Loaded& l : loaded) {
    if (!(l.*what).empty() && ++count <= kMostNamed) warnings.push_back(l.*what + ending);
  }
  if (count > kMostNamed) warnings.push_back("and " + std::to_string(count - kMostNamed) + " photos more like this");
}

void check_enough(const PhotoOptions& options, const std::string& where, const std::string& lost,
                  const TrainingPhotos& result) {
  const auto usable = result.photos.size();
  const auto held_out = static_cast<size_t>(
      std::count_if(result.photos.begin(), result.photos.end(), [](const TrainingPhoto& p) { return p.held_out; }));
  if (usable < kFewestPhotos) {
    throw input_error(
        where, "",
        "has " +
            (usable == 0   ? "no usable photo"
             : usable == 1 ? "only one usable photo"
                           : "only " + std::to_string(usable) + " usable photos") +
            lost,
        "a scene needs at least " + std::to_string(kFewestPhotos) +
            " photos from different places (with fewer, depth and hidden parts stay unknown), better 30 or more");
  }
  if (held_out == usable) {
    throw usage_error("--hold-out-every", std::to_string(options.hold_out_every),
                      "leaves no photo to train on: all " + std::to_string(usable) + " are held out",
                      "give 8, or 0 for none");
  }
}

}  // namespace

TrainingPhotos load_training_photos(const PhotoOptions& options, const CameraFile& file) {
  const std::string where = file.files.empty() ? "cameras" : file.files.front().string();
  std::vector<Camera> cameras = file.cameras;
  std::sort(cameras.begin(), cameras.end(), [](const Camera& a, const Camera& b) { return a.name < b.name; });
  std::vector<Loaded> loaded(cameras.size());
  Lenses lenses;
  parallel_for(static_cast<std::ptrdiff_t>(cameras.size()), [&](std::ptrdiff_t i) {
    try {
      loaded[i] = load_photo(options, cameras[i], lenses);
    } catch (const Error& error) {
      loaded[i].problem = error.what();
    }
  });

  TrainingPhotos result;
  say_each(loaded, &Loaded::problem, "; the photo is ignored", result.warnings);
  const auto lost = std::count_if(loaded.begin(), loaded.end(), [](const Loaded& l) { return !l.photo; });
  std::string share;
  if (lost > 0) {
    share = std::to_string(lost) + " of " + std::to_string(loaded.size()) + " photos (" +
            std::to_string((200 * lost + static_cast<long>(loaded.size())) / (2 * static_cast<long>(loaded.size()))) +
            " %) cannot be used";
    result.warnings.push_back(where + ": " + share);
  }
  say_how_many(loaded, &Loaded::turned, where, "are rotated by their orientation flags, to match their cameras",
               result.warnings);
  say_how_many(loaded, &Loaded::fitted, where, "have another size than their cameras, which are scaled to them",
               result.warnings);
  say_each(loaded, &Loaded::unclear, "", result.warnings);

  for (Loaded& l : loaded) {
    if (!l.photo) continue;
    const auto index = static_cast<int>(result.photos.size());
    l.photo->held_out = options.hold_out_every > 0 && index % options.hold_out_every == 0;
    result.changed = result.changed || l.photo->changed;
    result.photos.push_back(std::move(*l.photo));
  }
  check_enough(
      options, where,
      lost > 0 ? "; " + share + (result.warnings.empty() ? "" : ", the first: " + result.warnings.front()) : "",
      result);
  return result;
}

std::vector<Camera> write_training_photos(const fs::path& folder, const TrainingPhotos& photos) {
  std::vector<Camera> cameras;
  for (const TrainingPhoto& photo : photos.photos) cameras.push_back(photo.camera);
  if (!photos.changed) return cameras;
  fs::create_directories(folder);
  parallel_for(static_cast<std::ptrdiff_t>(cameras.size()), [&](std::ptrdiff_t i) {
    const TrainingPhoto& photo = photos.photos[i];
    if (!photo.changed) return;
    ImageF picture(photo.pixels.width, photo.pixels.height, 3);
    for (size_t k = 0; k < picture.data.size(); ++k) picture.data[k] = photo.pixels.data[k] / 255.0f;
    const fs::path file = folder / (photo.camera.name + ".png");
    write_image(file, picture);
    cameras[i].photo = file.string();
  });
  return cameras;
}

}  // namespace pliant
