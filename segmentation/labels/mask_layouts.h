#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "segmentation/labels/mask_set.h"

namespace pliant {

struct BinaryMasks {
  MaskSet masks;
  std::vector<size_t> complete;  ///< of masks.views those that have a picture of every object
};

/// Binary pictures of one object each, in folders.  Of two layouts the one that more pictures fit holds for all; as
/// many for both is an Error{kInput}:
///   <camera>/<label>.png   one folder for each view, as in LERF-Mask (Ye et al. 2024), where folders may also be
///                          numbered: the k-th of those cameras, by name, whose photo is not in images_train/ beside
///                          the masks;
///   <label>/<camera>.png   one folder for each object.
/// A pixel belongs to an object above half of the largest value in all pictures of its label; where objects overlap the
/// smaller one wins.  Labels that are all ids (whole numbers up to kLargestId) are these, else they are names, numbered
/// from 1 in alphabetical order.  Pixels of no object are 0.  Empty when the folder has neither layout.  Sizes and
/// `fit` as for load_masks; all pictures of a camera have one size.  Pictures that together hold three or more values,
/// all below half of white, are an Error{kInput}: they are masks with ids.
BinaryMasks load_binary_masks(const std::filesystem::path& folder, const std::vector<Camera>& cameras,
                              const FitMask& fit = {});

/// Throws Error{kInput} unless a mask has the size of its camera, or with `any_size` its shape.
void check_mask_size(const std::filesystem::path& file, int width, int height, const Camera& camera, bool any_size);

/// Names, without endings, of the photos in images_train/ beside a folder of masks; empty without that folder.
std::set<std::string> trained_photos(const std::filesystem::path& masks);

}  // namespace pliant
