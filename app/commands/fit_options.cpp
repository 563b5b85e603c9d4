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

}  // namespace

void add_fit_options(CLI::App& command, FitStage& stage, const std::string& prefix) {
  command.add_option("--video", stage.video, "Video, or folder of frames, that shows the object moving (default: the scene file's)");
  command.add_option("--video-camera", stage.camera, "Camera that took it (default: the scene file's)");
  command.add_option("--video-fps", stage.fps, "Frames a second of a folder of frames")->check(CLI::PositiveNumber);
  command.add_option("--" + prefix + "from", stage.from, "Time in the video from which on nothing pushes the object [s] (default: found)")->check(CLI::NonNegativeNumber);
  command.add_option("--" + prefix + "until", stage.until, "Time in the video after which frames only judge the fit [s] (default: all are used)")->check(CLI::PositiveNumber);
  command.add_option("--" + prefix + "points", stage.points, "Points of the object's surface that are followed")->check(CLI::Range(20, 20000))->capture_default_str();
  command.add_option("--" + prefix + "parts", stage.parts, "Parts of the object, by place and colour, that may differ in stiffness; 1 = homogeneous")
      ->check(CLI::Range(1, 32))
      ->capture_default_str();
  add_marker_options(command, stage.markers);
}

}  // namespace pliant
