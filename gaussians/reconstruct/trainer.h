#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gaussians/reconstruct/attribute_term.h"
#include "gaussians/reconstruct/train_options.h"
#include "gaussians/reconstruct/training_photos.h"
#include "gaussians/reconstruct/training_state.h"

namespace pliant {

/// What one iteration did.
struct TrainStep {
  int iteration = 0;          ///< that are done now
  double progress = 0;        ///< of the whole training, in [0, 1]
  double loss = 0;            ///< of the photo that was shown
  double term = 0;            ///< of the attribute term
  int width = 0, height = 0;  ///< of the picture
  size_t gaussians = 0;
};

/// Most Gaussians of a training: the options' or, when they say 0, one for 100 pixels of the photos that are trained
/// on.
size_t gaussian_budget(const TrainOptions& options, const TrainingPhotos& photos);

/// Optimises Gaussians against photos by differentiable rendering (Kerbl et al. 2023): one photo an iteration, in an
/// order that is shuffled anew each round.  With a number of iterations the result is a pure function of options,
/// photos and starting cloud, equal bit for bit for any number of threads and over a save and a load of the state.
class Trainer {
 public:
  /// Begins with `start`, at least one Gaussian.  `photos` and `term` (may be null) must outlive the trainer.
  /// Throws Error{kInput} when no photo is left to train on.
  Trainer(const TrainOptions& options, const TrainingPhotos& photos, GaussianCloud start,
          const AttributeTerm* term = nullptr);
  /// Goes on from `state`; throws Error{kInput} when it does not belong to these photos.
  Trainer(const TrainOptions& options, const TrainingPhotos& photos, TrainingState state,
          const AttributeTerm* term = nullptr);

  bool finished() const;
  double progress() const;  ///< in [0, 1]
  TrainStep step();
  /// Counts wall time that passed outside of steps.
  void spend(double seconds) { state_.seconds += seconds; }

  const TrainingState& state() const { return state_; }
  size_t budget() const { return budget_; }
  /// Measures at most kMostInCurve of the held-out photos and appends to the curve; does nothing when none are held
  /// out.
  void measure();

 private:
  struct Shown {
    int photo, level;
    Camera camera;
    ImageF target, weight;
    Vec3f backdrop;  ///< colour behind the scene
  };
  void prepare();
  Shown show(double progress) const;
  void optimise(const Shown& shown, double progress, RenderGradient<float>& gradient,
                std::span<const float> adj_exposure, std::span<const float> adj_shared);
  void expose_better(int photo, float rate, std::span<const float> adj_exposure);
  void densify(double progress_before, double progress);

  TrainOptions options_;
  const TrainingPhotos& photos_;
  const AttributeTerm* term_;
  TrainingState state_;
  std::vector<int> trained_on_;  ///< photos that are not held out
  double extent_ = 1;
  double densified_at_ = -1;  ///< progress at which densify was last asked; -1 = never
  size_t budget_ = 0;
  int longest_side_ = 0;
};

/// The photo and its weights (empty = all count) at 1 / 2^level of their size, area averages, of colours those of the
/// pixels that count; `camera` follows.
void photo_at_level(const TrainingPhoto& photo, int level, Camera& camera, ImageF& pixels, ImageF& weight);

/// Puts a photo with alpha, `pixels` [H, W, 3] as photo_at_level made them, on the colour `to` instead of `from`.
void change_backdrop(const TrainingPhoto& photo, const Vec3f& from, const Vec3f& to, ImageF& pixels);

/// Quality of one held-out photo.
struct PhotoQuality {
  std::string name;
  double psnr = 0, ssim = 0;
  double corrected_psnr = 0;  ///< after the affine colour map that fits the photo best: without its exposure
};
/// PSNR and SSIM (windows inside the image) of the held-out photos at full size, clamped to [0, 1]; pixels that do not
/// count are left out, of the windows around others too.  Of more than `most` photos so many, evenly spread over their
/// order; 0 = all.
std::vector<PhotoQuality> held_out_quality(const GaussianCloud& cloud, const TrainingPhotos& photos,
                                           const RenderOptions& options, size_t most = 0);

/// Held-out photos that a point of the curve measures.
constexpr size_t kMostInCurve = 8;

}  // namespace pliant
