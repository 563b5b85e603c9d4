#pragma once

#include <optional>
#include <string>

#include "app/segment/segment_stage.h"
#include "segmentation/select/selection.h"

namespace pliant {

/// Where the objects of a segmentation come from.
enum class ObjectSource {
  kMasks,          ///< given, of the scene file, or made from the photos
  kAutomatic,      ///< the Gaussians alone
  kJoint,          ///< a training of the scene together with its attribute
  kGrouping,       ///< a Gaussian Grouping model
  kConfiguration,  ///< of PhysGaussian
  kPointFiles,     ///< of PhysDreamer
  kSegmenter,      ///< masks that it makes of gestures
  kGesture,
  kShape,  ///< a box or a sphere
};

/// What `stage` asks for; where it asks for nothing, what the scene has, and else kAutomatic.  Throws Error{kUsage}
/// where it asks for things that exclude each other.
ObjectSource source_of(const Scene& scene, const SegmentStage& stage);

/// Throws Error{kUsage} where an option of `stage` does nothing for objects from there.
void check_object_options(ObjectSource source, const SegmentStage& stage);

/// Whether the attribute is learnt from masks; otherwise the label of every Gaussian is known.
bool learns_from_masks(ObjectSource source);

/// Whether the objects of a run were learned, from masks or by a program before, so that marks do not find them again.
bool has_learned_objects(const RunDirectory& run);

/// Whether there is one object, whose name the scene file cannot know.
bool selects_one_object(ObjectSource source);

/// --aabb or --sphere.  Throws Error{kUsage} where both are given or the numbers make no shape.
std::optional<SelectionShape> selection_of(const SegmentStage& stage);

/// How the objects are found, for objects.json.
std::string origin_of(const SegmentStage& stage, ObjectSource source);

}  // namespace pliant
