#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "app/run/run_directory.h"
#include "gaussians/io/scene/scene.h"
#include "segmentation/labels/segmentation.h"

namespace pliant {

/// Rows of objects.json: id, name, score, gaussians, views, found (how), bounds in scene units.
nlohmann::json objects_to_json(const std::vector<ObjectEntry>& objects);

/// Writes segmentation.h5, objects.json, objects.png (with objects_sheet.json) and features.png of a run directory, the
/// pictures last.  In these, renders stand in for photos that cannot be read, with a warning.
/// Lists of cameras that are not known are found first, `origin` is put where it is not known how an object was found,
/// `complete` may add to the rows of objects.json.
std::vector<ObjectEntry> write_objects(const Context& context, const RunDirectory& run, const Scene& scene,
                                       const std::string& origin, const std::string& provenance,
                                       Segmentation& segmentation,
                                       const std::function<void(nlohmann::json& rows)>& complete = {});

/// Writes held_out/<camera>.png, the id pictures of cameras that were not learnt from.
void write_held_out(const RunDirectory& run, const Scene& scene, const std::vector<int>& held_out,
                    const Segmentation& segmentation);

/// Folder of an object's results, relative to the run directory: objects/<id>_<name>.
std::string folder_of_object(uint32_t id, std::string name);

/// segmentation.h5 of a run directory; an input error when it does not belong to the scene.
Segmentation read_objects(const RunDirectory& run, const Scene& scene);

}  // namespace pliant
