#include "segmentation/models/onnx_graph.h"

#include <algorithm>
#include <set>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

/// One field of a protocol-buffers message (encoding: developers.google.com/protocol-buffers/docs/encoding).
struct Field {
  uint64_t number = 0, value = 0;  // value of numbers
  std::string_view bytes;          // of texts and messages
};

/// Walks over the fields of a message.
class Fields {
 public:
  Fields(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  bool next(Field& field) {
    if (at_ >= bytes_.size()) return false;
    const uint64_t key = varint();
    field = {key >> 3, 0, {}};
    switch (key & 7) {
      case 0:
        field.value = varint();
        break;
      case 1:
        skip(8);
        break;
      case 2: {
        const uint64_t length = varint();
        const size_t begin = at_;
        skip(length);
        field.bytes = bytes_.substr(begin, length);
        break;
      }
      case 5:
        skip(4);
        break;
      default:
        broken();
    }
    if (field.number == 0) broken();
    return true;
  }

 private:
  uint64_t varint() {
    uint64_t value = 0;
    for (int shift = 0; shift < 70; shift += 7) {
      if (at_ >= bytes_.size()) broken();
      const auto byte = static_cast<uint8_t>(bytes_[at_++]);
      value |= static_cast<uint64_t>(byte & 127) << std::min(shift, 63);
      if (byte < 128) return value;
    }
    broken();
  }

  void skip(uint64_t count) {
    if (count > bytes_.size() - at_) broken();
    at_ += count;
  }

  [[noreturn]] void broken() const {
    throw input_error(file_, "",
                      "is not ONNX, or is truncated (byte " + std::to_string(at_) + " of a part of " +
                          std::to_string(bytes_.size()) + ")",
                      "give a complete ONNX or TorchScript file");
  }

  std::string_view bytes_;
  const std::string& file_;
  size_t at_ = 0;
};

/// ValueInfoProto: name 1, type 2 {tensor_type 1 {shape 2 {dim 1 {dim_value 1}}}}.
GraphTensor tensor_info(std::string_view bytes, const std::string& file) {
  GraphTensor tensor;
  Field field;
  const auto each = [&](std::string_view message, uint64_t number, auto&& visit) {
    Field inner;
    for (Fields fields(message, file); fields.next(inner);)
      if (inner.number == number) visit(inner);
  };
  for (Fields fields(bytes, file); fields.next(field);) {
    if (field.number == 1) tensor.name = field.bytes;
    if (field.number != 2) continue;
    each(field.bytes, 1, [&](const Field& type) {
      each(type.bytes, 2, [&](const Field& shape) {
        each(shape.bytes, 1, [&](const Field& axis) {
          int64_t length = -1;
          each(axis.bytes, 1, [&](const Field& value) { length = static_cast<int64_t>(value.value); });
          tensor.shape.push_back(length);
        });
      });
    });
  }
  return tensor;
}

std::string list_text(const std::vector<GraphTensor>& tensors) {
  std::string text;
  for (const GraphTensor& tensor : tensors) {
    text += (text.empty() ? "" : ", ") + tensor.name + " [";
    for (size_t axis = 0; axis < tensor.shape.size(); ++axis)
      text += (axis ? "," : "") + (tensor.shape[axis] < 0 ? std::string("?") : std::to_string(tensor.shape[axis]));
    text += "]";
  }
  return text.empty() ? "nothing" : text;
}

}  // namespace

std::string outline_text(const OnnxGraph& graph) {
  return "takes " + list_text(graph.inputs) + " and gives " + list_text(graph.outputs);
}

OnnxGraph read_onnx_graph(std::string_view bytes, const std::string& file) {
  OnnxGraph graph;
  Field field;
  std::set<std::string> weights;
  for (Fields model(bytes, file); model.next(field);) {
    if (field.number == 14) {  // metadata_props: key 1, value 2
      std::string key, value;
      Field entry;
      for (Fields pair(field.bytes, file); pair.next(entry);) (entry.number == 1 ? key : value) = entry.bytes;
      graph.metadata[key] = value;
    }
    if (field.number != 7) continue;
    Field part;
    for (Fields parts(field.bytes, file); parts.next(part);) {
      if (part.number == 1) ++graph.nodes;
      if (part.number == 11) graph.inputs.push_back(tensor_info(part.bytes, file));
      if (part.number == 12) graph.outputs.push_back(tensor_info(part.bytes, file));
      if (part.number != 5) continue;
      Field entry;
      for (Fields weight(part.bytes, file); weight.next(entry);)
        if (entry.number == 8) weights.insert(std::string(entry.bytes));
    }
  }
  std::erase_if(graph.inputs, [&](const GraphTensor& input) { return weights.count(input.name) > 0; });
  if (graph.nodes == 0 || graph.outputs.empty())
    throw input_error(file, "", "is neither ONNX nor TorchScript",
                      "export the model with a script of segmentation/models/export");
  return graph;
}

}  // namespace pliant
