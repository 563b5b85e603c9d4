// A trained Gaussian Grouping model becomes the segmentation of its scene; clicks on the contact sheet.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/run/attach_scene.h"
#include "app/segment/extract_stage.h"
#include "app/store/segmentation.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/scene/scene.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/run_pliant.h"
#include "tests/app/torch_files.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using nlohmann::json;

/// A PLY as Gaussian Grouping writes it, with obj_dc_0 to obj_dc_15: two rows of 40 Gaussians, 1 and 3 above the
/// ground. The attribute of row r is the r-th unit vector, but for one Gaussian of the first row, which lies between.
std::string grouping_ply() {
  std::string out = "ply\nformat binary_little_endian 1.0\nelement vertex 80\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0",
                           "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    out += std::string("property float ") + name + "\n";
  for (int k = 0; k < 16; ++k) out += "property float obj_dc_" + std::to_string(k) + "\n";
  out += "end_header\n";
  for (int i = 0; i < 80; ++i) {
    const int row = i / 40;
    std::vector<float> v = {0.05f * static_cast<float>(i % 40),
                            0,
                            row ? 3.0f : 1.0f,
                            0,
                            0,
                            0,
                            0.5f,
                            0.1f,
                            -0.4f,
                            3,
                            -3,
                            -3,
                            -3,
                            1,
                            0,
                            0,
                            0};
    std::vector<float> y(16, 0.0f);
    y[row] = 1;
    if (i == 7) {
      y[0] = 0.6f;
      y[1] = 0.4f;
    }
    v.insert(v.end(), y.begin(), y.end());
    out += floats(v);
  }
  return out;
}

/// 256 classes as the released code has: 9 for the first row, 0 (background) for the second, the others never.
std::string grouping_classifier(int channels = 16) {
  std::vector<float> weight(256 * static_cast<size_t>(channels), 0.0f), bias(256, -5.0f);
  weight[9 * static_cast<size_t>(channels) + 0] = 10;
  weight[1] = 10;
  bias[9] = bias[0] = 0;
  return torch_archive("classifier", conv_pickle(256, channels), {floats(weight), floats(bias)});
}

TEST(GaussianGrouping, AttributeAndClassifierAreTakenAsTheyAre) {
  const TemporaryFolder folder;
  const std::string model = (folder / "model").string(), out = (folder / "run").string();
  folder.file("model/point_cloud/iteration_30000/point_cloud.ply", grouping_ply());
  folder.file("model/point_cloud/iteration_30000/classifier.pth", grouping_classifier());
  const std::vector<std::string> command = {"segment", model,           "--out", out, "--gaussian-grouping",
                                            model,     "--orbit-views", "4"};
  ASSERT_EQ(run_quietly(command), 0);
  const Segmentation s = read_segmentation(folder / "run/segmentation.h5");
  EXPECT_EQ(s.class_id, (std::vector<uint32_t>{0, 9}));
  EXPECT_EQ(s.class_name, (std::vector<std::string>{"background", "object_9"}));
  EXPECT_EQ(s.next_id, 256u);
  ASSERT_EQ(s.label.size(), 80u);
  for (int i = 0; i < 80; ++i) {
    EXPECT_EQ(s.label[i], i < 40 ? 9u : 0u) << i;
    EXPECT_EQ(s.attribute[i * 16], i >= 40 ? 0.0f : i == 7 ? 0.6f : 1.0f);
    EXPECT_NEAR(s.confidence[i], 1 / (1 + std::exp(i == 7 ? -2.0 : -10.0)), 1e-5) << i;
  }
  const json objects = read_json(folder / "run/objects.json");
  EXPECT_EQ(objects[1]["found"], "Gaussian Grouping");
  EXPECT_EQ(objects[1]["views"], 4);

  // A scene file may name an object that the model does not have.
  folder.file("scene/scene.json",
              R"({"splats": "../model/point_cloud/iteration_30000/point_cloud.ply", "object": "flower"})");
  ASSERT_EQ(run_quietly({"segment", (folder / "scene").string(), "--out", (folder / "named").string(),
                         "--gaussian-grouping", model, "--orbit-views", "4"}),
            0);
  const RunDirectory named = RunDirectory::open(folder / "named");
  EXPECT_EQ(inputs_of(named, load_run_scene(named), ExtractStage()).found["name"], "object_9");

  // Nothing is done again; another classifier is another input.
  const std::string before = sha256_of_file(folder / "run/segmentation.h5");
  ASSERT_EQ(run_quietly(command), 0);
  EXPECT_EQ(sha256_of_file(folder / "run/segmentation.h5"), before);
  folder.file("model/point_cloud/iteration_30000/classifier.pth", grouping_classifier(15));
  EXPECT_EQ(run_quietly(command), 1);  // 15 channels
  EXPECT_EQ(run_quietly({"segment", model, "--out", (folder / "other").string(), "--gaussian-grouping",
                         folder.path().string()}),
            1);
}

TEST(SheetPrompts, AClickOnTheSheetIsOneOnThePictureItShowsAndStaysItWhenRepeated) {
  const TemporaryFolder folder;
  const std::string scene = (folder / "scene").string(), out = (folder / "run").string();
  ASSERT_EQ(run_quietly({"demo", "--out", scene, "--gaussians", "6000", "--photos", "8", "--width", "120", "--height",
                         "90", "--no-video"}),
            0);
  EXPECT_EQ(run_quietly({"segment", scene, "--out", out, "--click", "sheet,5,5"}), 2);  // no sheet yet
  ASSERT_EQ(run_quietly({"segment", scene, "--out", out, "--iterations", "10"}), 0);
  const json cells = read_json(folder / "run/objects_sheet.json"), objects = read_json(folder / "run/objects.json");
  ASSERT_EQ(cells.size(), objects.size() + 1);

  // The middle of the crop of the flower pot's object: where its picture is.
  size_t at = 0;
  while (objects[at]["name"] != "pot" && objects[at]["name"] != "flower" && at + 1 < objects.size()) ++at;
  const json& cell = cells[at + 1];
  const double x = cell["x"].get<double>() + 90, y = cell["y"].get<double>() + 90;
  const std::string click = "sheet," + std::to_string(static_cast<int>(x)) + "," + std::to_string(static_cast<int>(y));
  const std::vector<std::string> command = {"segment", scene, "--out", out, "--click", click};
  ASSERT_EQ(run_quietly(command), 0);
  const json manifest = read_json(folder / "run/run.json");
  const std::string resolved = manifest["stages"]["segment"]["options"]["click"][0];
  EXPECT_EQ(resolved.substr(0, resolved.find(',')), cell["camera"].get<std::string>());
  EXPECT_EQ(manifest["sheet_prompts"]["click " + click], resolved);

  // objects.png is another one now, yet the command means what it meant.
  const std::string before = sha256_of_file(folder / "run/segmentation.h5");
  ASSERT_EQ(run_quietly(command), 0);
  EXPECT_EQ(sha256_of_file(folder / "run/segmentation.h5"), before);
  EXPECT_EQ(run_quietly({"segment", scene, "--out", out, "--click", "sheet,0,0"}),
            2);  // a gap of the sheet
  EXPECT_EQ(run_quietly({"segment", scene, "--out", out, "--click", "sheet,a,0"}), 2);
}

}  // namespace
}  // namespace pliant
