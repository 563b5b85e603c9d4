#pragma once

#include "fitting/fit/fit_material.h"

namespace pliant {

constexpr int kPublishedFrames = 14;  ///< of PhysDreamer's clips, the picture from which they were generated included

/// PhysDreamer's own recipe (Zhang et al. 2024), without a search, Gauss-Newton or damping: from the E of `particles`
/// and the shape at rest in the tracks' frame at options.vibration.search.first (negative: 0, or, where a push builds
/// the motion up, where the body first swings back through that shape), first v0(x) alone from the three frames after
/// it, through all of which its gradient runs, then E(x) alone over a window that grows from six frames to
/// options.clip_frames (kPublishedFrames in its programs), with options.gradient_window.  v0(x) is PhysDreamer's planes
/// for kTriplanes, else smooth; it finds only what lies downhill from that E.  All iterations are made, and the best
/// counts.  `homogeneous` of the result is that E with v0(x).  With options.released_code as its programs do it.
MaterialFit fit_physdreamer(const MaterialFitOptions& options, const Particles& particles,
                            const std::vector<Interaction>& interactions, const TrackLoss<float>& tracks, double fps,
                            const std::function<void(const std::string&)>& progress = {},
                            MaterialFitProgress kept = {});

}  // namespace pliant
