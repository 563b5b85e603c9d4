#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "segmentation/labels/segmentation.h"

namespace pliant {

/// The segmentation whose labels are known of every Gaussian, as of a selection: attributes are the codes of the
/// classes, so that the classifier gives `label` [N] back.  `names` by id; ids that no Gaussian has are left out.
/// Cameras of the classes are those in whose id pictures they show, drawn small; `antialiased` as in Segmentation.
Segmentation segmentation_of_labels(std::span<const uint32_t> label, const std::map<uint32_t, std::string>& names,
                                    const GaussianCloud& cloud, const std::vector<Camera>& cameras, uint64_t seed,
                                    bool antialiased = false);

}  // namespace pliant
