#pragma once

#include <optional>

#include "app/import/physdreamer_folder.h"
#include "app/run/progress.h"

namespace pliant {

/// The folder that a scene was loaded from, when it is one of PhysDreamer without a scene.json.
std::optional<PhysDreamerFolder> physdreamer_folder(const Scene& scene);

/// Fills the scene's settings: the reference video, which is taken at 30 frames a second, density 2000 kg/m^3 and
/// Poisson's ratio 0.3 (the released code draws it at random from 0.1 to 0.4), and boxes that hold what its point files
/// hold fixed.
void take_physdreamer_settings(Scene& scene, const PhysDreamerFolder& folder);

/// Boxes that contain all of `held` and none of `free` [., 3], as few as a greedy search finds on a grid of `cell`,
/// which is made coarser until there are at most 64.  Space is held where the nearest of all points is one that is
/// held, no farther than two cells away.
std::vector<SceneFile::Region> boxes_around(std::span<const Vec3f> held, std::span<const Vec3f> free, double cell);

}  // namespace pliant
