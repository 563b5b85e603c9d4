#include "fitting/observe/frame_source.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/images/codecs.h"
#include "gaussians/io/images/image_files.h"
#include "gaussians/io/images/image_io.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

/// Whether a comes before b when runs of digits are compared as numbers.
bool before(const std::string& a, const std::string& b) {
  const auto digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (!digit(a[i]) || !digit(b[j])) {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
      continue;
    }
    while (i < a.size() && a[i] == '0') ++i;
    while (j < b.size() && b[j] == '0') ++j;
    size_t m = i, n = j;
    while (m < a.size() && digit(a[m])) ++m;
    while (n < b.size() && digit(b[n])) ++n;
    if (m - i != n - j) return m - i < n - j;
    const int order = a.compare(i, m - i, b, j, n - j);
    if (order != 0) return order < 0;
    i = m;
    j = n;
  }
  return a.size() - i != b.size() - j ? a.size() - i < b.size() - j : a < b;
}

class VideoFile : public FrameSource {
 public:
  explicit VideoFile(const fs::path& file) : file_(file) {
    try {
      capture_ = codecs::open_video(file.string());
    } catch (const cv::Exception&) {
    }
    if (!capture_ || !capture_->isOpened()) {
      throw input_error(file.string(), "", "is not a video that can be decoded",
                        "give an mp4 (H.264), or a folder of images; `ffmpeg -i F out.mp4` converts most formats");
    }
    fps_ = capture_->get(cv::CAP_PROP_FPS);
    const double count = capture_->get(cv::CAP_PROP_FRAME_COUNT);
    frames_ = count > 0 && count < 1e8 ? static_cast<int>(count) : 0;
  }

  std::optional<TimedFrame> next() override {
    cv::Mat bgr;
    try {
      if (!capture_->read(bgr) || bgr.empty()) return std::nullopt;
    } catch (const cv::Exception& error) {
      throw input_error(file_.string(), "", "cannot be decoded: " + error.err, "convert it with ffmpeg");
    }
    CHECK(bgr.type() == CV_8UC3);
    TimedFrame frame;
    frame.picture = ImageF(bgr.cols, bgr.rows, 3);
    for (int y = 0; y < bgr.rows; ++y) {
      const uint8_t* row = bgr.ptr<uint8_t>(y);
      float* out = frame.picture.at(0, y);
      for (int x = 0; x < bgr.cols; ++x)
        for (int c = 0; c < 3; ++c) out[3 * x + c] = static_cast<float>(row[3 * x + 2 - c]) * (1.0f / 255);
    }
    // Time stamps that do not grow are no time stamps: then the rate tells the instant.
    const double stamp = capture_->get(cv::CAP_PROP_POS_MSEC) / 1000;
    if (read_ == 0) first_stamp_ = stamp;
    const double since_first = stamp - first_stamp_;
    frame.time = read_ == 0 || since_first > last_ ? since_first : fps_ > 0 ? read_ / fps_ : 0;
    last_ = frame.time;
    ++read_;
    return frame;
  }
  double fps() const override { return fps_; }
  int frames() const override { return frames_; }

 private:
  fs::path file_;
  std::unique_ptr<cv::VideoCapture> capture_;
  double fps_ = 0, first_stamp_ = 0, last_ = 0;
  int frames_ = 0, read_ = 0;
};

class PictureFolder : public FrameSource {
 public:
  PictureFolder(const fs::path& folder, double fps) : files_(pictures_in_order(folder)), fps_(fps) {
    if (files_.empty()) {
      throw input_error(folder.string(), "", "has no images",
                        "give a video file, or a folder of numbered PNG or JPEG frames");
    }
  }
  std::optional<TimedFrame> next() override {
    if (read_ >= files_.size()) return std::nullopt;
    TimedFrame frame{static_cast<double>(read_) / fps_, read_image(files_[read_])};
    const ImageF& picture = frame.picture;
    if (read_ == 0) {
      width_ = picture.width;
      height_ = picture.height;
    }
    if (picture.width != width_ || picture.height != height_) {
      throw input_error(files_[read_].string(), "",
                        "has " + std::to_string(picture.width) + " x " + std::to_string(picture.height) +
                            " pixels, but " + files_[0].filename().string() + " has " + std::to_string(width_) + " x " +
                            std::to_string(height_),
                        "keep only the frames of one video in the folder");
    }
    ++read_;
    return frame;
  }
  double fps() const override { return 0; }
  int frames() const override { return static_cast<int>(files_.size()); }

 private:
  std::vector<fs::path> files_;
  double fps_;
  size_t read_ = 0;
  int width_ = 0, height_ = 0;
};

}  // namespace

std::vector<fs::path> pictures_in_order(const fs::path& folder) {
  std::vector<fs::path> files = images_in(folder);
  std::sort(files.begin(), files.end(),
            [](const fs::path& a, const fs::path& b) { return before(a.filename().string(), b.filename().string()); });
  return files;
}

std::unique_ptr<FrameSource> open_frames(const fs::path& file_or_folder, double folder_fps) {
  std::error_code ignored;
  if (!fs::exists(file_or_folder, ignored)) {
    throw input_error(file_or_folder.string(), "", "does not exist", "check the name of the reference video");
  }
  if (!fs::is_directory(file_or_folder, ignored)) return std::make_unique<VideoFile>(file_or_folder);
  if (!(folder_fps > 0)) {
    throw input_error(file_or_folder.string(), "fps", "is unknown: a folder of images has no frame rate",
                      "give the rate of the camera, in the scene file (video.fps), with --video-fps (fit, run) or "
                      "--fps (evaluate motion)");
  }
  return std::make_unique<PictureFolder>(file_or_folder, folder_fps);
}

}  // namespace pliant
