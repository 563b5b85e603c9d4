#pragma once

#include <filesystem>
#include <vector>

namespace pliant {

/// The linear classifier of a Gaussian Grouping model (Ye et al. 2024): a 1 x 1 convolution from the blended attribute
/// `obj_dc` to classes 0, 1, ...; class 0 is what its masks leave unlabelled, which it learns like the others.
struct GroupingClassifier {
  int classes = 0, channels = 0;
  std::vector<float> weight;  ///< [classes, channels]
  std::vector<float> bias;    ///< [classes]
};

/// `source` itself when it is a file, else classifier.pth in that folder or beside the splats of a model folder. Throws
/// Error{kInput} when there is none.
std::filesystem::path grouping_classifier_file(const std::filesystem::path& source);

/// Reads classifier.pth (see read_state_dict).  Throws Error{kInput} when its tensors are not such a classifier.
GroupingClassifier read_grouping_classifier(const std::filesystem::path& file);

}  // namespace pliant
