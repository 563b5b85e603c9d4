#include "segmentation/models/contract.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"
#include "gaussians/io/files/text.h"

namespace pliant {
namespace {

/// One axis of a contract line: factor * letter + plus, a plain number (no letter), or any length.
struct Axis {
  int64_t factor = 1, plus = 0;
  std::string letter;
  bool any = false;
};

std::vector<Axis> axes_of(const std::string& shape) {
  std::vector<Axis> axes;
  if (shape.empty()) return axes;
  for (const std::string& word : split(shape, ',')) {
    Axis axis;
    if (word == "*") axis.any = true;
    char* end = nullptr;
    const int64_t number = std::strtoll(word.c_str(), &end, 10);
    const bool numbered = end != word.c_str();
    axis.letter = end;
    if (const size_t plus = axis.letter.find('+'); plus != std::string::npos) {
      axis.plus = std::atoll(axis.letter.c_str() + plus + 1);
      axis.letter.resize(plus);
    }
    if (axis.letter.empty()) {
      axis.plus += number;
      axis.factor = 0;
    } else if (numbered)
      axis.factor = number;
    axes.push_back(axis);
  }
  return axes;
}

bool agrees(const Axis& axis, int64_t length, Lengths& lengths) {
  if (axis.any) return true;
  if (axis.letter.empty()) return length == axis.plus;
  if (const auto known = lengths.find(axis.letter); known != lengths.end())
    return length == axis.factor * known->second + axis.plus;
  const int64_t rest = length - axis.plus;
  if (rest < 0 || rest % axis.factor != 0) return false;
  lengths[axis.letter] = rest / axis.factor;
  return true;
}

bool open(double bound) { return std::abs(bound) >= std::numeric_limits<float>::max(); }

std::string number_text(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

}  // namespace

std::string describe(const TensorLine& line) {
  std::string text = line.name + ": " + name_of(line.type) + " [" + line.shape + "]";
  if (!open(line.low) && !open(line.high))
    text += " in " + number_text(line.low) + ".." + number_text(line.high);
  else if (line.type == Tensor::Type::kFloat32 && !std::isinf(line.low))
    text += ", finite";
  return line.meaning.empty() ? text : text + ", " + line.meaning;
}

std::string breach_of_shape(const TensorLine& line, const Tensor& tensor, Lengths& lengths) {
  const std::vector<Axis> axes = axes_of(line.shape);
  bool fits = tensor.shape.size() == axes.size() && tensor.type == line.type;
  for (size_t i = 0; fits && i < axes.size(); ++i) fits = agrees(axes[i], tensor.shape[i], lengths);
  return fits ? "" : std::string("is ") + name_of(tensor.type) + " " + shape_text(tensor.shape);
}

std::string breach_of_range(const TensorLine& line, const Tensor& tensor) {
  size_t outside = 0;
  double worst = 0;
  const auto look = [&](double value) {
    if (value >= line.low && value <= line.high) return;
    if (outside++ == 0) worst = value;
  };
  for (const float value : tensor.values) look(value);
  if (tensor.type == Tensor::Type::kInt64)
    for (const int64_t value : tensor.integers) look(static_cast<double>(value));
  if (outside > 0)
    return "holds " + std::to_string(outside) + " values out of range, the first is " + number_text(worst);
  return "";
}

std::string breach_of_outline(const Contract& contract, const OnnxGraph& graph, Lengths lengths) {
  const auto named = [](const auto& all, const std::string& name) {
    return std::find_if(all.begin(), all.end(), [&](const auto& one) { return one.name == name; });
  };
  const std::string file = "; the file " + outline_text(graph);
  const auto missing = [&](const std::string& kind, const std::vector<TensorLine>& lines,
                           const std::vector<GraphTensor>& tensors) -> std::string {
    for (const TensorLine& line : lines)
      if (named(tensors, line.name) == tensors.end())
        return "has no " + kind + " '" + line.name + "'; the contract says " + describe(line) + file;
    return "";
  };
  if (const std::string wrong = missing("input", contract.inputs, graph.inputs); !wrong.empty()) return wrong;
  if (const std::string wrong = missing("output", contract.outputs, graph.outputs); !wrong.empty()) return wrong;
  for (const GraphTensor& input : graph.inputs)
    if (named(contract.inputs, input.name) == contract.inputs.end())
      return "expects the input '" + input.name + "', which the contract does not have" + file;

  std::string letters;
  for (const auto& [letter, length] : lengths) letters += ", " + letter + " = " + std::to_string(length);
  for (const bool out : {false, true}) {
    for (const TensorLine& line : out ? contract.outputs : contract.inputs) {
      const std::vector<int64_t>& shape = named(out ? graph.outputs : graph.inputs, line.name)->shape;
      if (shape.empty()) continue;  // not said
      const std::vector<Axis> axes = axes_of(line.shape);
      bool fits = shape.size() == axes.size();
      for (size_t i = 0; fits && i < axes.size(); ++i) {
        Lengths any;  // lengths of outputs are often those of the picture that a network was traced with
        fits = shape[i] < 0 || agrees(axes[i], shape[i], out ? any : lengths);
      }
      if (!fits)
        return "has " + std::string(out ? "an output" : "an input") + " '" + line.name +
               "' of other dimensions; the contract says " + describe(line) + letters + file;
    }
  }
  return "";
}

std::vector<Tensor> example_inputs(const Contract& contract, const Lengths& lengths) {
  std::vector<Tensor> inputs;
  for (const TensorLine& line : contract.inputs) {
    Tensor tensor;
    tensor.type = line.type;
    for (const Axis& axis : axes_of(line.shape)) {
      CHECK_MSG(axis.letter.empty() || lengths.count(axis.letter), line.name + " has no length " + axis.letter);
      tensor.shape.push_back(axis.any              ? 1
                             : axis.letter.empty() ? axis.plus
                                                   : axis.factor * lengths.at(axis.letter) + axis.plus);
    }
    const double low = open(line.low) ? -1 : line.low, high = open(line.high) ? 1 : line.high;
    const int64_t count = tensor.count();
    for (int64_t i = 0; i < count; ++i) {
      Random random(inputs.size(), static_cast<uint64_t>(i), 0);
      const double value = low + (high - low) * random.uniform();
      if (line.type == Tensor::Type::kFloat32)
        tensor.values.push_back(static_cast<float>(value));
      else if (line.type == Tensor::Type::kBool)
        tensor.integers.push_back(1);
      else
        tensor.integers.push_back(std::llround(value));
    }
    inputs.push_back(std::move(tensor));
  }
  return inputs;
}

}  // namespace pliant
