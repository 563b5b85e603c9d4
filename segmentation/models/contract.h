#pragma once

#include <limits>
#include <map>
#include <string>
#include <vector>

#include "segmentation/models/onnx_graph.h"
#include "segmentation/models/tensor.h"

namespace pliant {

/// One line of a contract: what a tensor is called, how long it is along each axis, and what its values may be.
/// `shape` is written "1,3,H,W"; a letter is the same length wherever it stands, "4h" four times it, "K+1" one more,
/// "*" any.  Values lie in [low, high]; NaN never does.
struct TensorLine {
  std::string name;
  Tensor::Type type = Tensor::Type::kFloat32;
  std::string shape;
  double low = std::numeric_limits<float>::lowest(), high = std::numeric_limits<float>::max();
  std::string meaning = "";  ///< normalisation, order of channels
};

/// Signature of one method of a network.
struct Contract {
  std::string method = "forward";
  std::vector<TensorLine> inputs, outputs;
};

/// Lengths of the letters.
using Lengths = std::map<std::string, int64_t>;

/// "boxes: float32 [1,Q,4] in 0..1, centre and size as shares of the picture".
std::string describe(const TensorLine& line);

/// What is wrong with the type and shape of `tensor` by `line`, empty when nothing; letters met for the first time are
/// added to `lengths`.
std::string breach_of_shape(const TensorLine& line, const Tensor& tensor, Lengths& lengths);
/// What is wrong with its values.
std::string breach_of_range(const TensorLine& line, const Tensor& tensor);

/// The first line of `contract` that an ONNX graph breaks by what it says about itself, with what the graph has
/// instead; empty when none: every input and output is there by name, no other input is asked for, inputs are as long
/// as the lines say with these lengths of letters, outputs where a line has a number.
std::string breach_of_outline(const Contract& contract, const OnnxGraph& graph, Lengths lengths);

/// Inputs of these lengths with values spread evenly over their range (-1..1 where that is open), the same at each
/// call.
std::vector<Tensor> example_inputs(const Contract& contract, const Lengths& lengths);

}  // namespace pliant
