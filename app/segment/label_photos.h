#pragma once

#include "app/run/stage_inputs.h"
#include "app/segment/label_models.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// label: photos -> masks with names: labelled/<camera>.png, labelled/labels.json, and to look at
/// labelled/seen/<camera>.jpg.
struct LabelStage {
  bool photos = false;      ///< label the photos; the rest says how
  bool everything = false;  ///< by the segmenter alone, without names
  bool track = false;       ///< photos in order: masks are carried on, their ids hold in all photos
  std::string text;         ///< names to look for, separated by commas; empty = everything the models know
  ModelChoice models;
};

/// Its options, bound to the fields of `stage`.
OptionTable options_of(LabelStage& stage);
StageInputs<LabelStage> inputs_of(const RunDirectory& run, const Scene& scene, const LabelStage& stage);

/// Labels the photo of every camera; a photo that was labelled with the same options before is not labelled again.
nlohmann::json run_label(const Context& context, RunDirectory& run, const Scene& scene, const LabelStage& stage);

}  // namespace pliant
