#pragma once

#include "app/evaluate/evaluate.h"
#include "fitting/observe/reference_video.h"

namespace pliant {

/// The wanted part of a video, or of a folder of frames at part.fps, at `fps` (0 = its own) and of the size of `like`
/// (empty = its own).
ReferenceVideo read_clip(const std::filesystem::path& path, const ClipPart& part, double fps, const Camera& like);

}  // namespace pliant
