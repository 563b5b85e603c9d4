#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "segmentation/labels/segmentation.h"

namespace pliant {

/// segmentation.h5: attribute [N, 16], classifier [C, 16], classifier_bias [C], class_id [C], label [N],
/// confidence [N], seen [N], where known class_cameras with class_cameras_end [C]; names, origins and provenance as
/// JSON attributes of the root, next_id and screen_variance as numbers.
void write_segmentation(const std::filesystem::path& file, const Segmentation& segmentation,
                        const std::string& provenance_json);
Segmentation read_segmentation(const std::filesystem::path& file);

/// Labels of Gaussians only: what true labels of a synthetic scene have.
struct LabelFile {
  std::vector<uint32_t> label;            ///< [N]
  std::map<uint32_t, std::string> names;  ///< of the ids
};
void write_labels(const std::filesystem::path& file, const LabelFile& labels, const std::string& provenance_json);
/// Reads labels of either kind of file.
LabelFile read_labels(const std::filesystem::path& file);

}  // namespace pliant
