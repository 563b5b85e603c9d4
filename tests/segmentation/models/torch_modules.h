#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "segmentation/models/neural_module.h"

namespace pliant {

/// A constant of a module made in a test: self.NAME, filled with values along `shape`.
struct MadeTensor {
  std::string name;
  std::vector<int64_t> shape;
  std::vector<float> values;
};

/// Options for modules that were made here.
inline ModuleOptions trusted() {
  ModuleOptions options;
  options.trust_torchscript = true;
  options.load_seconds = 60;
  return options;
}

/// Saves a TorchScript module with these methods ("def forward(self, x): ..."), tensors and description.
void write_torch_module(const std::filesystem::path& file, const std::string& methods,
                        const std::string& description = "", const std::vector<MadeTensor>& tensors = {});

/// Replaces a piece of the source code inside a saved module, so that it holds what the libtorch at hand cannot
/// compile.
void replace_in_code(const std::filesystem::path& file, const std::string& piece, const std::string& other);

}  // namespace pliant
