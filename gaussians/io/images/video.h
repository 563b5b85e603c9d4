#pragma once

#include <filesystem>
#include <memory>

#include "gaussians/base/image.h"

namespace pliant {

enum class VideoCoding {
  kForBrowsers,  ///< yuv420p, which every browser plays
  kFaithful,  ///< yuv444p and finer steps, to measure on: halved chroma alone leaves 36 dB of a small saturated object
};

/// Writes an H.264 mp4 through the `ffmpeg` program: constant quality, one encoder thread,
/// so that equal frames give equal files.  Odd sizes lose their last row or column.  The file appears under its name
/// when `close` returns; without `close` nothing is left behind.  Throws Error{kInput} when ffmpeg is missing or fails.
class VideoWriter {
 public:
  VideoWriter(const std::filesystem::path& file, double fps, int width, int height,
              VideoCoding coding = VideoCoding::kForBrowsers);
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  void write(const ImageF& rgb);  ///< [height, width, 3] in [0, 1]; clamped and rounded to 8 bit
  void close();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace pliant
