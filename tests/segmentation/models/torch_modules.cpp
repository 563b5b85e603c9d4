#include "tests/segmentation/models/torch_modules.h"

#include <caffe2/serialize/inline_container.h>
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

void replace_in_code(const std::filesystem::path& file, const std::string& piece, const std::string& other) {
  const std::filesystem::path whole = file.string() + ".whole";
  std::filesystem::rename(file, whole);
  caffe2::serialize::PyTorchStreamReader in(whole.string());
  caffe2::serialize::PyTorchStreamWriter out(file.string());
  for (const std::string& record : in.getAllRecords()) {
    if (record == "version" || record.ends_with(".debug_pkl"))
      continue;  // the writer adds the one, the other is of the old code
    const auto [data, size] = in.getRecord(record);
    std::string bytes(static_cast<const char*>(data.get()), size);
    if (record.ends_with(".py"))
      for (size_t at = bytes.find(piece); at != std::string::npos; at = bytes.find(piece, at + other.size()))
        bytes.replace(at, piece.size(), other);
    out.writeRecord(record, bytes.data(), bytes.size());
  }
  out.writeEndOfFile();
}

}  // namespace pliant
