#pragma once

#include <span>

#include "app/evaluate/evaluate.h"
#include "fitting/observe/reference_video.h"

namespace pliant {

/// The size that clips are compared at, and a warning when it is not that of the reference.
struct ClipSize {
  Camera camera;
  int width = 0, height = 0;  ///< px of the reference's own frames
  std::vector<std::string> warnings;
};
/// That of the reference's frames, scaled down so that no side is longer than 1280 px.
ClipSize compared_size(const std::filesystem::path& reference, const ClipPart& part);

/// A warning where a clip's first frame has neither the size that clips are compared at nor the reference's own; else
/// empty.
std::string other_size(const std::filesystem::path& clip, const ClipPart& part, const ClipSize& compared);

/// The wanted part of a video, or of a folder of frames at part.fps, at `fps` (0 = its own) and of the size of `like`.
/// `start`: s of the file, where the frames begin exactly; else at the file's frame nearest to part.from.
ReferenceVideo read_clip(const std::filesystem::path& path, const ClipPart& part, double fps, const Camera& like,
                         std::optional<double> start = {});

/// Throws Error{kUsage} for part.fps where none of the clips is a folder of frames: videos have their own rate.
void check_fps(const ClipPart& part, std::span<const std::filesystem::path> clips);

}  // namespace pliant
