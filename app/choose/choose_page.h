#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/live/local_server.h"
#include "app/run/run_directory.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// What was marked in pictures to select an object, as --click and --stroke take it; cameras by number.
struct Marks {
  std::vector<std::string> clicks, strokes;
};

/// What the page of a segmented scene shows: `things` (rows of objects.json with a colour), `views` of at most eight
/// cameras with a picture (WebP, base64), its `scale` to the camera's pixels and `ids`, pairs of an id and how many
/// pixels it fills, row by row; and the marks.
nlohmann::json choose_data(const RunDirectory& run, const Scene& scene, const Marks& marks);

/// The page that shows them.
LocalServer::Page choose_page(const nlohmann::json& data);

}  // namespace pliant
