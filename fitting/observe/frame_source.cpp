#include "fitting/observe/frame_source.h"

#include <algorithm>
#include <opencv2/core.hpp>

#include "fitting/observe/frame_clock.h"
#include "fitting/observe/frame_numbers.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/number_order.h"
#include "gaussians/io/images/codecs.h"
#include "gaussians/io/images/image_files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/video_color.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr int kScanned = 1000;  // frames whose time stamps tell the rate

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
    const double count = capture_->get(cv::CAP_PROP_FRAME_COUNT);
    frames_ = count > 0 && count < 1e8 ? static_cast<int>(count) : 0;
    color_ = video_color(file);
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
    if (color_.correction) correct_colors(*color_.correction, frame.picture);
    const double stamp = capture_->get(cv::CAP_PROP_POS_MSEC) / 1000;
    if (read_ == 0) first_stamp_ = stamp;
    // Time stamps that do not grow, as of the last frames in some files, are none: then the rate tells the instant.
    if (read_ > 0) {
      const double since_first = clock().instant(stamp - first_stamp_);
      frame.time = since_first > last_ ? since_first : clock().rate > 0 ? last_ + 1 / clock().rate : 0;
    }
    last_ = frame.time;
    ++read_;
    return frame;
  }
  double fps() override { return clock().rate; }
  int frames() const override { return frames_; }
  std::string doubt() const override {
    if (color_.hdr)
      return file_.string() +
             " is in HDR, and is read without tone mapping: its colors are flat beside those of a scene trained on "
             "ordinary photos; film with HDR video off, or convert it: `ffmpeg -i F -vf zscale=t=linear:npl=100,"
             "tonemap=hable,zscale=p=bt709:t=bt709:m=bt709:r=tv,format=yuv420p out.mp4`";
    if (!color_.correction || !color_.correction->guessed) return "";
    return file_.string() +
           " does not say how its colors are coded, and is read as BT.709, as players show HD video; if its colors are "
           "off, say it in the file: `ffmpeg -i F -c copy -bsf:v h264_metadata=matrix_coefficients=6 out.mp4` for "
           "BT.601";
  }

 private:
  /// Reads the time stamps of the file when they are first needed: a first frame alone has none to compare.
  const FrameClock& clock() {
    if (clock_) return *clock_;
    std::vector<double> stamps;
    try {
      const std::unique_ptr<cv::VideoCapture> scan = codecs::open_video(file_.string());
      double first = 0;
      for (int f = 0; f < kScanned && scan->grab(); ++f) {
        const double stamp = scan->get(cv::CAP_PROP_POS_MSEC) / 1000;
        if (f == 0) first = stamp;
        if (f > 0 && !(stamp - first > stamps.back())) break;
        stamps.push_back(stamp - first);
      }
    } catch (const cv::Exception&) {
      // `next` says what cannot be decoded.
    }
    clock_ = clock_of(stamps, capture_->get(cv::CAP_PROP_FPS));
    return *clock_;
  }

  fs::path file_;
  std::unique_ptr<cv::VideoCapture> capture_;
  std::optional<FrameClock> clock_;
  VideoColor color_;
  double first_stamp_ = 0, last_ = 0;
  int frames_ = 0, read_ = 0;
};

class PictureFolder : public FrameSource {
 public:
  PictureFolder(const fs::path& folder, double fps, const std::vector<double>& instants)
      : files_(pictures_in_order(folder)) {
    if (files_.empty()) {
      throw input_error(folder.string(), "", "has no images",
                        "give a video file, or a folder of numbered PNG or JPEG frames");
    }
    if (!instants.empty()) {
      instants_ = instants;
      while (instants_.size() < files_.size()) instants_.push_back(instants_.back() + 1 / fps);
      return;
    }
    const FrameNumbers numbers = frame_numbers(files_);
    for (const long long frame : numbers.frame) instants_.push_back(static_cast<double>(frame) / fps);
    if (!numbers.doubt.empty()) doubt_ = folder.string() + " " + numbers.doubt;
  }
  std::optional<TimedFrame> next() override {
    if (read_ >= files_.size()) return std::nullopt;
    TimedFrame frame{instants_[read_], read_image(files_[read_])};
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
  double fps() override { return 0; }
  int frames() const override { return static_cast<int>(files_.size()); }
  std::string doubt() const override { return doubt_; }

 private:
  std::vector<fs::path> files_;
  std::vector<double> instants_;
  std::string doubt_;
  size_t read_ = 0;
  int width_ = 0, height_ = 0;
};

}  // namespace

std::vector<fs::path> pictures_in_order(const fs::path& folder) {
  std::vector<fs::path> files = images_in(folder);
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return number_order(a.filename().string(), b.filename().string());
  });
  return files;
}

std::unique_ptr<FrameSource> open_frames(const fs::path& file_or_folder, double folder_fps,
                                         const std::vector<double>& instants) {
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
  return std::make_unique<PictureFolder>(file_or_folder, folder_fps, instants);
}

}  // namespace pliant
