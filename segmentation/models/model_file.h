#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "segmentation/models/onnx_graph.h"

namespace pliant {

/// What can be known of a model file without running anything in it.
struct ModelFile {
  enum class Format { kOnnx, kTorchScript };

  std::filesystem::path file;
  Format format = Format::kOnnx;
  std::string sha256;
  /// What the export scripts write beside the weights: a JSON object with "kind" ("sam-encoder", ...) and the sizes
  /// that the network was exported for; the text "{}" where there is none.  In ONNX the metadata entry "pliant", in
  /// TorchScript the extra file "pliant.json".
  std::string description = "{}";
  OnnxGraph graph;  ///< of ONNX

  /// The description, parsed.
  nlohmann::json about() const;
  /// "kind" of the description, empty where there is none.
  std::string kind() const;
  /// A length of the description between 1 and 4096, or `otherwise` where it is not given.
  int size_of(const std::string& key, int otherwise) const;
};

/// Reads the outline of an ONNX or TorchScript file.  Throws Error{kInput} for anything else, naming what it is.
ModelFile read_model_file(const std::filesystem::path& file);

}  // namespace pliant
