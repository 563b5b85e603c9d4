#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "fitting/observe/reference_video.h"

namespace pliant {

// An image-to-video model is another program (--video-model-cmd CMD).  It is run once, as `CMD FOLDER`, and finds there
//   first.png     the scene from the camera, 8-bit RGB; frame 0 of the video
//   camera.json   {"name", "width", "height", "fx", "fy", "cx", "cy", "cam_from_world": 4 rows of 4}: x right, y down,
//   z forward request.json  {"protocol": 1, "frames": T, "fps": F, "width": W, "height": H, "seed": S, "prompt": "...",
//                  "first": "first.png", "camera": "camera.json", "write": "frames/%04d.png"}
// It writes frames/0000.png to frames/<T - 1>.png of W x H pixels, frame k at k / F seconds, and ends with exit code 0.
// What it prints goes to log.txt.  adapters/stable_video_diffusion.py is such a program.

struct GenerateOptions {
  std::string command;
  int frames = 14;
  double fps = 24;
  uint64_t seed = 0;
  std::string prompt;
  double time_limit = 3600;           ///< s
  std::string made_for;               ///< all that decides what the program makes; empty = not known
  std::function<bool()> interrupted;  ///< see ChildOptions
};

/// Whether `folder` has all frames that a program made for the same `made_for`.
bool has_generated(const GenerateOptions& options, const std::filesystem::path& folder);

/// Runs the program in `folder` (made when missing; frames of an earlier run are removed) on `first` [H, W, 3], the
/// scene seen from `camera`; where has_generated, its frames are read again instead.  Throws Error{kInput} when it
/// fails, takes too long, or leaves frames out or of another size.
ReferenceVideo generate_video(const GenerateOptions& options, const ImageF& first, const Camera& camera,
                              const std::filesystem::path& folder);

}  // namespace pliant
