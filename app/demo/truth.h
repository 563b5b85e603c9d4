#pragma once

#include <filesystem>
#include <string>

#include "app/demo/reference.h"
#include "app/demo/splats.h"

namespace pliant {

/// truth/: what a scene is really made of.  labels.h5 (id of each Gaussian), flower_parts.h5 (1 pot, 2 stem, 3 leaf,
/// 4 blossom, 0 elsewhere) and flower.json (proportions and elastic constants).
void write_truth(const std::filesystem::path& folder, const Stage& stage, const StageSplats& splats, uint64_t seed);

/// The reference simulation: material.h5, interactions.json, trajectory.h5 (an even subset of the particles) and
/// video_motion.json (place of the blossom in each frame).
void write_truth(const std::filesystem::path& folder, const ReferenceMotion& motion, const ReferenceFilm& film,
                 const Camera& camera, uint64_t seed);

/// What is behind the flower.  Ids of hidden/NAME.png.
enum HiddenId : uint32_t {
  kInPlainView = 0,    ///< the photo does not show the flower here
  kSeenElsewhere = 1,  ///< another photo shows the surface that the flower hides here
  kNeverSeen = 2,      ///< no photo does
};

/// The stage without the flower: without_object/NAME.png is its photo and hidden/NAME.png says which of its pixels the
/// given photos have never shown (HiddenId, at pixel centres).
void write_hidden_truth(const std::filesystem::path& folder, const Stage& stage, const std::vector<Camera>& cameras);

}  // namespace pliant
