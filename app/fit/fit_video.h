#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/fit/fit_stage.h"
#include "fitting/observe/reference_video.h"

namespace pliant {

/// The video that a fit explains and the camera that took it: one of the scene's, one of a pose file, or, when none is
/// named, the one that its first frame shows.  fit/transforms.json keeps what was found or refined, after the cameras
/// of the videos before this one, `found` (null: none), to which it is added.  With stage.generate, a program makes the
/// video from the scene as the camera sees it, or has made it for the same inputs, in fit/generated/. Throws
/// Error{kUsage} for names that are not there, Error{kInput} for files that cannot be used and for a first frame that
/// shows something else. `stage` is that of the inputs, or of a further video of theirs, whose frames are of the same
/// instants as those of the one `beside` it.
ReferenceVideo load_fit_video(const Context& context, const RunDirectory& run, const FitInputs& in,
                              const FitStage& stage, const ReferenceVideo* beside = nullptr,
                              std::vector<Camera>* found = nullptr);

/// Whether the stage names a mask of its video.
bool has_mask(const FitStage& stage);

/// [T of the video] or [1], or empty without a stage.video_mask: 0 = a pixel that is not compared, dark in all of its
/// channels.  A folder has a mask for each frame of the video's file; a video of masks runs at its own rate unless
/// stage.fps or the scene overrides the rate of the video.  Throws Error{kInput} for a mask of another shape or number
/// of frames, and where numbers are missing among those of a folder that are not among the video's.
std::vector<ImageU8> load_compared(const FitStage& stage, const ReferenceVideo& video);

/// Says what is doubtful about the mask of a video.  Throws Error{kInput} where it is dark over the whole object in the
/// first frame, in which points are chosen.
void check_mask(const Context& context, const FitInputs& in, const FitStage& stage, const ReferenceVideo& video);

/// Where a PhysDreamer folder's mask of this camera has the foreground at rest, [H, W, 1]; empty without one.
ImageF load_object_mask(const Scene& scene, const Camera& camera);

/// The stage of a further video alone.
FitStage further_video(const FitStage& stage, size_t i);

/// The camera of a video that does not exist yet: the one that is named, else one that sees the object well.
Camera unfilmed_camera(const Context& context, const std::filesystem::path& object, const Scene& scene,
                       const FitStage& stage);

/// Whether there is a video, or a program that makes one.
bool has_video(const Scene& scene, const FitStage& stage);

/// The videos, their masks and the lenses of their cameras: role -> file or folder.  None for a video that a program
/// makes.
InputFiles video_files(const Scene& scene, const FitStage& stage);

/// What is known of each video besides what is in the file: camera, frames a second, whether those hold against the
/// file's.
nlohmann::json video_records(const Scene& scene, const FitStage& stage);

/// Whether it is told which cameras took the videos.
bool knows_cameras(const Scene& scene, const FitStage& stage);

/// `provenance` with a video that a program has made for it, by its frames.
std::string with_video(const RunDirectory& run, const FitStage& stage, const std::string& provenance);

/// How messages name it.
std::string video_name(const Scene& scene, const FitStage& stage);

}  // namespace pliant
