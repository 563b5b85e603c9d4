#include "app/evaluate/clip.h"

#include "fitting/observe/frame_source.h"
#include "gaussians/base/error.h"

namespace pliant {

ReferenceVideo read_clip(const std::filesystem::path& path, const ClipPart& part, double fps, const Camera& like) {
  Camera camera = like;
  if (camera.width == 0) {
    const std::optional<TimedFrame> first = open_frames(path, part.fps > 0 ? part.fps : 0)->next();
    if (!first) throw input_error(path.string(), "", "has no frames", "give a video or a folder of frames");
    camera.name = "video";
    camera.width = first->picture.width;
    camera.height = first->picture.height;
  }
  VideoOptions options;
  options.declared_fps = part.fps;
  options.fps = fps;
  options.first = part.from;
  options.last = part.until;
  return load_reference_video(options, path, camera);
}

}  // namespace pliant
