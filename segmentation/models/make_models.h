#pragma once

#include <filesystem>
#include <memory>

#include "segmentation/model_interfaces/detector.h"
#include "segmentation/models/neural_module.h"

namespace pliant {

/// The detector in `file`: YOLOX is recognised by its outline, others by what their export script wrote.  Throws
/// Error{kInput} naming what the file is instead.
std::unique_ptr<Detector> make_detector(const std::filesystem::path& file, ModuleOptions options);

}  // namespace pliant
