#pragma once

#include <filesystem>
#include <vector>

#include "app/pipeline/fit_scene.h"

namespace pliant {

/// How the body moves by a fit.
struct FittedMotion {
  int first_frame = 0;                  ///< of the video, that the first state belongs to
  std::vector<SimulationState> frames;  ///< one for each frame of the video from there to its end
};

/// How well the fitted motion and the video agree inside the moving mask, dB; means over frames.
struct MotionScores {
  double psnr_used = 0, psnr_later = 0;    ///< of the fit over frames that it saw, and over later ones
  double still_used = 0, still_later = 0;  ///< of the first frame held
  double rest = 0;                         ///< of the scene at rest against the first frame: what motion cannot mend
  int frames_used = 0, frames_later = 0;
};

/// Scores; writes the video, the fitted motion and their difference side by side, unless the name is empty.
MotionScores compare_motion(const FitScene& fit, const FittedMotion& motion, const std::filesystem::path& side_by_side);

}  // namespace pliant
