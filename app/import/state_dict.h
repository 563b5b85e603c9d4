#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace pliant {

/// A tensor of a PyTorch state dict, row-major; every floating-point type is read as float.
struct StateTensor {
  std::vector<int64_t> shape;
  std::vector<float> data;
};

/// Reads the tensors of a state dict that torch.save wrote (PyTorch 1.6 or later: a zip archive with a pickle).  The
/// pickle is interpreted here and runs nothing: of the classes that it may name only OrderedDict, the tensor rebuilders
/// and the storage types are known, everything else is refused by name.  Counts and strides are compared with the
/// stored bytes before anything is allocated.  Throws Error{kInput} naming file and field; files in PyTorch's older
/// formats and TorchScript modules are named as such.
std::map<std::string, StateTensor> read_state_dict(const std::filesystem::path& file);

}  // namespace pliant
