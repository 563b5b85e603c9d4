#pragma once

#include <map>
#include <string>
#include <vector>

#include "segmentation/labelling/id_picture.h"
#include "segmentation/lift/mask_set.h"

namespace pliant {

struct LabelSetOptions {
  bool rest = true;  ///< pixels in no mask get an id of their own, named "rest", which says that they are no object's
};

/// Labelled photos, photo k of camera cameras[k], as one set of masks.  The k-th best thing of a name has the same id in
/// every photo, and things without a name an id of their own: what is the same thing is for `associate` to say.
MaskSet gather_labels(const LabelSetOptions& options, const std::vector<int>& cameras, const std::vector<LabelledPhoto>& photos);

/// Names for the ids that `after` uses, from the names that the same pixels had in `before` (views by camera): the name
/// with most pixels.  Several ids of one name are numbered from the largest on: "chair", "chair 2".
std::map<uint32_t, std::string> carried_names(const MaskSet& before, const MaskSet& after);

}  // namespace pliant
