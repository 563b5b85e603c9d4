#include "app/commands/stage_options.h"
#include "app/pipeline/fit_stage.h"

namespace pliant {
namespace {

void add_marker_options(CLI::App& command, MarkerStage& stage) {
  const auto option = [&](const char* name, auto& value, const char* description) {
    return command.add_option(name, value, description)->group("Markers instead of a video");
  };
  option("--markers", stage.file, "Table of marker positions after the object was let go from rest (CSV: time, NAME_x, NAME_y, NAME_z, ...)");
  option("--marker-axes", stage.axes, "Columns along the scene's x, y, z, with signs, such as y,-x,z")->capture_default_str();
  option("--marker-units", stage.units, "Of columns that name no unit")->check(CLI::IsMember({"metres", "scene"}))->capture_default_str();
  option("--marker-offset", stage.offset, "Added to the markers, along the scene's axes, in those units")->expected(3)->delimiter(',');
  option("--marker-reach", stage.reach, "Markers farther from the object's material are left out [m] (default: two cells)")->check(CLI::PositiveNumber);
  option("--marker-rest", stage.rest, "Time in the table from which on the object is at rest [s] (default: its begin)");
  option("--marker-release", stage.release, "Time at which it is let go [s] (default: where motion sets in)");
  option("--marker-window", stage.window, "Time after the release that the fit sees [s]; as much again judges it")->check(CLI::PositiveNumber)->capture_default_str();
  option("--marker-load", stage.interactions, "JSON array of what acts from the release on, its time 0 (default: gravity)");
}

void add_generator_options(CLI::App& command, GenerateStage& stage) {
  constexpr const char* kGroup = "A generated video";
  command.add_option("--generate-with", stage.command,
                     "Program that makes the video: `CMD FOLDER` finds first.png, camera.json and request.json there and writes frames/0000.png, ... "
                     "(fitting/fit/generate_video.h; fitting/fit/adapters has one for Stable Video Diffusion)")
      ->group(kGroup);
  command.add_option("--generate-frames", stage.frames, "Frames that it is asked for, at --video-fps (default 24)")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str()
      ->group(kGroup);
  command.add_option("--generate-prompt", stage.prompt, "What it is told")->group(kGroup);
}

}  // namespace

void add_fit_options(CLI::App& command, FitStage& stage, const std::string& prefix) {
  command.add_option("--video", stage.video, "Video, or folder of frames, that shows the object moving (default: the scene file's)");
  command.add_option("--video-camera", stage.camera, "Camera that took it, or 'find': known cameras are compared with its first frame, the best is refined (default: the scene file's, else find)");
  command.add_option("--video-pose", stage.pose, "File with the camera that took it (transforms.json, cameras.json, COLMAP), where it is none of the scene's")
      ->check(CLI::ExistingPath);
  command.add_flag("--refine-camera", stage.refine_camera, "Move that camera until the scene looks like the first frame");
  command.add_option("--video-first", stage.first, "Begin of the part that is used [s]")->check(CLI::NonNegativeNumber);
  command.add_option("--video-last", stage.last, "End of it [s] (default: the video's end)")->check(CLI::PositiveNumber);
  command.add_option("--video-fps", stage.fps, "Frames a second of a folder of frames, or that hold against the file's")->check(CLI::PositiveNumber);
  command.add_option("--" + prefix + "from", stage.from, "Time in the video from which on nothing pushes the object [s] (default: found)")->check(CLI::NonNegativeNumber);
  command.add_option("--" + prefix + "until", stage.until, "Time in the video after which frames only judge the fit [s] (default: all are used)")->check(CLI::PositiveNumber);
  command.add_option("--" + prefix + "points", stage.points, "Points of the object's surface that are followed")->check(CLI::Range(20, 20000))->capture_default_str();
  command.add_option("--" + prefix + "field", stage.field, "How stiffness may differ from place to place: uniform, parts (by place and colour), smooth, triplanes (by gradients, with v0(x))")
      ->check(CLI::IsMember({"uniform", "parts", "smooth", "triplanes"}))
      ->capture_default_str();
  command.add_option("--" + prefix + "parts", stage.parts, "Parts of the object that may differ in stiffness, of --" + prefix + "field parts")
      ->check(CLI::Range(2, 32))
      ->capture_default_str();
  command.add_option("--released-fields", stage.released_young,
                     "Of a PhysDreamer scene folder: take sim_fields.pt and velo_fields.pt with this E0 [Pa in its cube] instead of fitting")
      ->check(CLI::NonNegativeNumber);
  add_generator_options(command, stage.generate);
  add_marker_options(command, stage.markers);
}

}  // namespace pliant
