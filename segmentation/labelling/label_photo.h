#pragma once

#include <string>
#include <vector>

#include "segmentation/labelling/everything.h"
#include "segmentation/labelling/id_picture.h"
#include "segmentation/model_interfaces/detector.h"
#include "segmentation/model_interfaces/tagger.h"

namespace pliant {

struct LabelOptions {
  std::vector<std::string> names;  ///< things to look for; empty = what the tagger finds, else all the detector knows
  float least_score = 0.3f;        ///< of a detection
  float box_nms = 0.7f;            ///< overlap at which only the better of two boxes stays, whatever their names
  EverythingOptions everything;    ///< without a detector
  PaintOptions paint;
};

/// The models of the chain; what is null is left out.
struct LabelModels {
  Tagger* tagger = nullptr;
  Detector* detector = nullptr;
  PromptableSegmenter* segmenter = nullptr;  ///< never null
};

/// Names that `detector` is asked for.  A closed set gets its own names: the one that equals a wanted name up to case,
/// else is one of its words ("red flower": "flower"), else is spelt like it; `said` tells what was taken instead.
/// Throws Error{kUsage} when a wanted name has none.
std::vector<std::string> names_for(const Detector& detector, const std::vector<std::string>& wanted,
                                   std::vector<std::string>& said);

/// Whole-image labelling (Sim Anything supplement A): picture [H, W, 3] -> tags -> boxes -> masks -> one id picture.
/// Without a detector everything is segmented and nothing has a name.  A closed detector is asked for those tags that
/// it knows, and for everything it knows without a tagger; where no tag is left nothing is found.
LabelledPhoto label_photo(const LabelOptions& options, const LabelModels& models, const ImageF& picture);

}  // namespace pliant
