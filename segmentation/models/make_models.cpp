#include "segmentation/models/make_models.h"

#include "gaussians/base/error.h"
#include "segmentation/models/yolox.h"

namespace pliant {

std::unique_ptr<Detector> make_detector(const std::filesystem::path& file, ModuleOptions options) {
  if (options.option.empty()) options.option = "--detector";
  auto module = std::make_unique<NeuralModule>(file, options);
  if (YoloxDetector::recognises(module->file())) return std::make_unique<YoloxDetector>(std::move(module), YoloxDetector::Options());
  throw input_error(file.string(), "", "is not a detector that this program knows", "give YOLOX as ONNX");
}

}  // namespace pliant
