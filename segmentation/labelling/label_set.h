#pragma once

#include <map>
#include <string>
#include <vector>

#include "segmentation/labelling/id_picture.h"
#include "segmentation/labels/mask_set.h"

namespace pliant {

struct LabelSetOptions {
  bool rest = true;  ///< pixels in no mask get an id of their own, named "rest", which says that they are no object's
};

/// Labelled photos, photo k of camera cameras[k], as one set of masks.  The k-th best thing of a name has the same id
/// in every photo, and things without a name an id of their own: what is the same thing is for `associate` to say.
MaskSet gather_labels(const LabelSetOptions& options, const std::vector<int>& cameras,
                      const std::vector<LabelledPhoto>& photos);

/// Takes the id named "rest" out of the masks and returns it, 0 when there is none: ground that hides a thing in one
/// photo and not in another must not join things when masks are associated.
uint32_t take_out_rest(MaskSet& masks);
/// Pixels that were `rest` in `before` and are 0 in `after` get the id `rest` back, named "rest": what few photos show
/// as a thing and most as the rest is the rest.  What has this id in `after` gets another one, see free_id.
void put_back_rest(const MaskSet& before, uint32_t rest, MaskSet& after);

/// Names for the ids that `after` uses.  Names in `after` stay as they are; other ids take those that the same pixels
/// had in `before` (views by camera): the name with most pixels, none where more had no name.  Of several ids of one
/// name those without a name in `after` are numbered from the largest on, whatever number they had: "chair", "chair 2".
std::map<uint32_t, std::string> carried_names(const MaskSet& before, const MaskSet& after);

}  // namespace pliant
