#include "gaussians/io/video.h"

#include <unistd.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

#include "gaussians/base/error.h"

namespace pliant {
namespace fs = std::filesystem;

struct VideoWriter::State {
  fs::path file, temporary;
  int width, height;
  cv::VideoWriter writer;
  bool closed = false;
};

VideoWriter::VideoWriter(const fs::path& file, double fps, int width, int height) : state_(std::make_unique<State>()) {
  state_->file = file;
  state_->temporary = file.parent_path() / (file.stem().string() + ".tmp" + std::to_string(getpid()) + file.extension().string());
  state_->width = width & ~1, state_->height = height & ~1;
  const bool opened = state_->writer.open(state_->temporary.string(), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('a', 'v', 'c', '1'),
                                          fps, cv::Size(state_->width, state_->height));
  if (!opened)
    throw input_error(file.string(), "", "cannot be written as H.264 by this OpenCV",
                      "install an OpenCV with FFmpeg and x264 (Debian: libopencv-dev), and check that the folder can be written");
}

VideoWriter::~VideoWriter() {
  if (state_->closed) return;
  state_->writer.release();
  std::error_code ignored;
  fs::remove(state_->temporary, ignored);
}

void VideoWriter::write(const ImageF& rgb) {
  CHECK(rgb.channels == 3 && rgb.width >= state_->width && rgb.height >= state_->height);
  cv::Mat frame(state_->height, state_->width, CV_8UC3);
  for (int y = 0; y < state_->height; ++y) {
    uint8_t* bgr = frame.ptr<uint8_t>(y);
    for (int x = 0; x < state_->width; ++x)
      for (int c = 0; c < 3; ++c)
        bgr[3 * x + c] = static_cast<uint8_t>(std::clamp(rgb(x, y, 2 - c), 0.0f, 1.0f) * 255.0f + 0.5f);
  }
  state_->writer.write(frame);
}

void VideoWriter::close() {
  state_->writer.release();
  fs::rename(state_->temporary, state_->file);
  state_->closed = true;
}

}  // namespace pliant
