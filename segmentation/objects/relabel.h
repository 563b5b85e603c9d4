#pragma once

#include <cstdint>
#include <span>

#include "segmentation/labels/segmentation.h"

namespace pliant {

/// Changes of the list of objects that keep attribute, classifier and labels in agreement.  Means and classifier rows
/// are those of the segmentation that comes in; labels of Gaussians that a change does not name stay.

/// Gaussians of class `from` become class `to`, and class `from` is gone.  Their attributes are mirrored in the plane
/// midway between the two classes' mean attributes, which carries one mean to the other and leaves the share of third
/// classes in a Gaussian at a silhouette as it was.
void merge_classes(uint32_t to, uint32_t from, Segmentation& segmentation);

/// Gaussians with `part` [N] != 0, all of them of class `from`, become the new class `id`.  Where a direction is
/// orthogonal to all rows of the classifier, rows and attributes of the two classes part along it, and confidences in
/// others stay.  Else the new row is a direction of low coherence with the others, as long as they are.
void split_class(uint32_t from, uint32_t id, const std::string& name, std::span<const uint8_t> part,
                 Segmentation& segmentation);

/// Gaussians of class `id` take the attribute of the nearest others along surfaces (nearest_seen), and the class is
/// gone. Where it is the only one everything becomes id 0, "unlabelled".  Returns how many Gaussians changed.
size_t drop_class(uint32_t id, const std::vector<Vec3f>& position, Segmentation& segmentation);

/// Moves the attribute of every Gaussian whose most probable id is not wanted[p] towards the mean of that class until
/// it is, with a lead of 0.2 in the logits where that is possible, then recomputes labels and confidences.  Throws
/// Error{kNumerical} when the classifier cannot express the labels.
void enforce_labels(std::span<const uint32_t> wanted, Segmentation& segmentation);

}  // namespace pliant
