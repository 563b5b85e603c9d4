#include "app/pipeline/label_models.h"

#include "segmentation/labelling/grab_cut_segmenter.h"
#include "segmentation/models/make_models.h"

namespace pliant {

OpenLabelModels open_label_models(const LabelModelFiles& files, int threads) {
  OpenLabelModels open;
  const auto options = [&](const char* option) {
    ModuleOptions module;
    module.option = option, module.trust_torchscript = files.trust_torchscript, module.threads = threads;
    return module;
  };
  if (!files.detector.empty()) open.detector = make_detector(files.detector, options("--detector"));
  open.segmenter = std::make_unique<GrabCutSegmenter>();
  return open;
}

void add_inputs(const LabelModelFiles& files, StageKey& key) {
  for (const auto& [role, file] : {std::pair{"tagger", files.tagger}, {"detector", files.detector}, {"segmenter", files.segmenter}})
    if (!file.empty()) key.inputs[role] = file;
}

}  // namespace pliant
