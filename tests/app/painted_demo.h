#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "tests/app/run_pliant.h"
#include "tests/segmentation/models/onnx_writer.h"

namespace pliant {

constexpr uint32_t kRedThing = 3, kBlueThing = 4;  ///< ids of the demo's box and mug in its true masks

/// A small demo scene whose photos are black but for its box in red and its mug in blue.
inline void make_painted_demo(const std::filesystem::path& scene) {
  ASSERT_EQ(run_quietly({"demo", "--out", scene.string(), "--gaussians", "9000", "--photos", "12", "--width", "240",
                         "--height", "180", "--no-video"}),
            0);
  for (const auto& entry : std::filesystem::directory_iterator(scene / "masks")) {
    const IdImage ids = read_ids(entry.path());
    ImageF photo(ids.width, ids.height, 3);
    for (size_t i = 0; i < ids.data.size(); ++i) {
      photo.data[3 * i] = ids.data[i] == kRedThing;
      photo.data[3 * i + 2] = ids.data[i] == kBlueThing;
    }
    write_image(scene / "photos" / entry.path().filename(), photo);
  }
}

/// A YOLOX of 32 x 32 pixels that sees one "leaf" where the mean place of red is and one "sky" where that of blue is,
/// in boxes of `leaf` and `sky` of its pixels.
inline std::string centroid_yolox(float leaf, float sky) {
  OnnxWriter onnx;
  onnx.input("images", {1, 3, 32, 32});
  const auto thing = [&](const std::string& name, int blue_first, int class_row, float stride, float size) {
    std::vector<float> above(7 * 3 * 1024), below(7 * 3 * 1024);
    const auto sum = [&](std::vector<float>& kernel, int row, auto weight) {
      for (int y = 0; y < 24; ++y)  // the rest is padding
        for (int x = 0; x < 32; ++x)
          kernel[((row * 3 + blue_first) * 32 + y) * 32 + x] = weight(x + 0.5f, y + 0.5f) / (255.f * 768.f);
    };
    const auto one = [](float, float) { return 1.f; };
    sum(above, 0, [&](float x, float) { return x / stride; });
    sum(above, 1, [&](float, float y) { return y / stride; });
    sum(above, class_row, one);
    for (const int row : {0, 1, class_row}) sum(below, row, one);
    std::vector<float> above_bias = {0, 0, std::log(size / stride), std::log(size / stride), 1, 0, 0},
                       below_bias(7, 1.f);
    for (const int row : {0, 1, class_row}) below_bias[row] = 1e-5f;
    onnx.weights(name + "_a", {7, 3, 32, 32}, above);
    onnx.weights(name + "_ab", {7}, above_bias);
    onnx.weights(name + "_b", {7, 3, 32, 32}, below);
    onnx.weights(name + "_bb", {7}, below_bias);
    for (const char* part : {"_a", "_b"})
      onnx.node("Conv", {"images", name + part, name + part + "b"}, {name + part + "_out"},
                {{"kernel_shape", {32, 32}}, {"strides", {32, 32}}});
    onnx.node("Div", {name + "_a_out", name + "_b_out"}, {name + "_cell"});
    onnx.integers(name + "_rows", {1, 7, 1});
    onnx.node("Reshape", {name + "_cell", name + "_rows"}, {name});
  };
  thing("sky", 0, 6, 8, sky);
  thing("leaf", 2, 5, 32, leaf);  // the first cell of stride 8 and that of stride 32
  onnx.weights("nothing", {7 * 19, 3, 32, 32}, std::vector<float>(7 * 19 * 3 * 1024));
  onnx.weights("nothing_b", {7 * 19}, std::vector<float>(7 * 19));
  onnx.node("Conv", {"images", "nothing", "nothing_b"}, {"nothing_out"},
            {{"kernel_shape", {32, 32}}, {"strides", {32, 32}}});
  onnx.integers("nothing_rows", {1, 7, 19});
  onnx.node("Reshape", {"nothing_out", "nothing_rows"}, {"others"});
  onnx.node("Concat", {"sky", "others", "leaf"}, {"columns"}, {{"axis", {2}, false}});
  onnx.node("Transpose", {"columns"}, {"output"}, {{"perm", {0, 2, 1}}});
  onnx.output("output", {1, 21, 7});
  return onnx.bytes(R"({"names": ["leaf", "sky"]})");
}

/// Intersection over union of `id` in one picture with `true_id` in the other, summed over the pictures of `folder`.
inline double iou_in(const std::filesystem::path& folder, uint32_t id, const std::filesystem::path& truth,
                     uint32_t true_id) {
  size_t both = 0, either = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".png") continue;
    const IdImage found = read_ids(entry.path()), wanted = read_ids(truth / entry.path().filename());
    for (size_t i = 0; i < found.data.size(); ++i) {
      const bool a = found.data[i] == id, b = wanted.data[i] == true_id;
      both += a && b;
      either += a || b;
    }
  }
  return either ? static_cast<double>(both) / static_cast<double>(either) : 0;
}

/// Ids of objects.json by name.
inline std::multimap<std::string, uint32_t> objects_of(const std::filesystem::path& run) {
  std::multimap<std::string, uint32_t> objects;
  for (const nlohmann::json& object : nlohmann::json::parse(read_text(run / "objects.json")))
    objects.emplace(object.at("name"), object.at("id"));
  return objects;
}

}  // namespace pliant
