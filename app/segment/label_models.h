#pragma once

#include <memory>

#include "app/run/run_directory.h"
#include "segmentation/labelling/label_photo.h"
#include "segmentation/models/make_models.h"

namespace pliant {

/// The models, opened.
struct OpenLabelModels {
  std::unique_ptr<Tagger> tagger;
  std::unique_ptr<Detector> detector;
  std::unique_ptr<PromptableSegmenter> segmenter;

  LabelModels models() const { return {tagger.get(), detector.get(), segmenter.get()}; }
};

/// Opens and verifies the networks of a choice; the segmenter without one needs no weights.
OpenLabelModels open_label_models(const ModelChoice& choice);

/// Adds the files of the networks to what decides the outcome of a stage.
void add_files(const ModelChoice& choice, InputFiles& files);

}  // namespace pliant
