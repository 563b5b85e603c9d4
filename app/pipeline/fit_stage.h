#pragma once

#include "app/pipeline/stages.h"

namespace pliant {

/// Markers on the object that were measured after it was let go from rest, instead of a video.
struct MarkerStage {
  std::string file;                  ///< table, see fitting/fit/markers.h
  std::string axes = "x,y,z";        ///< columns along the scene's x, y and z, each with a sign if need be: "y,-x,z"
  std::string units = "metres";      ///< of the columns without a unit of their own: metres, or scene units
  std::vector<double> offset;        ///< [3] of the scene's frame, in those units; added to the markers; empty = none
  double reach = 0;                  ///< m; farther from the material a marker is not on the object; 0 = two cells
  std::optional<double> rest;        ///< s of the recording, from which on the object is at rest; default: its begin
  std::optional<double> release;     ///< s of the recording; default: where motion sets in
  double window = 1;                 ///< s after the release that the fit sees; as much again judges it
  std::string interactions;          ///< file; what acts from the release on; empty = gravity
};

/// fit: a video of the moving object, or markers on it -> material.h5, velocity.h5, fit/.
struct FitStage {
  MarkerStage markers;        ///< no file: a video
  std::string video, camera;  ///< file or folder, and the camera that took it; empty = the scene file's
  double fps = 0;             ///< of a folder of frames, or against the file's; 0 = the scene file's, else the file's own
  double from = -1;           ///< s of the video, from which on nothing pushes the object; negative = found
  double until = 0;           ///< s of the video; later frames only judge the fit; 0 = all are used
  int points = 400;           ///< of the object's surface that are followed
  int parts = 1;              ///< of the object, by place and colour, that may differ in E; 1 = homogeneous
  MaterialValues material;    ///< command line's; E is where the search starts
};
nlohmann::json run_fit(const Context& context, RunDirectory& run, const Scene& scene, const FitStage& stage);
/// The same with stage.markers.
nlohmann::json run_marker_fit(const Context& context, RunDirectory& run, const Scene& scene, const FitStage& stage);

}  // namespace pliant
