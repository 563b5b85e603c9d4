#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "app/run/run_directory.h"
#include "app/segment/segment_stage.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// What was marked to select an object: a "box", "click" or "stroke" as the option takes it, with the number of a
/// camera; or "grow", with rings of neighbors, negative: to be taken off.
struct Mark {
  std::string kind, text;

  bool operator==(const Mark&) const = default;
};
/// In the order in which they were made.
using Marks = std::vector<Mark>;

/// The stage that selects by them.  A later mark counts over an earlier one at the same place; a box takes the place of
/// an earlier one in its camera.
SegmentStage segment_by(const Marks& marks);

bool share_one(const Marks& a, const Marks& b);

/// [{"kind", "text"}, ...]
nlohmann::json marks_json(const Marks& marks);

/// The marks that made the selection of a run, and the name that it was given; without marks where there is none, or
/// where more than marks in cameras of the scene and a name has made it.
struct MadeSelection {
  Marks marks;
  std::string name;  ///< empty = it has none
};
MadeSelection made_selection(const RunDirectory& run, const Scene& scene);

}  // namespace pliant
