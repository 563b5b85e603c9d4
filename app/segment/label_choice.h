#pragma once

#include "app/segment/segment_stage.h"

namespace pliant {

/// Throws Error{kUsage} that names the option which was typed and what it lacks: a network that nothing would use, or
/// labelling that does not know what to look for.
void check_networks(const SegmentStage& stage);

/// Whether boxes, clicks or strokes show the object.
bool has_gestures(const SegmentStage& stage);

/// Whether `segment` makes the masks from the photos.
bool labels_photos(const SegmentStage& stage);

/// Whether a given segmenter turns gestures into masks.
bool prompts_segmenter(const SegmentStage& stage);

/// The option by which labelling was asked for, and its value.
struct TypedOption {
  std::string name, value;
};
TypedOption labelling_option(const LabelStage& stage);

}  // namespace pliant
