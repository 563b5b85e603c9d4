#include "fitting/observe/check_video.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fitting/observe/frame_changes.h"
#include "fitting/observe/hidden_pixels.h"
#include "gaussians/base/error.h"
#include "gaussians/base/quantile.h"
#include "gaussians/vision/optical_flow.h"

namespace pliant {
namespace {

constexpr double kMargin = 0.06;  // of the width, around the object at rest: what it may move over
constexpr double kRateTolerance = 0.01;
constexpr double kMoving = 0.2;  // of the usual change from frame to frame: below it the object rests
constexpr double kSame = 0.1;    // of the change before and after: a frame shown again
constexpr double kLeap = 1.7;    // of the change before and after: frames are missing
constexpr int kLongestJump = 2;  // frames: a longer series of jumps is a camera in motion
constexpr double kNoiseFactor = 3;

class Checker {
 public:
  Checker(const VideoCheckOptions& options, const ReferenceVideo& video, const ImageF& picture, const ImageU8& object,
          std::span<const ImageU8> compared)
      : options_(options),
        video_(video),
        picture_(picture),
        object_(object),
        surroundings_(dilated(object, std::max(2, static_cast<int>(kMargin * picture.width)))),
        hidden_(compared, surroundings_) {}

  VideoChecks run() {
    check_view();
    check_rate();
    const FrameChanges changes = frame_changes(video_.frames, surroundings_, hidden_);
    check_jumps(changes);
    check_light(changes.light);
    check_rhythm(changes.moved);
    check_motion();
    check_rest();
    std::stable_sort(checks_.findings.begin(), checks_.findings.end(),
                     [](const auto& a, const auto& b) { return a.refuse > b.refuse; });
    return std::move(checks_);
  }

 private:
  void found(VideoProblem problem, bool refuse, double value, double limit, int frame, std::string sentence) {
    checks_.findings.push_back({problem, refuse, value, limit, frame, std::move(sentence)});
  }
  double seconds(int frame) const { return video_.start + frame / video_.fps; }

  void check_view() {
    const double width = picture_.width;
    const ImageU8 none(picture_.width, picture_.height, 1);
    checks_.match = match_pictures(picture_, hidden_.filled(video_.frames[0], 0, picture_), hidden_.beside(none, 0, 0));
    const auto& [score, shift] = checks_.match;
    const std::string& camera = video_.camera.name;
    if (score < options_.least_score) {
      found(VideoProblem::kOtherView, true, score, options_.least_score, 0,
            fmt::format("The first frame does not show the scene from camera '{}': its match score with the rendered "
                        "scene is {:.2f} ({:.2f} is needed).  Give the camera that took the video, or use "
                        "--video-camera find; check that the video shows this scene.",
                        camera, score, options_.least_score));
    } else if (shift > options_.most_shift * width) {
      found(VideoProblem::kOtherView, true, shift, options_.most_shift * width, 0,
            fmt::format("The first frame is shifted relative to the scene seen from camera '{}' by {:.1f} px (at most "
                        "{:.1f}).  Use --refine-camera, or give the right camera.",
                        camera, shift, options_.most_shift * width));
    } else if (shift > options_.noted_shift * width) {
      found(VideoProblem::kViewOff, false, shift, options_.noted_shift * width, 0,
            fmt::format("The first frame is {:.1f} px off the scene seen from camera '{}'.  --refine-camera makes the "
                        "fit more accurate.",
                        shift, camera));
    }
    const auto pixels = std::count_if(object_.data.begin(), object_.data.end(), [](uint8_t m) { return m != 0; });
    if (pixels < options_.least_pixels) {
      found(VideoProblem::kHidden, true, static_cast<double>(pixels), options_.least_pixels, 0,
            fmt::format(
                "The object covers {} pixels of camera '{}', too few to see it move.  Give a camera that sees it.",
                pixels, camera));
    }
  }

  void check_rate() {
    if (video_.file_fps == 0 || video_.declared_fps == 0 || video_.declared_rate_holds) return;
    if (std::abs(video_.declared_fps / video_.file_fps - 1) <= kRateTolerance) return;
    found(
        VideoProblem::kRate, true, video_.declared_fps, video_.file_fps, -1,
        fmt::format(
            "The scene file states {:.4g} frames per second, the video file {:.4g}; E scales with the square of the "
            "rate, here by {:.2g}.  Correct video.fps in the scene file, or confirm it with --video-fps (slow motion).",
            video_.declared_fps, video_.file_fps, std::pow(video_.declared_fps / video_.file_fps, 2)));
  }

  /// Cuts and fast turns of the camera.
  void check_jumps(const FrameChanges& changes) {
    const std::vector<double>&score = changes.score, &change = changes.difference;
    const int frames = static_cast<int>(score.size());
    const auto jump = [&](int t) {
      return t < frames && score[t] < options_.least_continuity && change[t] > options_.least_change;
    };
    for (int t = 1; t < frames; ++t) {
      if (change[t] > options_.least_change) checks_.continuity = std::min(checks_.continuity, score[t]);
      if (!jump(t)) continue;
      int end = t;
      while (jump(end + 1)) ++end;
      if (end - t < kLongestJump) {
        jumped_ = true;
        found(VideoProblem::kCut, true, score[t], options_.least_continuity, t,
              fmt::format("The video jumps at frame {} ({:.2f} s): the match score of the background with the previous "
                          "frame is {:.2f} ({:.2f} is needed).  Use the part before or after it "
                          "(--video-first, --video-last).",
                          t, seconds(t), score[t], options_.least_continuity));
      } else {
        turned_ = t;
      }
      t = end;
    }
  }

  void check_light(const std::vector<double>& light) {
    const int worst = static_cast<int>(std::ranges::max_element(light) - light.begin());
    checks_.light = light[worst];
    if (checks_.light > options_.noted_light && !jumped_ && turned_ < 0) {
      found(VideoProblem::kLight, false, checks_.light, options_.noted_light, worst,
            fmt::format("The background's brightness changes by {:.0f} % (frame {}, {:.2f} s).  Film with fixed "
                        "exposure; colors are compared without correction.",
                        100 * checks_.light, worst, seconds(worst)));
    }
  }

  /// Frames that are missing, and repeated ones, which stand still between others that do not.
  void check_rhythm(const std::vector<float>& moved) {
    const int frames = static_cast<int>(moved.size());
    const double usual = quantile(std::vector(moved.begin() + 1, moved.end()), 0.9);
    int repeated = 0, leap = 0;
    for (int t = 2; t + 1 < frames; ++t) {
      const auto [less, more] = std::minmax(moved[t - 1], moved[t + 1]);
      if (!(less > kMoving * usual)) continue;
      repeated += moved[t] < kSame * less;
      if (moved[t] > kLeap * more && (leap == 0 || moved[t] > moved[leap])) leap = t;
    }
    checks_.rhythm = find_rhythm(moved);
    const double filmed = checks_.rhythm.share() * video_.fps;
    if (checks_.rhythm.missing > 0 && !jumped_ && turned_ < 0) {
      const int every = checks_.rhythm.period + 1;
      found(VideoProblem::kDropped, false, filmed, video_.fps, -1,
            fmt::format(
                "One in {} steps of the object is twice as long as the others: one of every {} filmed frames is "
                "missing.  If the true rate is {:.4g} frames per second, times are right; if it is {:.4g}, they run "
                "too fast and E is overestimated by a factor of {:.3g}.  Re-encode the video with all frames.",
                checks_.rhythm.period, every, filmed, video_.fps, std::pow(filmed / video_.fps, 2)));
    } else if (leap > 0 && !jumped_ && turned_ < 0) {
      const double ratio = moved[leap] / std::max(moved[leap - 1], moved[leap + 1]);
      found(VideoProblem::kLeap, false, ratio, kLeap, leap,
            fmt::format("The object jumps at frame {} ({:.2f} s): the image changes {:.1f} times as much as before and "
                        "after.  If frames are missing there, use the part before it (--video-last), or the part after "
                        "it (--video-first) if that begins with the object at rest.",
                        leap, seconds(leap), ratio));
    }
    const int period = checks_.rhythm.period, twice = checks_.rhythm.repeated;
    checks_.repeated = twice > 0 ? static_cast<double>(twice) / period : static_cast<double>(repeated) / frames;
    if (twice > 0) {
      found(
          VideoProblem::kRepeated, false, checks_.repeated, options_.noted_repeats, -1,
          fmt::format(
              "{} of every {} frames repeat{} the previous one: the video was filmed at a lower rate than {:.4g}, the "
              "true rate is probably {:.4g} frames per second.  Compare it at that rate (--compare-fps).  If this "
              "slowed the motion down, E is underestimated by a factor of {:.3g}: set the rate to {:.4g} "
              "(--video-fps).",
              twice, period, twice == 1 ? "s" : "", video_.fps, filmed, std::pow(video_.fps / filmed, 2),
              video_.fps * video_.fps / filmed));
    } else if (checks_.repeated > options_.noted_repeats) {
      found(VideoProblem::kRepeated, false, checks_.repeated, options_.noted_repeats, -1,
            fmt::format("{} of {} frames repeat the previous one: the video was filmed at a lower rate than {:.4g} "
                        "frames per second.  Re-encode it at its own rate: `ffmpeg -i F -vf mpdecimate out.mp4`.",
                        repeated, frames, video_.fps));
    }
  }

  std::vector<ImageF> flows_of(const std::vector<std::pair<int, int>>& pairs) const {
    if (!hidden_.any()) return dense_flows(video_.frames, pairs);
    std::vector<ImageF> flows;
    for (const auto& [from, to] : pairs) {
      const ImageF &a = video_.frames[from], &b = video_.frames[to];
      std::vector<ImageF> both = {hidden_.filled(a, from, b)};
      both.push_back(hidden_.filled(b, to, both[0]));
      flows.push_back(dense_flows(both, std::vector<std::pair<int, int>>{{0, 1}})[0]);
    }
    return flows;
  }

  /// Drift of the background and motion of the object, from the flow between the first frame and others.
  void check_motion() {
    const int frames = static_cast<int>(video_.frames.size()), compared = std::min(frames - 1, options_.flow_frames);
    std::vector<std::pair<int, int>> pairs;
    for (int k = 1; k <= compared; ++k)
      pairs.push_back({0, static_cast<int>(std::lround(static_cast<double>(k) * (frames - 1) / compared))});
    const std::vector<ImageF> flows = flows_of(pairs);
    const ImageF contrast = local_contrast(video_.frames[0]);
    int drift_frame = 0, motion_frame = 0;
    size_t background = 0;
    bool always_seen = true;
    for (size_t k = 0; k < flows.size(); ++k) {
      const ObjectFlow flow = hidden_.seen_flow(flows[k], contrast, object_, surroundings_, 0, pairs[k].second);
      background = std::max(background, flow.pixels);
      always_seen = always_seen && (!hidden_.any() || hidden_.seen(pairs[k].second, surroundings_) > 0);
      checks_.noise = std::max(checks_.noise, flow.noise);
      if (flow.background > checks_.drift) {
        checks_.drift = flow.background;
        drift_frame = pairs[k].second;
      }
      if (flow.object > checks_.motion) {
        checks_.motion = flow.object;
        motion_frame = pairs[k].second;
      }
    }
    const double width = picture_.width, limit = options_.most_drift * width;
    if (turned_ >= 0 || (checks_.drift > options_.noted_drift * width && background > 100 && !jumped_)) {
      const bool refuse = turned_ >= 0 || checks_.drift > limit;
      found(VideoProblem::kCameraMoves, refuse, checks_.drift, refuse ? limit : options_.noted_drift * width,
            drift_frame,
            fmt::format("The camera moves: the background drifts by {:.1f} px until frame {} ({:.2f} s).  Use a "
                        "tripod, or stabilize the video on its background first.",
                        checks_.drift, drift_frame, seconds(drift_frame)));
    }
    const double least = std::max(options_.least_motion, kNoiseFactor * checks_.noise);
    if (checks_.motion < least && always_seen && !jumped_ && turned_ < 0) {
      found(VideoProblem::kStatic, true, checks_.motion, least, motion_frame,
            fmt::format(
                "The object does not move: {:.2f} px at most, where {:.2f} px are above the noise.  A static object "
                "reveals nothing about its material: film it swinging, or use a part of the video that begins with the "
                "object at rest and shows it swing.",
                checks_.motion, least));
    }
  }

  /// Where the object is in the first frame, against where it is at rest.
  void check_rest() {
    const std::vector<ImageF> both = {picture_, hidden_.filled(video_.frames[0], 0, picture_)};
    const std::vector<std::pair<int, int>> pair = {{0, 1}};
    const ObjectFlow flow =
        hidden_.seen_flow(dense_flows(both, pair)[0], local_contrast(picture_), object_, surroundings_, 0, 0);
    checks_.displaced = flow.object;
    const double limit = std::max(
        {options_.noted_shift * picture_.width, kNoiseFactor * flow.noise, options_.most_displaced * checks_.motion});
    if (!(checks_.displaced > limit)) return;
    found(VideoProblem::kNotAtRest, false, checks_.displaced, limit, 0,
          fmt::format("The object is not at rest in the first frame: parts of it are {:.1f} px from where the scene at "
                      "rest shows them from camera '{}', and its motion in the video is {:.1f} px.  Motion is measured "
                      "from the rendered scene instead, which is less exact.  Start with a frame that shows the object "
                      "at rest (--video-first), and give the time of its release with --start; if it is at rest, check "
                      "the camera and that the video shows this scene.",
                      checks_.displaced, video_.camera.name, checks_.motion));
  }

  const VideoCheckOptions& options_;
  const ReferenceVideo& video_;
  const ImageF& picture_;
  const ImageU8& object_;
  const ImageU8 surroundings_;
  const HiddenPixels hidden_;
  bool jumped_ = false;
  int turned_ = -1;
  VideoChecks checks_;
};

}  // namespace

const VideoFinding* VideoChecks::find(VideoProblem problem) const {
  for (const VideoFinding& finding : findings)
    if (finding.problem == problem) return &finding;
  return nullptr;
}

VideoChecks check_video(const VideoCheckOptions& options, const ReferenceVideo& video, const ImageF& picture,
                        const ImageU8& object, std::span<const ImageU8> compared) {
  CHECK(video.frames.size() >= 2 && video.fps > 0);
  const ImageF& first = video.frames[0];
  CHECK(picture.width == first.width && picture.height == first.height && picture.channels == 3);
  CHECK(object.width == first.width && object.height == first.height && object.channels == 1);
  CHECK(compared.size() <= 1 || compared.size() == video.frames.size());
  return Checker(options, video, picture, object, compared).run();
}

void require_usable(const VideoChecks& checks, const std::string& file) {
  std::string sentences;
  for (const VideoFinding& finding : checks.findings)
    if (finding.refuse) sentences += (sentences.empty() ? "" : "  ") + finding.sentence;
  if (!sentences.empty()) throw input_error(file, "", "cannot be fitted.  " + sentences, "");
}

}  // namespace pliant
