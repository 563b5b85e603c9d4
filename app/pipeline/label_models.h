#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "app/pipeline/run_directory.h"
#include "segmentation/labelling/label_photo.h"

namespace pliant {

/// Files of the 2D models that label photos; empty = none, or the built-in one that needs no weights.
struct LabelModelFiles {
  std::string tagger, detector, segmenter;
  bool trust_torchscript = false;
};

/// The models, opened.
struct OpenLabelModels {
  std::unique_ptr<Tagger> tagger;
  std::unique_ptr<Detector> detector;
  std::unique_ptr<PromptableSegmenter> segmenter;

  LabelModels models() const { return {tagger.get(), detector.get(), segmenter.get()}; }
};

/// Opens and verifies the models.  `threads` as in Context.
OpenLabelModels open_label_models(const LabelModelFiles& files, int threads);

/// Adds the files to what decides the outcome of a stage.
void add_inputs(const LabelModelFiles& files, StageKey& key);

}  // namespace pliant
