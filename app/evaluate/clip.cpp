#include "app/evaluate/clip.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fitting/observe/frame_source.h"
#include "gaussians/base/error.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr double kLongestSide = 1280;  // px; 270 frames of 16 : 9 fit into memory

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

ImageF first_frame(const fs::path& clip, const ClipPart& part) {
  std::optional<TimedFrame> first = open_frames(clip, part.fps)->next();
  if (!first) throw input_error(clip.string(), "", "has no frames", "give a video or a folder of frames");
  return std::move(first->picture);
}

}  // namespace

ClipSize compared_size(const fs::path& reference, const ClipPart& part) {
  const ImageF first = first_frame(reference, part);
  const int width = first.width, height = first.height;
  const double scale = std::min(1.0, kLongestSide / std::max(width, height));
  ClipSize size;
  size.width = width;
  size.height = height;
  size.camera.name = "video";
  size.camera.width = std::max(1, static_cast<int>(std::lround(scale * width)));
  size.camera.height = std::max(1, static_cast<int>(std::lround(scale * height)));
  if (scale < 1)
    size.warnings.push_back(fmt::format("{} has frames of {} x {} and is compared at {} x {}: pixels are of that size",
                                        reference.string(), width, height, size.camera.width, size.camera.height));
  return size;
}

std::string other_size(const fs::path& clip, const ClipPart& part, const ClipSize& compared) {
  const ImageF first = first_frame(clip, part);
  const auto is = [&](int width, int height) { return first.width == width && first.height == height; };
  if (is(compared.width, compared.height) || is(compared.camera.width, compared.camera.height)) return "";
  return fmt::format("{} is {} x {} and is compared at {} x {}", clip.string(), first.width, first.height,
                     compared.camera.width, compared.camera.height);
}

ReferenceVideo read_clip(const fs::path& path, const ClipPart& part, double fps, const Camera& like,
                         std::optional<double> start) {
  VideoOptions options;
  if (is_folder(path)) options.declared_fps = part.fps;
  options.fps = fps;
  options.first = start.value_or(part.from);
  options.exact_start = start.has_value();
  options.last = part.until;
  options.part_options = "--from, --until";
  options.other_savings = "or scale it down: `ffmpeg -i F -vf scale=640:-2 small.mp4`";
  return load_reference_video(options, path, like);
}

void check_fps(const ClipPart& part, std::span<const fs::path> clips) {
  if (part.fps > 0 && std::none_of(clips.begin(), clips.end(), is_folder))
    throw usage_error("evaluate", "--fps", "does nothing for videos, which have their own rate", "leave it out");
}

}  // namespace pliant
