#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "app/fit/fit_scene.h"

namespace pliant {

/// How the body moves by a fit.
struct FittedMotion {
  int first_frame = 0;                  ///< of the video, that the first state belongs to
  std::vector<SimulationState> frames;  ///< one for each frame of the video from there to its end
};

constexpr double kMostPsnr = 60;  ///< dB that a frame counts as; rounding to 8 bits alone leaves 58.9 dB

/// How well the fitted motion and the videos agree inside the moving mask, dB, each frame's at most kMostPsnr, which
/// equal pictures have; means over frames, and over the videos that have some.
struct MotionScores {
  struct Span {
    int first = 0, last = -1;    ///< frames of the video; last < first: none
    double psnr = 0, still = 0;  ///< of the fitted motion, and of the first frame held
    int frames = 0;              ///< that had something to compare, in the video with most of them
  };
  Span fitted;      ///< that the simulated motion was fitted to
  Span searched;    ///< later ones that only the search for the stiffness saw
  Span later;       ///< held out
  double rest = 0;  ///< of the scene at rest against the first frame: what motion cannot mend
};

/// Scores; writes into `folder` the video, the fitted motion and their difference side by side (side_by_side.mp4), and
/// lines of pixels over time (slices.png), of further videos as side_by_side_2.mp4 and so on; nothing when the name is
/// empty.
/// `last_fitted`: frame of the video that the fit of the simulated motion ended with.
MotionScores compare_motion(const FitScene& fit, const FittedMotion& motion, int last_fitted,
                            const std::filesystem::path& folder);
/// The frames of each span, its PSNR and that of the first frame held.
nlohmann::json scores_to_json(const MotionScores& scores);

/// What the pictures of a fit show; what is empty gets none.
struct FitFindings {
  double young = 0;                                      ///< Pa, of the whole
  std::vector<double> young_of_driver;                   ///< [M] Pa
  std::vector<double> sigma_of_driver;                   ///< [M] decades, one standard deviation of log10 E
  std::vector<double> search_young, search_unexplained;  ///< the search: Pa, share of the motion
  struct Refinement {
    std::string name, label;    ///< of the stage, and what its values are
    std::vector<double> value;  ///< at its start and after every step
  };
  std::vector<Refinement> refinements;  ///< in the order in which they were made
};

/// young.png, uncertainty.png, search.png, loss.png.
void write_fit_pictures(const std::filesystem::path& folder, const FitScene& fit, const FitFindings& findings);

/// Makes fit/, or takes the pictures and videos of an earlier fit out of it.
void clear_fit_pictures(const RunDirectory& run);

/// What the report says of a fit: its numbers, what is not determined, and the pictures in fit/.
std::string fit_section(const RunDirectory& run);
/// fit/report.html
void write_fit_page(const RunDirectory& run);

}  // namespace pliant
