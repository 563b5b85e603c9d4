#pragma once

#include <string>

#include "segmentation/labels/segmentation.h"

namespace pliant {

/// Characters of the longest name that a person may give; bytes of what a folder shows of a name.
constexpr size_t kLongestName = 100;

/// Class of the object that `wanted` names by id or by name.  Throws Error{kUsage} about `option` when there is none,
/// with the nearest id or name and a list of what there is, or when several objects have that name.
size_t class_of_object(const Segmentation& segmentation, const std::string& option, const std::string& wanted);

/// "3 = vase, 7 = cup, ...", at most `most` of them.
std::string list_of_objects(const Segmentation& segmentation, size_t most = 20);

}  // namespace pliant
