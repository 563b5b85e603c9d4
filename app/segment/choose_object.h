#pragma once

#include <string>
#include <vector>

#include "gaussians/io/scene/scene.h"
#include "segmentation/labels/segmentation.h"

namespace pliant {

/// Classes of that name, or the one class of that ID.
std::vector<size_t> classes_called(const Segmentation& segmentation, const std::string& name);

/// What says which object is meant where neither the user nor the scene file names one.
struct ObjectHints {
  std::string label;               ///< what the user says it is ("potted palm"); empty = nothing
  std::vector<uint32_t> supports;  ///< of the automatic mode
};

/// The object to cut, and why that one where nobody chose it.
struct ChosenClass {
  size_t index = 0;
  std::string why;       ///< empty = it is the only one
  bool unnamed = false;  ///< there is a label, and several objects of which none is called so
};

/// Without a wish the only object, else the most prominent one of those whose name says what the label says, else the
/// most prominent of all.  The rest, the background and supports count only where there is nothing else.
/// Throws Error{kUsage} where there is no object.
ChosenClass choose_object(const Scene& scene, const Segmentation& segmentation, const ObjectHints& hints);

}  // namespace pliant
