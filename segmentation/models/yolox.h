#pragma once

#include "segmentation/model_interfaces/detector.h"
#include "segmentation/models/neural_module.h"

namespace pliant {

/// YOLOX (Ge et al. 2021) as its authors export it to ONNX; run with the official weights of yolox_nano.
///   in   images: float32 [1,3,S,S] in 0..255, blue first; scaled to fit, upper left corner, the rest 114; S = 32 s
///   out  rows: float32 [1,84ss,C+5]: x, y, w, h, objectness, C class scores for each cell of the grids with strides 8,
///   16, 32
class YoloxDetector : public Detector {
 public:
  struct Options {
    float score = 0.3f;                   ///< least objectness times class score
    float overlap = 0.45f;                ///< of boxes of one class that are suppressed
    std::vector<std::string> names = {};  ///< of the classes; empty = those of the file
  };

  /// The names of the file are those in its description ("names"), without them those of COCO.  Another number of names
  /// than of classes is an Error{kInput}.
  YoloxDetector(std::unique_ptr<NeuralModule> module, const Options& options);

  /// Whether the outline of an ONNX file is that of YOLOX.
  static bool recognises(const ModelFile& file);
  /// C of such a file.
  static size_t classes(const ModelFile& file);

  std::vector<Detection> detect(const ImageF& picture, const std::vector<std::string>& names) override;
  std::vector<std::string> vocabulary() const override { return names_; }

 private:
  std::unique_ptr<NeuralModule> module_;
  Options options_;
  Contract contract_;
  std::vector<std::string> names_;
  int size_ = 0;
};

}  // namespace pliant
