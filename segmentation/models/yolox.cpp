#include "segmentation/models/yolox.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "segmentation/models/boxes.h"
#include "segmentation/models/picture.h"

namespace pliant {
namespace {

/// The 80 classes of COCO (Lin et al. 2014), in the order of the networks trained on it.
const char* const kCocoNames[] = {
    "person",         "bicycle",    "car",           "motorcycle",    "airplane",     "bus",           "train",
    "truck",          "boat",       "traffic light", "fire hydrant",  "stop sign",    "parking meter", "bench",
    "bird",           "cat",        "dog",           "horse",         "sheep",        "cow",           "elephant",
    "bear",           "zebra",      "giraffe",       "backpack",      "umbrella",     "handbag",       "tie",
    "suitcase",       "frisbee",    "skis",          "snowboard",     "sports ball",  "kite",          "baseball bat",
    "baseball glove", "skateboard", "surfboard",     "tennis racket", "bottle",       "wine glass",    "cup",
    "fork",           "knife",      "spoon",         "bowl",          "banana",       "apple",         "sandwich",
    "orange",         "broccoli",   "carrot",        "hot dog",       "pizza",        "donut",         "cake",
    "chair",          "couch",      "potted plant",  "bed",           "dining table", "toilet",        "tv",
    "laptop",         "mouse",      "remote",        "keyboard",      "cell phone",   "microwave",     "oven",
    "toaster",        "sink",       "refrigerator",  "book",          "clock",        "vase",          "scissors",
    "teddy bear",     "hair drier", "toothbrush"};

/// Cells of the grids with strides 8, 16 and 32 over a square of `size` pixels.
int64_t cells(int64_t size) { return size / 8 * (size / 8) + size / 16 * (size / 16) + size / 32 * (size / 32); }

}  // namespace

bool YoloxDetector::recognises(const ModelFile& file) {
  if (file.format != ModelFile::Format::kOnnx || file.graph.inputs.size() != 1 || file.graph.outputs.size() != 1)
    return false;
  const std::vector<int64_t>&in = file.graph.inputs[0].shape, &out = file.graph.outputs[0].shape;
  return in.size() == 4 && in[0] == 1 && in[1] == 3 && in[2] == in[3] && in[2] > 0 && in[2] % 32 == 0 &&
         out.size() == 3 && out[1] == cells(in[2]) && out[2] > 5;
}

size_t YoloxDetector::classes(const ModelFile& file) { return static_cast<size_t>(file.graph.outputs[0].shape[2] - 5); }

YoloxDetector::YoloxDetector(std::unique_ptr<NeuralModule> module, const Options& options)
    : module_(std::move(module)), options_(options) {
  const ModelFile& file = module_->file();
  CHECK(recognises(file));
  size_ = static_cast<int>(file.graph.inputs[0].shape[2]);
  const size_t count = classes(file);
  if (!options_.names.empty()) {
    names_ = options_.names;
  } else if (const nlohmann::json about = file.about(); about.contains("names") && about["names"].is_array()) {
    for (const nlohmann::json& name : about["names"])
      if (name.is_string()) names_.push_back(name);
  } else {
    names_.assign(std::begin(kCocoNames), std::end(kCocoNames));
  }
  if (names_.size() != count)
    throw input_error(file.file.string(), "names",
                      std::to_string(names_.size()) + " names for " + std::to_string(count) + " classes",
                      "give --vocabulary FILE with the name of each class, one per line");
  contract_.inputs = {{file.graph.inputs[0].name, Tensor::Type::kFloat32, "1,3,32s,32s", 0, 255, "blue first"}};
  TensorLine rows{file.graph.outputs[0].name, Tensor::Type::kFloat32,
                  "1," + std::to_string(cells(size_)) + "," + std::to_string(count + 5)};
  rows.meaning = "x, y, w, h, objectness and class scores";
  contract_.outputs = {rows};
  module_->verify(contract_, {{"s", size_ / 32}});
}

std::vector<Detection> YoloxDetector::detect(const ImageF& picture, const std::vector<std::string>& names) {
  const Fitted fitted = fit_picture(picture, size_, size_, 114.f / 255);
  Normalisation colours;
  colours.bgr = true;
  const Tensor rows = module_->run(contract_, {to_planes(fitted.picture, colours)})[0];
  const size_t length = names_.size() + 5;
  std::vector<Detection> boxes;
  const float* row = rows.values.data();
  for (const int stride : {8, 16, 32}) {
    for (int y = 0; y < size_ / stride; ++y) {
      for (int x = 0; x < size_ / stride; ++x, row += length) {
        const auto best = static_cast<size_t>(std::max_element(row + 5, row + length) - (row + 5));
        Detection box;
        box.score = std::clamp(row[4] * row[5 + best], 0.f, 1.f);
        box.label = names_[best];
        if (box.score < options_.score) continue;
        if (!names.empty() && std::find(names.begin(), names.end(), box.label) == names.end()) continue;
        const float half_width = std::exp(row[2]) * stride / 2, half_height = std::exp(row[3]) * stride / 2;
        const float centre_x = (row[0] + x) * stride, centre_y = (row[1] + y) * stride;
        box.x0 = (centre_x - half_width) / fitted.scale_x;
        box.x1 = (centre_x + half_width) / fitted.scale_x;
        box.y0 = (centre_y - half_height) / fitted.scale_y;
        box.y1 = (centre_y + half_height) / fitted.scale_y;
        if (clip_box(box, picture.width, picture.height)) boxes.push_back(std::move(box));
      }
    }
  }
  return suppress_overlaps(std::move(boxes), options_.overlap);
}

}  // namespace pliant
