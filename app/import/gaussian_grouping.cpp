#include "app/import/gaussian_grouping.h"

#include <algorithm>
#include <cmath>

#include "app/import/state_dict.h"
#include "gaussians/base/error.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {
namespace fs = std::filesystem;

fs::path grouping_classifier_file(const fs::path& source) {
  if (fs::is_regular_file(source)) return source;
  if (!fs::is_directory(source))
    throw input_error(source.string(), "", "does not exist", "give the folder of a Gaussian Grouping model");
  for (const fs::path& folder : {source, splats_of_folder(source).parent_path()})
    if (!folder.empty() && fs::is_regular_file(folder / "classifier.pth")) return folder / "classifier.pth";
  throw input_error(source.string(), "classifier.pth", "is neither in this folder nor next to its splats",
                    "give the folder point_cloud/iteration_N of a Gaussian Grouping model");
}

GroupingClassifier read_grouping_classifier(const fs::path& file) {
  const auto tensors = read_state_dict(file);
  const auto weight = tensors.find("weight"), bias = tensors.find("bias");
  const char* remedy =
      "give the classifier.pth of Gaussian Grouping: a state dict with weight [C, 16, 1, 1] and bias [C]";
  if (weight == tensors.end() || bias == tensors.end()) {
    std::string names;
    for (const auto& [name, tensor] : tensors) names += (names.empty() ? "" : ", ") + name;
    throw input_error(file.string(), weight == tensors.end() ? "weight" : "bias",
                      "is missing; the file has " + (names.empty() ? "no tensor" : names), remedy);
  }
  const std::vector<int64_t>& shape = weight->second.shape;
  const bool is_linear =
      (shape.size() == 2 || (shape.size() == 4 && shape[2] == 1 && shape[3] == 1)) && shape[0] > 0 && shape[1] > 0;
  if (!is_linear || bias->second.shape != std::vector<int64_t>{shape[0]})
    throw input_error(file.string(), "weight", "is not a 1 x 1 convolution with as many biases as classes", remedy);
  for (const auto* values : {&weight->second.data, &bias->second.data})
    if (!std::all_of(values->begin(), values->end(), [](float v) { return std::isfinite(v); }))
      throw input_error(file.string(), "weight", "holds values that are not finite", "train the model again");
  return {static_cast<int>(shape[0]), static_cast<int>(shape[1]), weight->second.data, bias->second.data};
}

}  // namespace pliant
