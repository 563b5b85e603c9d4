#pragma once

#include <filesystem>
#include <memory>

#include "gaussians/base/image.h"

namespace pliant {

enum class VideoCoding {
  kForBrowsers,  ///< yuv420p, which every browser plays
  kWithAlpha,    ///< VP9 with an alpha channel, for a .webm: frames are RGBA, not premultiplied
  kFaithful,  ///< yuv444p and finer steps, to measure on: halved chroma alone leaves 36 dB of a small saturated object
};

/// Writes a video through the `ffmpeg` program, H.264 in mp4 unless the coding says otherwise: constant quality, one
/// encoder thread, so that equal frames give equal files.  Odd sizes lose their last row or column.  The file says how
/// its colors are coded (sRGB, matrix of BT.601), so that players do not take HD for BT.709.  It appears under its name
/// when `close` returns; without `close` nothing is left behind.  Throws Error{kInput} when ffmpeg is missing or fails,
/// Error{kUsage} for frames of less than 2 x 2 pixels.
class VideoWriter {
 public:
  VideoWriter(const std::filesystem::path& file, double fps, int width, int height,
              VideoCoding coding = VideoCoding::kForBrowsers);
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  void write(const ImageF& picture);  ///< [height, width, 3 or 4] in [0, 1]; clamped and rounded to 8 bit
  void close();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Writes a video again as an animated GIF (its own palette, at most 50 frames per second) or WebP that repeats for
/// ever; the extension of `to` says which.  Atomic.  Throws Error{kInput} when ffmpeg is missing or fails.
void convert_video(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace pliant
