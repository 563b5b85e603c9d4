#pragma once

#include <string>
#include <utility>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "segmentation/labels/segmentation.h"
#include "segmentation/objects/split.h"

namespace pliant {

/// One change that a person makes to the objects of a scene; objects are given by id or name.
struct ObjectEdit {
  enum class Kind { kMerge, kSplit, kDrop, kName };
  Kind kind = Kind::kMerge;
  std::vector<std::string> objects;  ///< two or more of a merge, else one
  std::string name;                  ///< the new one, of kName

  /// From the text of an option: "3,7", "4", "9" or "3=vase".  Throws Error{kUsage} naming the option and its form.
  static ObjectEdit parse(Kind kind, const std::string& text);
  const char* option() const;  ///< "--merge", ...
  std::string text() const;    ///< what parse() takes
};

/// What an edit did.
struct EditOutcome {
  std::vector<uint32_t> ids;  ///< of the objects that are left or new
  size_t gaussians = 0;       ///< whose label changed
  std::string sentence;
  std::string old_name = "";                                  ///< of kName
  std::vector<std::pair<uint32_t, std::string>> merged = {};  ///< of kMerge: ID and name of what became part of ids[0]
};

/// Applies one edit.  Merge: all become the first, which keeps id and name.  Split: the part with most opacity keeps id
/// and name, others get ids that no object ever had.  Drop: Gaussians take the label around them.  Attribute,
/// classifier, labels, confidences and the lists of cameras agree afterwards; `cameras` are those of the scene.  Throws
/// Error{kUsage} for an unknown or ambiguous object (with the nearest one), a merge of an object with itself, a name
/// that another object has, that reads as an id or that parse() refuses, an object that cannot be split.
EditOutcome apply_edit(const SplitOptions& options, const ObjectEdit& edit, const GaussianCloud& cloud,
                       const std::vector<Camera>& cameras, Segmentation& segmentation);

}  // namespace pliant
