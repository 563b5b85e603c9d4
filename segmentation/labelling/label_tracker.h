#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "segmentation/labelling/label_photo.h"
#include "segmentation/model_interfaces/tracker.h"

namespace pliant {

/// Labels the photos of an ordered sequence: the chain looks at the first one, at every `every`-th and wherever a thing
/// was lost; in between a tracker carries ids and names on.  Ids hold in all photos, an alternative to `associate`.
class LabelTracker {
 public:
  LabelTracker(const LabelOptions& options, const LabelModels& models, Tracker& tracker, int every)
      : options_(options), models_(models), tracker_(tracker), every_(every) {}

  /// Ids [H, W, 1] of the next photo; 0 = nothing that is followed.
  IdImage next(const ImageF& picture);
  /// Names of the ids so far, those without one left out.
  const std::map<uint32_t, std::string>& names() const { return names_; }
  /// What the user should know, by the first photo.
  const std::vector<std::string>& said() const { return said_; }

 private:
  LabelOptions options_;
  LabelModels models_;
  Tracker& tracker_;
  int every_, count_ = 0;
  uint32_t last_ = 0;  ///< the largest id so far
  std::map<uint32_t, std::string> names_;
  std::vector<std::string> said_;
};

}  // namespace pliant
