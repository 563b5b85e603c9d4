#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace pliant {

/// Writes small ONNX files (onnx.proto3), enough for stand-ins of networks.
class OnnxWriter {
 public:
  struct Attribute {
    std::string name;
    std::vector<int64_t> ints;
    bool list = true;  // else one number
  };

  void input(const std::string& name, const std::vector<int64_t>& shape) { text(graph_, 11, value_info(name, shape)); }
  void output(const std::string& name, const std::vector<int64_t>& shape) { text(graph_, 12, value_info(name, shape)); }

  void node(const std::string& kind, const std::vector<std::string>& inputs, const std::vector<std::string>& outputs,
            const std::vector<Attribute>& attributes = {}) {
    std::string node;
    for (const std::string& name : inputs) text(node, 1, name);
    for (const std::string& name : outputs) text(node, 2, name);
    text(node, 3, "node_" + outputs[0]);
    text(node, 4, kind);
    for (const Attribute& attribute : attributes) {
      std::string entry;
      text(entry, 1, attribute.name);
      for (const int64_t value : attribute.ints) number(entry, attribute.list ? 8 : 3, static_cast<uint64_t>(value));
      number(entry, 20, attribute.list ? 7 : 2);
      text(node, 5, entry);
    }
    text(graph_, 1, node);
  }

  void weights(const std::string& name, const std::vector<int64_t>& shape, const std::vector<float>& values) {
    tensor(name, shape, 1, std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)));
  }
  void integers(const std::string& name, const std::vector<int64_t>& values) {
    tensor(name, {static_cast<int64_t>(values.size())}, 7,
           std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(int64_t)));
  }

  /// The file; `description` becomes the metadata entry "pliant".
  std::string bytes(const std::string& description = "") const {
    std::string model, opset, graph = graph_;
    text(graph, 2, "made");
    number(opset, 2, 11);
    number(model, 1, 7);
    text(model, 8, opset);
    text(model, 7, graph);
    if (!description.empty()) {
      std::string entry;
      text(entry, 1, "pliant");
      text(entry, 2, description);
      text(model, 14, entry);
    }
    return model;
  }

 private:
  static void varint(std::string& out, uint64_t value) {
    for (; value > 127; value >>= 7) out += static_cast<char>((value & 127) | 128);
    out += static_cast<char>(value);
  }
  static void number(std::string& out, uint64_t field, uint64_t value) {
    varint(out, field << 3);
    varint(out, value);
  }
  static void text(std::string& out, uint64_t field, const std::string& value) {
    varint(out, field << 3 | 2);
    varint(out, value.size());
    out += value;
  }

  void tensor(const std::string& name, const std::vector<int64_t>& shape, uint64_t type, const std::string& raw) {
    std::string entry;
    for (const int64_t length : shape) number(entry, 1, static_cast<uint64_t>(length));
    number(entry, 2, type);
    text(entry, 8, name);
    text(entry, 9, raw);
    text(graph_, 5, entry);
  }

  static std::string value_info(const std::string& name, const std::vector<int64_t>& shape) {
    std::string axes, tensor_type, type, info;
    for (const int64_t length : shape) {
      std::string axis;
      number(axis, 1, static_cast<uint64_t>(length));
      text(axes, 1, axis);
    }
    number(tensor_type, 1, 1);
    text(tensor_type, 2, axes);
    text(type, 1, tensor_type);
    text(info, 1, name);
    text(info, 2, type);
    return info;
  }

  std::string graph_;
};

}  // namespace pliant
