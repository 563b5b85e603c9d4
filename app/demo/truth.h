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

}  // namespace pliant
