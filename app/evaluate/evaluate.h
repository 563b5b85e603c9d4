#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// PSNR [dB], SSIM and MS-SSIM of two folders of pictures (or two pictures), paired by name without extension: mean,
/// median and standard deviation over the pictures, and each of them.  The PSNR of identical pictures counts as
/// kPsnrOfIdentical.  Pictures with transparency are compared over black.  A picture that has the other one's size only
/// when its orientation tag turns it is turned.  The MS-SSIM of pictures smaller than 176 x
/// 176 pixels is null, and averages leave it out. Missing, extra or differently sized pictures are an Error{kInput}.
nlohmann::json evaluate_images(const std::filesystem::path& prediction, const std::filesystem::path& truth);

struct SegmentationScore {
  int band = 0;                ///< px inside the contours for boundary_miou; 0 = 2 % of the picture's diagonal
  std::string match = "auto";  ///< ids are compared by: name, where both sides share one, else id (auto); id; overlap
  bool common = false;         ///< leave out pictures of the truth that were not predicted, instead of scoring them 0
};

/// Two folders of id pictures, or two files with labels per Gaussian (segmentation.h5, labels.h5).  miou = mean over
/// the ids in the truth of intersection / union summed over all pictures; pixels that the truth leaves unlabelled do
/// not count; a missing picture counts as IoU 0 where the truth has ids.  Pictures also give boundary_miou (Cheng et
/// al. 2021).  warnings: sentences about what the truth cannot tell, as where it labels one object and no background.
/// Names come from labels.json in the folder or beside it, or from the files.  By name, an id that has the same name on
/// both sides stays, a name that one id has on either side tells the true id, ids that neither side names stay, and
/// others stand for nothing.  Matching by overlap is for ids without a meaning, as of associated masks: one to one,
/// largest IoU first.
nlohmann::json evaluate_segmentation(const std::filesystem::path& prediction, const std::filesystem::path& truth,
                                     const SegmentationScore& score = {});

/// Masks VIEW/PROMPT.png of a scene of LERF-Mask (Ye et al. 2024, Gaussian Grouping): mean over the views of a prompt,
/// then over prompts.  miou, boundary_miou are strict: a mask that is missing or of another size scores 0, two empty
/// ones score 1; where all are missing it is an Error{kInput}.  paper_compatible repeats the released script: missing
/// masks are skipped, others resized to the nearest pixel, and two empty ones have no value (null).
nlohmann::json evaluate_lerf_mask(const std::filesystem::path& prediction, const std::filesystem::path& truth);

/// The 8 scenes of NVOS (Ren et al. 2022), whichever are in masks/SCENE/IMAGE_mask.png, against SCENE/IMAGE_mask.png,
/// SCENE/IMAGE.png or SCENE.png: mean IoU, boundary IoU and accuracy.  Masks of another size are resized to the nearest
/// pixel; a missing one scores 0, and where all are missing it is an Error{kInput}.
nlohmann::json evaluate_nvos(const std::filesystem::path& prediction, const std::filesystem::path& truth);

/// Two trajectory.h5, compared in metres.  Each true particle is compared with the predicted particle that is nearest
/// at frame 0, by displacement since frame 0, at the true times.  Errors are relative to the object's height (its
/// extent along up, that of the prediction where the truth does not say it, or its largest extent when up is unknown).
/// Also the motion of the tip (top tenth; the tenth that moves most when up is unknown, or when the top moves less than
/// a third as far, as of what hangs): displacement over time, peak, final / peak, dominant_frequency [Hz] of the damped
/// oscillation (fit_oscillation) where it is free, null where there is none.  frequency_error is 1 where the truth
/// alone oscillates; a tip that moves notably, but may swing so slowly that the record holds less than half a period of
/// it, as what creeps may as well, has tip.frequency_below [Hz], and the least error that it can have.  free_from_s,
/// free_from_by: as of evaluate_motion, or the peak of the truth ("largest motion").
/// relative_error: root mean square error over the root mean square of the true displacements, 1 for a still object.
nlohmann::json evaluate_trajectory(const std::filesystem::path& prediction, const std::filesystem::path& truth);

/// Which part of a clip is compared.
struct ClipPart {
  double fps = 0;              ///< of folders of frames
  double from = 0, until = 0;  ///< s; until 0 = to the end
};

struct MotionScore : ClipPart {
  double free_from = -1;  ///< s from the begin of that part, from which on nothing pushes; negative = of trajectories
                          ///< the last change of loads, where it is known, else where the motion is largest
};

/// Two videos (or folders of frames), or two trajectory.h5.  Points of what moves are followed; the first principal
/// component of their displacements is the motion's course, to which a damped oscillation is fitted where it is free:
/// frequency_hz, decay_per_s and damping_time_s (amplitude falls as exp(-t / it)), log_decrement (per period), the
/// share of the course that it explains; amplitude_px (amplitude_m): half the way from end to end of what moves
/// most. Errors of frequency, damping (decay) and amplitude are relative.  free_from_s, free_from_by: where the motion
/// is taken to be free, and what says so: --free-from; interactions.json, the later change of the two trajectories
/// (last_load.h); or "largest motion".  Trajectories are compared over the time that both have.  Of videos also the
/// flow and the delay of the prediction (flow_comparison.h). The prediction is brought to the truth's size; each is
/// followed at its own frame rate.  A truth in which nothing moves is an Error{kInput}; a prediction without motion has
/// null frequency.  Videos are compared at compared_size (clip.h), width x height, of which pixels are.  warnings:
/// sentences about the clips.
nlohmann::json evaluate_motion(const std::filesystem::path& prediction, const std::filesystem::path& truth,
                               const MotionScore& score = {});

struct SliceScore : ClipPart {
  std::optional<int> row, column;  ///< px; default: those in which the reference changes most
};

/// Writes a row and a column of pixels over time, of a reference and of other videos (or folders of frames) beside each
/// other, to `picture`.  The others are brought to the reference's size (compared_size of clip.h; lines are of it),
/// frame rate and start, and cut to the shortest.  warnings: sentences about the clips. row_rmse, column_rmse: root
/// mean square difference of a clip's slice from the reference's, colours in [0, 1]; of a single clip at the top level,
/// too.
nlohmann::json evaluate_slices(const std::filesystem::path& reference, const std::vector<std::filesystem::path>& clips,
                               const SliceScore& score, const std::filesystem::path& picture);

/// Two material.h5: |log10(E / E true)| at every true sample from the nearest predicted one: mean, median,
/// volume-weighted mean, largest; and its signed mean.  Mean absolute errors of Poisson's ratio and relative ones of
/// density.
nlohmann::json evaluate_material(const std::filesystem::path& prediction, const std::filesystem::path& truth);

/// A run directory (background.ply, background_repaired.ply) against a scene of `pliant demo`, over all its views, in
/// PSNR [dB] of pooled squared errors.  psnr: pixels whose true surface no photo ever showed (truth/hidden), against
/// the photo without the object; psnr_opencv: the best of OpenCV's inpaintings of every view alone on the same pixels,
/// once of the photo and once of the background's picture with only the unknown left to fill; gain_over_opencv: their
/// difference.  consistency_psnr: those pixels carried by depth into every other view against what is there.
/// seen_elsewhere_psnr: pixels that the object hides in one view only.  outside.psnr: pixels farther than 2 from the
/// object, repaired against not repaired (outside.identical when equal).  A run of another scene is an Error{kInput}.
nlohmann::json evaluate_repair(const std::filesystem::path& run, const std::filesystem::path& scene);

/// Checks conditions like "psnr>=30" (operators >= <= > < ==; keys of nested objects are joined by a dot) and returns
/// a sentence for each that does not hold.  Unknown keys and unreadable conditions are an Error{kUsage}.
std::vector<std::string> assert_metrics(const nlohmann::json& metrics, const std::vector<std::string>& conditions);

}  // namespace pliant
