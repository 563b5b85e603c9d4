#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/segment/segment_stage.h"
#include "segmentation/discover/automatic.h"
#include "segmentation/labels/segmentation.h"

namespace pliant {

/// Whether a segmentation finds its objects by itself: it is asked to (`--auto`), or it has neither masks nor a
/// selection.  Throws Error{kUsage} when it is asked for along with something else to go by.
bool segments_automatically(const SegmentStage& stage, bool selecting, bool has_masks);

/// Objects and supports from the Gaussians alone, see find_objects; says what was found.
AutomaticResult find_automatically(const Context& context, const Scene& scene, const std::vector<int>& held_out);

/// Names by id.
std::map<uint32_t, std::string> names_of(const std::vector<FoundThing>& found);

/// Writes how each thing was found to Segmentation::class_origin, and what it was found as to "kind" of the rows of
/// objects.json.
void tell_how_found(const std::vector<FoundThing>& found, Segmentation& segmentation);
void tell_kinds(const std::vector<FoundThing>& found, nlohmann::json& objects);

/// Ids of the rows of objects.json that are supports.
std::vector<uint32_t> supports_among(const nlohmann::json& objects);

}  // namespace pliant
