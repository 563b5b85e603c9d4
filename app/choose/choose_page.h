#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "app/choose/marks.h"
#include "app/live/local_server.h"
#include "app/run/run_directory.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// The cameras that the page shows, at most eight, all of which are prepared for selection.
std::vector<int> shown_cameras(const Scene& scene);
/// A camera of the scene at the size of the page's pictures.
Camera shown_camera(const Scene& scene, int camera);

/// Pairs of a value and how many pixels it fills, row by row.
nlohmann::json run_lengths(std::span<const uint32_t> values);

/// Rows of objects.json with a colour.
nlohmann::json shown_things(const RunDirectory& run);

/// What the page of a segmented scene shows: `things`, `views` of some cameras with a picture (WebP, base64), its
/// `scale` to the camera's pixels along x and y and `ids` as run lengths; and the marks.
nlohmann::json choose_data(const RunDirectory& run, const Scene& scene, const Marks& marks);

/// The page that shows them.
LocalServer::Page choose_page(const nlohmann::json& data);

/// `html` with the style that such pages share, and a policy that lets it talk to its server alone.
LocalServer::Page styled_page(std::string html);

}  // namespace pliant
