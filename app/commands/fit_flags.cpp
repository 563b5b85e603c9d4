#include "app/commands/stage_options.h"
#include "app/fit/fit_stage.h"

namespace pliant {
namespace {

void add_marker_options(CLI::App& command, MarkerStage& stage) {
  const auto option = [&](const char* name, auto& value, const char* description) {
    return command.add_option(name, value, description)->group("Markers instead of a video");
  };
  option("--markers", stage.file,
         "Table of marker positions after the object was let go from rest (CSV: time, NAME_x, NAME_y, NAME_z, ...)");
  option("--marker-axes", stage.axes, "Columns along the scene's x, y, z, with signs, such as y,-x,z")
      ->capture_default_str();
  option("--marker-units", stage.units, "Of columns that name no unit")
      ->check(CLI::IsMember({"metres", "scene"}))
      ->capture_default_str();
  option("--marker-offset", stage.offset, "Added to the markers, along the scene's axes, in those units")
      ->expected(3)
      ->delimiter(',');
  option("--marker-reach", stage.reach,
         "Markers farther from the object's material are left out [m] (default: two cells)")
      ->check(CLI::PositiveNumber);
  option("--marker-rest", stage.rest, "Time in the table from which on the object is at rest [s] (default: its begin)");
  option("--marker-release", stage.release, "Time at which it is let go [s] (default: where motion sets in)");
  option("--marker-window", stage.window, "Time after the release that the fit sees [s]; as much again judges it")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  option("--marker-load", stage.interactions,
         "JSON array of what acts from the release on, its time 0 (default: gravity)");
}

void add_generator_options(CLI::App& command, GenerateStage& stage) {
  constexpr const char* kGroup = "A generated video";
  command
      .add_option("--generate-with", stage.command,
                  "Program that makes the video: `CMD FOLDER` finds first.png, camera.json and request.json there and "
                  "writes frames/0000.png, ... "
                  "(fitting/fit/generate_video.h; fitting/fit/adapters has one for Stable Video Diffusion)")
      ->group(kGroup);
  command.add_option("--generate-frames", stage.frames, "Frames that it is asked for, at --video-fps (default 24)")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str()
      ->group(kGroup);
  command.add_option("--generate-prompt", stage.prompt, "What it is told")->group(kGroup);
}

/// Videos, their cameras and their masks, paired in the order in which they are given.
void add_video_options(CLI::App& command, FitStage& stage, const std::string& prefix) {
  const auto paired = [&](const std::string& name, std::string FitStage::*first, std::string FitStage::Further::*more,
                          const std::string& description) {
    const auto take = [&stage, first, more](const std::vector<std::string>& values) {
      if (stage.further.size() + 1 < values.size()) stage.further.resize(values.size() - 1);
      stage.*first = values[0];
      for (size_t i = 1; i < values.size(); ++i) stage.further[i - 1].*more = values[i];
    };
    return command.add_option_function<std::vector<std::string>>(name, take, description)
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  };
  using Further = FitStage::Further;
  paired("--video", &FitStage::video, &Further::video,
         "Video, or folder of frames, that shows the object moving (default: the scene file's); once more for each "
         "further camera");
  // `run` has another --camera.
  paired(prefix.empty() ? "--video-camera,--camera" : "--video-camera", &FitStage::camera, &Further::camera,
         "Camera that took it, or 'find': known cameras are compared with its first frame, the best is refined "
         "(default: the scene file's, else find); once for each video");
  paired("--video-mask", &FitStage::video_mask, &Further::mask,
         "Picture, or folder or video of as many frames as the video: what is dark there, such as a hand, is not "
         "compared; once for each video, 'none' for one without")
      ->check(CLI::IsMember({"none"}) | CLI::ExistingPath);
}

void add_compare_options(CLI::App& command, CompareStage& stage, const std::string& prefix) {
  const auto option = [&](const std::string& name, auto& value, const std::string& description) {
    return command.add_option("--" + prefix + name, value, description)
        ->group("What gradients compare")
        ->capture_default_str();
  };
  option("loss", stage.loss, "tracks: points that are followed; pictures: drawn frames against the video's; both")
      ->check(CLI::IsMember({"tracks", "pictures", "both"}));
  option("loss-lambda", stage.lambda, "Share of L1 in the loss of pictures, the rest is D-SSIM")
      ->check(CLI::Range(0.0, 1.0));
  option("picture-weight", stage.picture_weight,
         "What the whole loss of pictures counts, in square pixels of the tracks")
      ->check(CLI::PositiveNumber);
  option("flow-weight", stage.flow_weight,
         "What a square pixel of optical flow counts, in square pixels of the tracks; 0 = flow is not compared")
      ->check(CLI::NonNegativeNumber);
  option("gradient-window", stage.window, "Frames through which gradients run back (PhysDreamer: 1); 0 = all")
      ->check(CLI::NonNegativeNumber);
  option("gradient-iterations", stage.iterations, "Of these gradients")->check(CLI::Range(1, 100000));
  command.add_flag("--fit-poisson", stage.poisson, "Fit one Poisson's ratio too, by gradients")
      ->group("What gradients compare");
  constexpr const char* kGroup = "A program that judges the drawn motion";
  command
      .add_option("--guide-with", stage.guide,
                  "Program that says how each pixel of the drawn motion should change, as in score distillation: `CMD "
                  "FOLDER` talks in lines of JSON "
                  "(fitting/fit/guidance.h); beside a video, or without one")
      ->group(kGroup);
  command.add_option("--guide-weight", stage.guide_weight, "Of its loss, in square pixels of the tracks")
      ->check(CLI::PositiveNumber)
      ->capture_default_str()
      ->group(kGroup);
  command
      .add_option("--guide-limit", stage.guide_limit,
                  "Time that it may take for each answer, and half of what it may take to start [s]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str()
      ->group(kGroup);
  command
      .add_option("--guide-frames", stage.guide_frames,
                  "Without a video: frames that are drawn, at --video-fps (default 24)")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str()
      ->group(kGroup);
  command
      .add_option("--guide-load", stage.load,
                  "Without a video: JSON array of what acts (default: one push sized to the stiffness)")
      ->check(CLI::ExistingFile)
      ->group(kGroup);
}

}  // namespace

void add_fit_options(CLI::App& command, FitStage& stage, const std::string& prefix) {
  stage.prefix = prefix;
  add_video_options(command, stage, prefix);
  command
      .add_option(
          "--video-pose", stage.pose,
          "File with the camera that took it (transforms.json, cameras.json, COLMAP), where it is none of the scene's")
      ->check(CLI::ExistingPath);
  command.add_flag("--refine-camera", stage.refine_camera,
                   "Move that camera until the scene looks like the first frame");
  command.add_option("--video-first", stage.first, "Begin of the part that is used [s]")->check(CLI::NonNegativeNumber);
  command.add_option("--video-last", stage.last, "End of it [s] (default: the video's end)")
      ->check(CLI::PositiveNumber);
  command
      .add_option("--video-fps", stage.fps, "Frames a second of a folder of frames, or that hold against the file's")
      ->check(CLI::PositiveNumber);
  command
      .add_option("--" + prefix + "compare-fps", stage.compare_fps,
                  "Frames a second that are compared: all videos are resampled to it (default: the first one's own)")
      ->check(CLI::Range(1.0, 1000.0));
  command
      .add_option("--" + prefix + "from", stage.from,
                  "Time in the video from which on nothing pushes the object [s] (default: found)")
      ->check(CLI::NonNegativeNumber);
  command
      .add_option("--" + prefix + "until", stage.until,
                  "Time in the video after which frames only judge the fit [s] (default: all are used)")
      ->check(CLI::PositiveNumber);
  command.add_option("--" + prefix + "points", stage.points, "Points of the object's surface that are followed")
      ->check(CLI::Range(20, 20000))
      ->capture_default_str();
  command
      .add_option("--" + prefix + "field", stage.field,
                  "How stiffness may differ from place to place: uniform, parts (by place and look), smooth, triplanes "
                  "(by gradients, with v0(x))")
      ->check(CLI::IsMember({"uniform", "parts", "smooth", "triplanes"}))
      ->capture_default_str();
  command
      .add_option("--" + prefix + "recipe", stage.recipe,
                  "search: over stiffness, then Gauss-Newton; physdreamer: gradients alone, v0(x) from three frames, "
                  "then E(x) from the E that is given")
      ->check(CLI::IsMember({"search", "physdreamer"}))
      ->capture_default_str();
  command
      .add_option("--" + prefix + "parts", stage.parts,
                  "Patches of the object, of --" + prefix + "field parts; those that look alike are one part")
      ->check(CLI::Range(2, 32))
      ->capture_default_str();
  command
      .add_option("--" + prefix + "part-labels", stage.part_labels,
                  "Labels of the scene's Gaussians (labels.h5, segmentation.h5) that say the parts instead")
      ->check(CLI::ExistingFile);
  command
      .add_option("--released-fields", stage.released_young,
                  "Of a PhysDreamer scene folder: take sim_fields.pt and velo_fields.pt with this E0 [Pa in its cube] "
                  "instead of fitting")
      ->check(CLI::NonNegativeNumber);
  add_compare_options(command, stage.compare, prefix);
  add_generator_options(command, stage.generate);
  add_marker_options(command, stage.markers);
}

}  // namespace pliant
