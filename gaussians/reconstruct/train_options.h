#pragma once

#include <cstdint>

#include "gaussians/render/image_loss.h"
#include "gaussians/render/render.h"

namespace pliant {

/// How Gaussians are added and taken away.
enum class Densification {
  kMcmc,  ///< Kheradmand et al. 2024: dead ones move onto living ones, noise explores, the number grows to the budget
  kClassic,  ///< Kerbl et al. 2023: clone and split where the screen gradient is large, prune, reset opacities
  kNone,
};

/// Defaults are those of the reference 3DGS code where it has them; lengths are in units of the extent of the cameras.
/// Everything that changes during training follows the progress from 0 to 1, so that a short training runs through
/// the same stages as a long one.
struct TrainOptions {
  int iterations = 7000;      ///< photos shown
  double seconds = 0;         ///< wall time instead of iterations; 0 = iterations count
  size_t most_gaussians = 0;  ///< budget; 0 = one for 100 pixels of the photos, 20,000 to 150,000
  Densification densification = Densification::kMcmc;
  int sh_degree = 3;              ///< reached in steps by a tenth of the progress
  bool coarse_to_fine = true;     ///< start on photos of a quarter of the size, then half
  bool exposure = false;          ///< train an affine colour map for each photo
  bool changing_backdrop = true;  ///< photos with alpha are put on another colour each time, so that nothing in the
                                  ///< scene can stand in for it
  PhotometricOptions loss = {.zero_weight = ZeroWeight::kUnknown};
  RenderOptions render;
  uint64_t seed = 1;

  float position_rate = 1.6e-4f, final_position_rate = 1.6e-6f;  ///< times extent, falls exponentially
  float color_rate = 2.5e-3f;  ///< of the constant coefficients; the others get a twentieth
  float opacity_rate = 5e-2f, scale_rate = 5e-3f, rotation_rate = 1e-3f;
  float exposure_rate = 1e-2f, final_exposure_rate = 1e-3f;

  int refine_every = 100;        ///< iterations between two densifications
  float refine_from = 0.02f;     ///< progress at which densification starts ...
  float grow_until = 0.5f;       ///< ... reaches the budget (MCMC) or ends (classic) ...
  float relocate_until = 0.85f;  ///< ... and dead Gaussians are moved for the last time (MCMC)
  float dead_opacity = 0.005f;
  float noise = 5.5e6f;           ///< MCMC: times position rate and covariance, in extents; 5e5 at an extent of 3.3
  float opacity_weight = 0.01f;   ///< MCMC: weight of the mean opacity in the loss ...
  float scale_weight = 0.01f;     ///< ... and of the mean standard deviation, in extents
  float screen_gradient = 2e-4f;  ///< classic: clone or split above this
  float split_scale = 0.01f;      ///< classic: larger ones are split, smaller ones cloned, in extents
  int resets = 4;                 ///< classic: opacity resets, evenly spread until grow_until
};

}  // namespace pliant
