#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gaussians/base/image.h"

namespace pliant {

/// A frame as it is stored, with its instant in seconds from the first frame.
struct TimedFrame {
  double time = 0;
  ImageF picture;  ///< [H, W, 3]
};

/// The frames of a video one after the other.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual std::optional<TimedFrame> next() = 0;
  /// Rate of the file's frames where none is missing [1/s]; 0 when it tells none.
  virtual double fps() = 0;
  /// Frames that the file says it has; 0 = it does not say.
  virtual int frames() const = 0;
  /// A sentence on what the files leave open: frames that seem to be missing, the coding of colors, or HDR; empty =
  /// nothing.
  virtual std::string doubt() const { return ""; }
};

/// A video file, or a folder of pictures at `folder_fps`, whose numbers tell which frames they are (frame_numbers.h)
/// unless `instants` has those of its first pictures [s], as for masks of the frames of a video.  Throws Error{kInput}
/// naming what is not there or no video.
std::unique_ptr<FrameSource> open_frames(const std::filesystem::path& file_or_folder, double folder_fps,
                                         const std::vector<double>& instants = {});

/// Pictures in a folder (png, jpg, webp, bmp, tif), ordered so that numbers in their names count as numbers.
std::vector<std::filesystem::path> pictures_in_order(const std::filesystem::path& folder);

}  // namespace pliant
