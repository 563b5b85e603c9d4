#pragma once

#include <cmath>

#include "tests/segmentation/models/onnx_writer.h"

namespace pliant {

/// A YOLOX of 32 x 32 pixels and two classes whose cells are as much an object as they are red, of class 0 as they are
/// green and of class 1 as they are blue; every box is its cell.
inline std::string made_yolox() {
  OnnxWriter onnx;
  onnx.input("images", {1, 3, 32, 32});
  for (const int64_t stride : {8, 16, 32}) {
    const std::string s = std::to_string(stride);
    std::vector<float> kernel;
    for (int row = 0; row < 7; ++row)
      for (int blue_first = 0; blue_first < 3; ++blue_first)
        for (int64_t i = 0; i < stride * stride; ++i)
          kernel.push_back(row + blue_first == 6 ? 1.f / (255.f * static_cast<float>(stride * stride)) : 0.f);
    onnx.weights("kernel" + s, {7, 3, stride, stride}, kernel);
    onnx.weights("bias" + s, {7}, {0.5f, 0.5f, 0, 0, 0, 0, 0});
    onnx.integers("rows" + s, {1, 7, (32 / stride) * (32 / stride)});
    onnx.node("Conv", {"images", "kernel" + s, "bias" + s}, {"cells" + s},
              {{"kernel_shape", {stride, stride}}, {"strides", {stride, stride}}});
    onnx.node("Reshape", {"cells" + s, "rows" + s}, {"flat" + s});
  }
  onnx.node("Concat", {"flat8", "flat16", "flat32"}, {"columns"}, {{"axis", {2}, false}});
  onnx.node("Transpose", {"columns"}, {"output"}, {{"perm", {0, 2, 1}}});
  onnx.output("output", {1, 21, 7});
  return onnx.bytes(R"({"names": ["leaf", "sky"]})");
}

}  // namespace pliant
