#pragma once

#include "app/pipeline/fit_stage.h"
#include "fitting/fit/reference_video.h"

namespace pliant {

/// The video that a fit explains and the camera that took it: one of the scene's, one of a pose file, or, when none is
/// named, the one that its first frame shows (fit/transforms.json keeps what was found).  With stage.generate, a program
/// makes the video from the scene as the camera sees it.  Throws Error{kUsage} for names that are not there,
/// Error{kInput} for files that cannot be used and for a first frame that shows something else.
ReferenceVideo load_fit_video(const Context& context, const RunDirectory& run, const Scene& scene, const FitStage& stage);

/// What of the stage decides the video: options and files.
void add_video_to_key(StageKey& key, const Scene& scene, const FitStage& stage);

/// How messages name it.
std::string video_name(const Scene& scene, const FitStage& stage);

}  // namespace pliant
