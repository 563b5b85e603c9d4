#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/run/progress.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

struct PictureOptions {
  std::string cameras;  ///< empty or "scene", "orbit", a camera file or a camera path
  std::string size;     ///< see sized(); empty = that of the cameras
  std::vector<double> background = {0, 0, 0};
  bool depth = false, antialiased = false;
  std::optional<int> orbit_views;  ///< of "orbit"; default 24
};

/// Renders a scene from its cameras: one PNG per camera in the folder `out`, or a video when `out` ends in .mp4.
nlohmann::json render_pictures(const Context& context, const Scene& scene, const PictureOptions& options,
                               const std::filesystem::path& out);

}  // namespace pliant
