#include "tests/segmentation/models/torch_modules.h"

#include <torch/script.h>

namespace pliant {

void write_torch_module(const std::filesystem::path& file, const std::string& methods, const std::string& description,
                        const std::vector<MadeTensor>& tensors) {
  torch::jit::Module module("MadeInATest");
  for (const MadeTensor& tensor : tensors)
    module.register_buffer(tensor.name, torch::tensor(tensor.values).reshape(tensor.shape));
  module.define(methods);
  torch::jit::ExtraFilesMap extra;
  if (!description.empty()) extra["pliant.json"] = description;
  module.save(file.string(), extra);
}

}  // namespace pliant
