#pragma once

#include <nlohmann/json_fwd.hpp>

#include "fitting/observe/reference_video.h"

namespace pliant {

/// The optical flow of a video against the true one of the same size, from each frame of the truth to its next.  Where
/// the frames of the video lie at other times, the parts of the flows between them that fall into the step are chained.
///   flow_error_px: mean endpoint error over pixels that move in either; flow_in_truth_px: mean true flow there;
///   flow_error: their ratio
///   delay_s: how much later than the true one the motion of the video runs, where the flows match clearly better (by
///   their correlation) when shifted by that; else 0
///   flow_error_without_delay: flow_error of the shifted video
/// Null where nothing moves.
nlohmann::json compare_flow(const ReferenceVideo& video, const ReferenceVideo& truth);

}  // namespace pliant
