#include "fitting/observe/reference_video.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "fitting/observe/frame_source.h"
#include "gaussians/base/error.h"
#include "gaussians/reconstruct/undistort.h"
#include "gaussians/vision/resize.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr double kLowestRate = 1, kHighestRate = 1000;
constexpr double kAspectTolerance = 0.02, kDeclaredTolerance = 0.01, kSameRate = 1e-6;
constexpr double kSameInstant = 0.02;  // of the distance between two frames
constexpr double kUnevenStep = 0.5;    // of the mean distance between two frames

void check_options(const VideoOptions& o) {
  const auto refuse = [](const char* key, double value, const char* remedy) {
    throw usage_error("reference video", key, fmt::format("is {}", value), remedy);
  };
  if (!(o.first >= 0) || !std::isfinite(o.first)) refuse("first", o.first, "give seconds from the start of the file");
  if (o.last != 0 && !(o.last > o.first))
    refuse("last", o.last, "give seconds from the start of the file, after `first`, or 0 for the end");
  for (const auto& [key, rate] : {std::pair{"fps", o.fps}, std::pair{"declared fps", o.declared_fps}})
    if (rate != 0 && !(rate >= kLowestRate && rate <= kHighestRate))
      refuse(key, rate, "give 1 to 1000 frames per second");
}

ImageF brightest(const ImageF& picture) {
  ImageF out(picture.width, picture.height, 1);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const float* channels = picture.at(x, y);
      out(x, y) = *std::max_element(channels, channels + std::min(picture.channels, 3));
    }
  return out;
}

ImageF blend(const ImageF& a, const ImageF& b, float share_of_b) {
  ImageF out = a;
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] += share_of_b * (b.data[i] - a.data[i]);
  return out;
}

/// Frames at start + k / fps from those that come in.
class Resampler {
 public:
  Resampler(const VideoOptions& options, ReferenceVideo& out) : options_(options), out_(out) {}

  void add(TimedFrame frame) {
    if (!started_ && frame.time >= options_.first) {
      const bool earlier = before_ && options_.first - before_->time < frame.time - options_.first;
      out_.start = options_.exact_start ? options_.first : earlier ? before_->time : frame.time;
      started_ = true;
    }
    while (started_ && due() <= frame.time + slack(frame.time) &&
           (options_.last == 0 || due() <= options_.last + slack(frame.time)))
      emit(frame);
    before_ = std::move(frame);
  }
  bool complete() const { return options_.last != 0 && before_ && before_->time >= options_.last; }

 private:
  double due() const { return out_.start + static_cast<double>(out_.frames.size()) / out_.fps; }
  double slack(double time) const { return before_ ? kSameInstant * (time - before_->time) : 1e-9; }

  void emit(const TimedFrame& now) {
    const double bytes =
        static_cast<double>(now.picture.data.size()) * sizeof(float) * static_cast<double>(out_.frames.size() + 1);
    if (bytes > options_.most_bytes) {
      throw input_error(
          "reference video", "",
          fmt::format("needs more than {:.1f} GB of memory at {} frames of {} x {}", options_.most_bytes / 1e9,
                      out_.frames.size() + 1, now.picture.width, now.picture.height),
          fmt::format("use a part of it ({}), {}", options_.part_options, options_.other_savings));
    }
    const double share = before_ ? (due() - before_->time) / (now.time - before_->time) : 1;
    if (share > 1 - kSameInstant || (options_.resampling == Resampling::kNearest && share >= 0.5)) {
      out_.frames.push_back(now.picture);
    } else if (share < kSameInstant || options_.resampling == Resampling::kNearest) {
      out_.frames.push_back(before_->picture);
    } else {
      out_.frames.push_back(blend(before_->picture, now.picture, static_cast<float>(share)));
      ++out_.blended;
    }
  }

  const VideoOptions& options_;
  ReferenceVideo& out_;
  std::optional<TimedFrame> before_;
  bool started_ = false;
};

/// The rate that instants are computed with, and a warning when the file and the scene file disagree.
double agreed_rate(const VideoOptions& options, const std::string& name, ReferenceVideo& video) {
  if (video.file_fps == 0) return video.declared_fps;
  if (!(video.file_fps >= kLowestRate && video.file_fps <= kHighestRate)) {
    throw input_error(name, "fps", fmt::format("is {}, which no camera has", video.file_fps),
                      "re-encode the file with its true rate: `ffmpeg -r RATE -i F out.mp4`");
  }
  if (video.declared_fps == 0 || std::abs(video.declared_fps / video.file_fps - 1) <= kDeclaredTolerance)
    return video.file_fps;
  video.warnings.push_back(
      fmt::format("{} runs at {:.4g} frames per second, the scene file states {:.4g}: times follow the {}, and with "
                  "the other rate E would be {:.2g} times as large",
                  name, video.file_fps, video.declared_fps, options.trust_declared ? "scene file" : "video",
                  options.trust_declared ? std::pow(video.file_fps / video.declared_fps, 2)
                                         : std::pow(video.declared_fps / video.file_fps, 2)));
  video.declared_rate_holds = options.trust_declared;
  return options.trust_declared ? video.declared_fps : video.file_fps;
}

void check_shape(const std::string& name, const ImageF& picture, const Camera& camera) {
  const double of_video = static_cast<double>(picture.width) / picture.height,
               of_camera = static_cast<double>(camera.width) / camera.height;
  if (std::abs(of_video / of_camera - 1) <= kAspectTolerance) return;
  throw input_error(
      name, "",
      fmt::format("has frames of {} x {} (width / height {:.3f}), but camera '{}' takes {} x {} ({:.3f})",
                  picture.width, picture.height, of_video, camera.name, camera.width, camera.height, of_camera),
      "crop the video to the camera's field of view, or give the camera that took it");
}

/// Whether a picture was taken through the lens, and not by the pinhole that the training made of it.
bool takes(const Camera& lens, const Camera& pinhole, const ImageF& picture) {
  const auto has_size = [&](const Camera& camera) {
    return picture.width == camera.width && picture.height == camera.height;
  };
  return has_size(lens) || !has_size(pinhole);
}

}  // namespace

ReferenceVideo load_reference_video(const VideoOptions& options, const fs::path& file_or_folder, const Camera& camera) {
  check_options(options);
  CHECK(camera.width > 0 && camera.height > 0);
  const std::string name = file_or_folder.string();
  const auto source = open_frames(file_or_folder, options.declared_fps, options.instants);
  ReferenceVideo video;
  video.camera = camera;
  std::optional<Undistortion> lens;
  video.file_fps = source->fps();
  if (video.file_fps == 0) video.pictures = source->frames();
  video.declared_fps = options.declared_fps;
  const double rate = video.source_fps = agreed_rate(options, name, video);
  const double stretch = video.file_fps > 0 ? video.file_fps / rate : 1;
  video.fps = options.fps > 0 ? options.fps : rate;
  if (!source->doubt().empty()) video.warnings.push_back(source->doubt());

  Resampler resampler(options, video);
  double end = 0, longest_step = 0;
  while (!resampler.complete()) {
    std::optional<TimedFrame> frame = source->next();
    if (!frame) break;
    if (video.frames_in_file++ == 0) {
      if (options.lens && takes(*options.lens, camera, frame->picture)) {
        video.lens = options.lens;
        lens = undistortion_onto(camera, *options.lens);
      }
      check_shape(name, frame->picture, video.lens.value_or(camera));
    }
    frame->time *= stretch;
    longest_step = std::max(longest_step, frame->time - end);
    end = frame->time;
    video.instants.push_back(end);
    if (lens)
      frame->picture = undistorted(*lens, resized(frame->picture, video.lens->width, video.lens->height));
    else
      frame->picture = resized(frame->picture, camera.width, camera.height);
    if (options.brightest) frame->picture = brightest(frame->picture);
    resampler.add(std::move(*frame));
  }

  if (video.frames_in_file < 2) {
    throw input_error(
        name, "",
        video.frames_in_file == 0 ? "has no frames that can be decoded" : "has a single frame: nothing moves in it",
        "give a video of at least a few frames; the file may be cut short");
  }
  if (video.frames.size() < 2) {
    throw input_error(
        name, "",
        fmt::format("has {} frames from {} s to {}, and lasts {:.3f} s", video.frames.size(), options.first,
                    options.last == 0 ? "its end" : fmt::format("{} s", options.last), end),
        fmt::format("choose a longer part of it ({})", options.part_options));
  }
  if (!resampler.complete() && source->frames() > video.frames_in_file + 1) {
    video.warnings.push_back(fmt::format("{} declares {} frames but only {} can be decoded: it may be damaged", name,
                                         source->frames(), video.frames_in_file));
  }
  if (options.last != 0 && options.last > end + 1.5 / rate)
    video.warnings.push_back(fmt::format("{} ends at {:.3f} s, before {} s", name, end, options.last));
  const double mean_step = end / (video.frames_in_file - 1);
  if (video.file_fps > 0 && longest_step > (1 + kUnevenStep) * mean_step) {
    video.warnings.push_back(fmt::format(
        "{} has an uneven rate: up to {:.1f} ms between frames, {:.1f} ms on average; frames follow its time stamps",
        name, 1e3 * longest_step, 1e3 * mean_step));
  }
  if (video.blended > 0) {
    const std::string reason =
        std::abs(video.fps / rate - 1) < kSameRate
            ? "the video has no frame at their instants"
            : fmt::format("the video runs at {:.4g} frames per second and {:.4g} are requested", rate, video.fps);
    video.warnings.push_back(fmt::format("{} of {} frames are blends of two, since {}: moving edges are doubled there",
                                         video.blended, video.frames.size(), reason));
  }
  return video;
}

}  // namespace pliant
