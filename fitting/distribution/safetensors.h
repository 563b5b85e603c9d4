#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// Named arrays of floats, as the safetensors format keeps them (Hugging Face, 2022: length of the header, a JSON
/// header, the bytes).
struct SafeTensors {
  struct Array {
    std::vector<int64_t> shape;
    std::vector<float> values;
  };
  std::map<std::string, Array> arrays;
  std::map<std::string, std::string> metadata;

  /// Throws Error{kInput} naming `file` where the array is missing or of another shape.
  const std::vector<float>& values(const std::string& name, const std::vector<int64_t>& shape,
                                   const std::string& file) const;
  /// Throws Error{kInput} naming `file` where it is missing.
  const std::string& text(const std::string& name, const std::string& file) const;
};

/// Arrays of type F32.  Throws Error{kInput} naming `file` and the field for what is truncated, overlapping, of another
/// type or no such file at all.
SafeTensors parse_safetensors(std::string_view bytes, const std::string& file);
SafeTensors read_safetensors(const std::filesystem::path& file);
void write_safetensors(const std::filesystem::path& file, const SafeTensors& content);  ///< atomic

}  // namespace pliant
