#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/fit/fit_video.h"
#include "fitting/observe/frame_numbers.h"
#include "fitting/observe/frame_source.h"
#include "gaussians/base/error.h"
#include "gaussians/io/images/image_files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/reconstruct/undistort.h"
#include "gaussians/render/render.h"
#include "gaussians/vision/resize.h"

namespace pliant {
namespace fs = std::filesystem;

namespace {

constexpr double kSameAspect = 0.02, kEqualRates = 1e-6;
constexpr double kLeastUsable = 0.005;  // of the object's pixels

struct Masks {
  std::vector<ImageF> frames;
  std::vector<std::string> warnings;
};

/// A mask of all frames, drawn over one of the video's file.
ImageF single_mask(const fs::path& file, const ReferenceVideo& video) {
  const Camera& camera = video.lens ? *video.lens : video.camera;
  const ImageF mask = read_image(file);
  const double of_mask = static_cast<double>(mask.width) / mask.height,
               of_video = static_cast<double>(camera.width) / camera.height;
  if (std::abs(of_mask / of_video - 1) > kSameAspect)
    throw input_error(
        file.string(), "size",
        fmt::format("is {} x {}, but the video is {} x {}", mask.width, mask.height, camera.width, camera.height),
        "give a mask with the video's aspect ratio");
  const ImageF scaled = resized(mask, camera.width, camera.height);
  return video.lens ? undistorted(undistortion_onto(video.camera, camera), scaled) : scaled;
}

Error other_number(const fs::path& file, size_t masks, size_t frames) {
  return input_error(file.string(), "frames", fmt::format("are {}, but the video has {}", masks, frames),
                     "give one mask for every frame, or one image for all");
}

/// Masks in their order are those of the video's frames in theirs: where one is missing, its frame must be too.
void check_numbers(const fs::path& folder, const ReferenceVideo& video, bool whole) {
  const FrameNumbers masks = frame_numbers(pictures_in_order(folder));
  const auto frame = [&](size_t k) { return std::llround(video.instants[k] * video.source_fps); };
  const size_t seen = video.instants.size(), pictures = video.pictures;
  if (masks.missing.empty()) {
    const bool gaps = pictures > 0 && frame(seen - 1) + 1 > static_cast<long long>(seen);
    if (gaps && masks.frame.size() != pictures) throw other_number(folder, masks.frame.size(), pictures);
    return;
  }
  if (whole && pictures == 0) return;  // they are as many as the frames of the file
  for (size_t k = 0; k < std::min(seen, masks.frame.size()); ++k)
    if (masks.frame[k] != frame(k))
      throw input_error(folder.string(), "frames", fmt::format("have no mask numbered {}", masks.missing),
                        "give one mask for every frame");
}

/// One picture for every frame of the video's file.
Masks masks_of_folder(const FitStage& stage, const ReferenceVideo& video, VideoOptions options) {
  const fs::path folder = stage.video_mask();
  options.declared_fps = video.source_fps;
  options.instants = video.instants;
  const ReferenceVideo read = load_reference_video(options, folder, video.camera);
  const bool whole = stage.last == 0 && !video.instants.empty();
  if (whole && read.instants.size() != video.instants.size())
    throw other_number(folder, read.instants.size(), video.instants.size());
  check_numbers(folder, video, whole);
  if (read.frames.size() != video.frames.size()) throw other_number(folder, read.frames.size(), video.frames.size());
  return {read.frames, read.warnings};
}

Masks masks_of_video(const FitStage& stage, const ReferenceVideo& video, VideoOptions options) {
  const fs::path file = stage.video_mask();
  // A rate that was given for the video, as for slow motion, is that of its masks too.
  if (stage.fps > 0 || video.declared_rate_holds) {
    options.declared_fps = video.source_fps;
    options.trust_declared = true;
  }
  ReferenceVideo read = load_reference_video(options, file, video.camera);
  if (read.declared_rate_holds)  // the first warning is about E, which masks do not change
    read.warnings.front() = fmt::format("{} runs at {:.4g} frames per second and is read at {:.4g}, as the video",
                                        file.string(), read.file_fps, read.source_fps);
  const size_t masks = read.frames.size(), frames = video.frames.size();
  // The last frame of the slower one lasts until its next one would come.
  const double slowest = std::min(read.source_fps, video.source_fps);
  const bool same_rate = std::abs(read.source_fps / video.source_fps - 1) < kEqualRates;
  const double spare = same_rate ? 0 : std::ceil(video.fps / slowest - kEqualRates) - 1;
  if (std::abs(static_cast<double>(masks) - static_cast<double>(frames)) > spare)
    throw input_error(
        file.string(), "frames",
        fmt::format("last {:.3f} s ({} at {:.4g} per second), but those of the video last {:.3f} s ({} at {:.4g})",
                    static_cast<double>(masks) / video.fps, read.frames_in_file, read.source_fps,
                    static_cast<double>(frames) / video.fps, video.frames_in_file, video.source_fps),
        "give masks that last as long as the video, or a folder with one mask for every frame");
  read.frames.resize(frames, read.frames.back());
  return {std::move(read.frames), std::move(read.warnings)};
}

Masks load_masks(const FitStage& stage, const ReferenceVideo& video) {
  const fs::path file = stage.video_mask();
  if (is_image_file(file)) return {{single_mask(file, video)}, {}};
  VideoOptions options;
  options.first = video.start;
  options.exact_start = true;
  options.last = stage.last;
  options.fps = video.fps;
  options.lens = video.lens;
  options.resampling = Resampling::kNearest;
  options.brightest = true;
  std::error_code ignored;
  return fs::is_directory(file, ignored) ? masks_of_folder(stage, video, options)
                                         : masks_of_video(stage, video, options);
}

/// 255 where some channel is bright.
ImageU8 bright(const ImageF& mask) {
  ImageU8 out(mask.width, mask.height, 1);
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      const float* channels = mask.at(x, y);
      out(x, y) = *std::max_element(channels, channels + std::min(mask.channels, 3)) > 0.5f ? 255 : 0;
    }
  return out;
}

/// Where the object covers most of a pixel.
ImageU8 silhouette_of(const FitInputs& in, const Camera& camera) {
  const GaussianCloud object = read_ply(in.files.at("object"));
  RenderOptions rendering;
  rendering.antialiased = in.scene.report.antialiased;
  const ImageF share = render(object, camera, rendering).alpha;
  ImageU8 out(share.width, share.height, 1);
  for (size_t i = 0; i < share.data.size(); ++i) out.data[i] = share.data[i] > 0.5f;
  return out;
}

}  // namespace

bool has_mask(const FitStage& stage) { return !stage.video_mask().empty() && stage.video_mask() != "none"; }

std::vector<ImageU8> load_compared(const FitStage& stage, const ReferenceVideo& video) {
  std::vector<ImageU8> compared;
  if (!has_mask(stage)) return compared;
  for (const ImageF& mask : load_masks(stage, video).frames) compared.push_back(bright(mask));
  return compared;
}

void check_mask(const Context& context, const FitInputs& in, const FitStage& stage, const ReferenceVideo& video) {
  const Masks masks = load_masks(stage, video);
  for (const std::string& warning : masks.warnings) context.progress.warn(warning);
  const ImageU8 object = silhouette_of(in, video.camera);
  const auto pixels = static_cast<double>(std::count(object.data.begin(), object.data.end(), 1));
  if (pixels == 0) return;
  size_t dark = 0;
  bool first = false;
  for (size_t f = 0; f < masks.frames.size(); ++f) {
    const ImageU8 usable = bright(masks.frames[f]);
    double seen = 0;
    for (size_t i = 0; i < object.data.size(); ++i) seen += object.data[i] && usable.data[i];
    if (seen >= kLeastUsable * pixels) continue;
    ++dark;
    first = first || f == 0;
  }
  if (dark == 0) return;
  const std::string where = masks.frames.size() == 1 ? "is dark over the whole object"
                                                     : fmt::format("is dark over the whole object in {} of {} frames",
                                                                   dark, masks.frames.size());
  if (first)
    throw input_error(stage.video_mask(), "mask", where + (dark < masks.frames.size() ? ", the first among them" : ""),
                      "dark pixels are ignored and bright ones are used: invert it if the object is its dark part");
  context.progress.warn(stage.video_mask() + " " + where + ": nothing is compared there");
}

}  // namespace pliant
