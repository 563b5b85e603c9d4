#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/image.h"

namespace pliant {

/// What a fit is to explain: pictures of the object in motion from one fixed camera.
struct ReferenceVideo {
  Camera camera;               ///< size of the frames
  double fps = 0;              ///< of the frames
  std::vector<ImageF> frames;  ///< [T] of [H, W, 3]
  std::vector<std::string> warnings;

  double file_fps = 0;               ///< that the file tells; 0 for a folder of pictures
  double declared_fps = 0;           ///< that the scene file tells; 0 = none
  double source_fps = 0;             ///< of the file's frames, that times follow: one of the two
  bool declared_rate_holds = false;  ///< times follow the scene file although the file tells another rate
  double start = 0;                  ///< s from the first frame of the file to the first one here
  int frames_in_file = 0;            ///< decoded up to the end of the wanted part
  std::vector<double> instants;      ///< of those, s from the first one
  int blended = 0;                   ///< frames made from two of the file
  int pictures = 0;                  ///< in a folder, beyond the wanted part too; 0 = a file
  std::optional<Camera> lens;        ///< that was removed from the frames
};

/// How a frame arises at an instant between two of the file.
enum class Resampling {
  kLinear,   ///< linear in time, pixel by pixel: edges that move far are doubled, but no instant is shifted
  kNearest,  ///< the nearer one: sharp, up to half a frame early or late
};

struct VideoOptions {
  double first = 0, last = 0;    ///< s of the file, the wanted part; last = 0: to its end
  bool exact_start = false;      ///< frames begin at `first` itself; else at the file's frame nearest to it
  double fps = 0;                ///< wanted; 0 = that of the file, which takes every frame as it is
  double declared_fps = 0;       ///< of the file as the scene file tells; needed for a folder
  bool trust_declared = false;   ///< the declared rate holds against the file's, as for slow motion
  std::vector<double> instants;  ///< s, of the pictures of a folder; empty = the numbers in their names tell them
  Resampling resampling = Resampling::kLinear;
  bool brightest = false;   ///< frames are [H, W, 1], of the brightest colour: those of a mask
  double most_bytes = 3e9;  ///< of the frames in memory
  /// `camera` as it took the video, with its lens, in the same place: the lens is removed from frames of its shape.
  /// Frames of exactly the size of `camera` have been freed of it.
  std::optional<Camera> lens;
  // What messages advise: the options that choose the part, and what else saves memory.
  std::string part_options = "--video-first, --video-last", other_savings = "a lower rate, or a smaller camera";
};

/// Reads a video of any format that OpenCV decodes through FFmpeg, or a folder of pictures in the order of the numbers
/// in their names; takes the wanted part at the wanted rate and scales it to the size of `camera`.  Frames of a file
/// with an uneven rate are resampled by their time stamps; a frame that is missing is a blend of its neighbours. Throws
/// Error{kInput} naming the file when it does not exist, is no video, has fewer than two frames in the wanted part, a
/// rate outside 1 to 1000 per second, or a shape (width / height) more than 2 % off the camera's, or its lens's;
/// Error{kUsage} for impossible options.
ReferenceVideo load_reference_video(const VideoOptions& options, const std::filesystem::path& file_or_folder,
                                    const Camera& camera);

}  // namespace pliant
