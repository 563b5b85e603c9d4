#include "app/segment/label_models.h"

#include "segmentation/labelling/grab_cut_segmenter.h"

namespace pliant {

OpenLabelModels open_label_models(const ModelChoice& choice) {
  OpenLabelModels open;
  open.tagger = make_tagger(choice);
  open.detector = make_detector(choice);
  open.segmenter = make_segmenter(choice);
  if (!open.segmenter) open.segmenter = std::make_unique<GrabCutSegmenter>();
  return open;
}

void add_files(const ModelChoice& choice, InputFiles& files) {
  const std::vector<std::filesystem::path> all = choice.files();
  for (size_t i = 0; i < all.size(); ++i) files["network " + std::to_string(i + 1)] = all[i];
}

}  // namespace pliant
