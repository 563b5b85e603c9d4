#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// A tensor that a graph takes or gives; -1 = a length that is not fixed.
struct GraphTensor {
  std::string name;
  std::vector<int64_t> shape;
};

/// What an ONNX file says about itself (onnx.proto3, message ModelProto).
struct OnnxGraph {
  std::vector<GraphTensor> inputs, outputs;  ///< inputs without the weights
  size_t nodes = 0;
  std::map<std::string, std::string> metadata;
};

/// "takes images [1,3,416,416] and gives output [1,3549,85]"; "?" for a length that is not fixed.
std::string outline_text(const OnnxGraph& graph);

/// Reads the outline of an ONNX file.  Throws Error{kInput} naming `file` where the bytes are not one.
OnnxGraph read_onnx_graph(std::string_view bytes, const std::string& file);

}  // namespace pliant
