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
  std::string cameras;             ///< empty or "scene", "orbit", a camera file or a camera path
  std::string camera;              ///< name of the only one of these that is rendered; empty = all; not for a video
  std::optional<double> fps;       ///< of a video, whose path is then sampled anew; default: the path's, else 30
  std::string size;                ///< see sized(); empty = that of the cameras
  std::vector<double> background;  ///< [3] in 0..1; empty = the scene's
  bool depth = false;
  std::optional<int> orbit_views;  ///< of "orbit"; default 24
};

/// Whether `out` names a video, .mp4 in upper or lower case, and not a folder for images.  A usage error for other
/// endings of pictures and videos, and for what is there and is neither.
bool is_video_out(const std::filesystem::path& out);

/// Renders a scene from its cameras: one PNG per camera in the folder `out`, or a video (is_video_out).  Images that
/// an earlier call wrote into the folder, by its pictures.json, are replaced or removed; other files stay, and where
/// one has the name of an image, or is the scene's own video, that is a usage error before anything is written.
nlohmann::json render_pictures(const Context& context, const Scene& scene, const PictureOptions& options,
                               const std::filesystem::path& out);

}  // namespace pliant
