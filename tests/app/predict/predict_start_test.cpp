// What of the words and of an earlier object `predict`, `simulate` and `run` do not take up.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/predict/prepare_object.h"
#include "app/run/attach_scene.h"
#include "app/store/trajectory.h"
#include "tests/app/predict/predict_case.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

TEST_F(Predict, RunRefusesContradictionsAndUnknownWordsBeforeAnyWork) {
  const std::vector<std::vector<std::string>> refused = {{"--label", "xyzzy"},
                                                         {"--predict.material", "unobtainium"},
                                                         {"--label", "palm", "--predict.material", "oak"},
                                                         {"--young", "1e5", "--softness", "0.3"},
                                                         {"--predict.llm-url", "http://127.0.0.1:9"}};
  for (const std::vector<std::string>& words : refused) {
    EXPECT_EQ(run(words), static_cast<int>(Failure::kUsage)) << words[0] << " " << words[1];
    EXPECT_FALSE(fs::exists(folder_ / "run/segmentation.h5")) << words[0] << " " << words[1];
  }
}

TEST(StartFromPrediction, IsTheEOfTheSceneFileUnlessAPredictionIsAskedFor) {
  Scene scene;
  scene.settings.material.young = 2e4;
  scene.settings.material.poisson = 0.2;
  const json prediction = {{"young", 5e5}, {"poisson", 0.4}, {"density", 700}};
  const auto start = [&](const PredictStage& asked, const MaterialValues& typed = {}) {
    MaterialValues material = typed;
    start_from_prediction(prediction, scene, asked, material);
    EXPECT_EQ(material.poisson, asked.label.empty() ? std::nullopt : std::optional(0.4)) << "else the scene file's";
    EXPECT_EQ(material.density, 700);
    return material.young;
  };
  EXPECT_EQ(start({}), std::nullopt);
  PredictStage label, softness;
  label.label = "rose";
  softness.softness = 0.5;
  EXPECT_EQ(start(label), 5e5);
  EXPECT_EQ(start(softness), 5e5);
  MaterialValues typed;
  typed.young = 3e4;
  EXPECT_EQ(start(label, typed), 3e4);
  scene.settings.material.young.reset();
  EXPECT_EQ(start({}), 5e5);
}

TEST_F(Predict, WhatWasPredictedOfAnObjectIsNotThatOfAnother) {
  ASSERT_EQ(run({"--label", "sunflower"}), 0);
  const std::string directory = (folder_ / "run").string();
  const auto scale = [&] { return load_run_scene(RunDirectory::open(directory)).metres_per_unit; };
  const double of_sunflower = scale();
  ASSERT_GT(std::abs(of_sunflower - 1), 0.1);
  // Another object of the same shape, extracted and seeded.
  const auto extract = [&](const std::string& name) {
    json record = read_json(folder_ / "run/run.json");
    json& summary = record["stages"]["extract"]["summary"];
    summary["name"] = name.substr(2);
    summary["folder"] = "objects/" + name;
    write_text(folder_ / "run/run.json", record.dump());
  };
  fs::create_directories(folder_ / "run/objects/2_vase");
  for (const char* file : {"object.ply", "solid.h5", "particles.h5", "predicted.h5"})
    fs::copy(folder_ / "run/objects/1_object" / file, folder_ / "run/objects/2_vase" / file);
  extract("2_vase");
  EXPECT_EQ(scale(), 1);
  EXPECT_FALSE(predicts_object(RunDirectory::open(directory)));

  std::vector<std::string> simulate = {"simulate", directory, "--fps", "20", "--duration", "0.1"};
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_pliant(simulate), static_cast<int>(Failure::kUsage));
  const std::string said = testing::internal::GetCapturedStderr();
  for (const char* word : {"another object", "pliant predict"}) EXPECT_NE(said.find(word), std::string::npos) << said;
  // Beside an E of the user nothing else is known.
  simulate.insert(simulate.end(), {"--young", "1e5"});
  EXPECT_EQ(run_quietly(simulate), static_cast<int>(Failure::kUsage));
  simulate.insert(simulate.end(), {"--poisson", "0.3", "--density", "500"});
  ASSERT_EQ(run_quietly(simulate), 0);
  EXPECT_EQ(read_trajectory(folder_ / "run/objects/2_vase/trajectory.h5").metres_per_unit, 1);

  extract("1_object");
  EXPECT_EQ(scale(), of_sunflower);
  EXPECT_TRUE(predicts_object(RunDirectory::open(directory)));
  EXPECT_EQ(run_quietly({"simulate", directory, "--fps", "20", "--duration", "0.1"}), 0);
}

}  // namespace
}  // namespace pliant
