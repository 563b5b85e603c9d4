#pragma once

#include <vector>

#include "app/demo/demo_interruption.h"
#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/image.h"

namespace pliant {

/// Optimises Gaussians that were laid on surfaces against the photos [H, W, 3] of the cameras, as a reconstruction does
/// (Trainer), but keeps their number and order: what is known of each stays true.  Every eighth photo is held out, as
/// everywhere; a single photo trains nothing.  Throws Error{kInterrupted}.
GaussianCloud train_splats(const GaussianCloud& laid, const std::vector<Camera>& cameras,
                           const std::vector<ImageU8>& photos, int iterations, uint64_t seed,
                           const Interrupted& interrupted = {});

}  // namespace pliant
