// `predict` after a prediction: what of the earlier one stays, and when `simulate` refuses it.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/predict/object_prior.h"
#include "tests/app/predict/predict_case.h"

namespace pliant {
namespace {

using nlohmann::json;

class PredictAgain : public Predict {
 protected:
  int predict(std::vector<std::string> words) const {
    words.insert(words.begin(), {"predict", directory()});
    return run_quietly(words);
  }
  std::vector<std::string> simulate(std::vector<std::string> words = {}) const {
    words.insert(words.begin(), {"simulate", directory(), "--fps", "20", "--duration", "0.1"});
    return words;
  }
  std::string directory() const { return (folder_ / "run").string(); }
  json record() const { return read_json(folder_ / "run/run.json"); }
  void write_material_of_scene(const json& material) const {
    json scene = read_json(folder_ / "scene/scene.json");
    scene["material"] = material;
    write_text(folder_ / "scene/scene.json", scene.dump());
  }
  /// `simulate` with these words ends as a usage error that says what changed and what to do.
  void expect_refused(const std::vector<std::string>& words, const char* changed) const {
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_pliant(simulate(words)), static_cast<int>(Failure::kUsage));
    const std::string said = testing::internal::GetCapturedStderr();
    for (const char* word : {"scene.json", changed, "`pliant predict`"})
      EXPECT_NE(said.find(word), std::string::npos) << word << " in: " << said;
  }
};

TEST_F(PredictAgain, OneThatFailsLeavesTheEarlierPredictionAndItsHeight) {
  ASSERT_EQ(run({"--label", "sunflower"}), 0);
  const json before = record();
  ASSERT_TRUE(before["assumed_height"].is_object());
  const std::string no_network = (folder_ / "run/run.json").string();
  EXPECT_EQ(predict({"--label", "rose", "--weights", no_network}), 1);
  EXPECT_EQ(predict({"--label", "zorbulon", "--llm-url", "http://127.0.0.1:9/v1", "--llm-model", "m"}), 2);
  EXPECT_EQ(record()["assumed_height"], before["assumed_height"]);
  EXPECT_EQ(record()["stages"]["predict"], before["stages"]["predict"]);
  EXPECT_EQ(run_quietly(simulate()), 0);
}

TEST_F(PredictAgain, WithoutALabelItKeepsWhatTheObjectWasTakenFor) {
  ASSERT_EQ(run({"--label", "sunflower"}), 0);
  const json before = summary("predict"), height = record()["assumed_height"];
  ASSERT_EQ(predict({"--poisson", "0.4"}), 0);
  EXPECT_NEAR(summary("predict")["poisson"], 0.4, 1e-6);
  for (const char* name : {"understood", "guessed", "density"}) EXPECT_EQ(summary("predict")[name], before[name]);
  ASSERT_EQ(predict({}), 0);
  EXPECT_EQ(summary("predict"), before);
  EXPECT_EQ(record()["assumed_height"], height);
  ASSERT_EQ(predict({"--material", "silicone rubber"}), 0);
  const json rubber = summary("predict")["understood"];
  ASSERT_EQ(predict({"--density", "900"}), 0);
  EXPECT_EQ(summary("predict")["understood"], rubber);
  EXPECT_EQ(summary("predict")["density"], 900);
  ASSERT_EQ(predict({"--label", "rose"}), 0);
  EXPECT_EQ(summary("predict")["understood"], object_prior({"", "rose", "", {}, {}}).name);
  ASSERT_EQ(run({}), 0);
  EXPECT_TRUE(summary("predict")["guessed"]) << "`run` takes nothing from an earlier one";
}

TEST_F(PredictAgain, OneMadeBeforeTheMaterialOfTheSceneFileChangedIsRefused) {
  write_material_of_scene({{"young", 2e4}, {"density", 300}});
  ASSERT_EQ(run({}), 0);
  ASSERT_EQ(run_quietly(simulate()), 0);
  write_material_of_scene({{"young", 3e4}, {"density", 300}});
  expect_refused({}, "'young' was 20000.0, now 30000.0");
  ASSERT_EQ(predict({}), 0);
  ASSERT_EQ(run_quietly(simulate()), 0);
  write_material_of_scene({{"young", 3e4}});
  expect_refused({}, "'density'");
  expect_refused({"--young", "1e5"}, "'density'");
  EXPECT_EQ(run_quietly(simulate({"--young", "1e5", "--poisson", "0.3", "--density", "400"})), 0);
  // A change of the law is none of E, nu and rho.
  write_material_of_scene({{"young", 3e4}, {"density", 300}, {"law", "neo_hookean"}});
  EXPECT_EQ(run_quietly(simulate()), 0);
}

TEST_F(PredictAgain, ALabelOrAMaterialReplacesAllThreeOfTheSceneFile) {
  write_material_of_scene({{"young", 2e4}, {"poisson", 0.1}, {"density", 300}});
  const ObjectPrior sunflower = object_prior({"", "sunflower", "", {}, {}});
  ASSERT_EQ(run({"--label", "sunflower", "--density", "400"}), 0);
  EXPECT_EQ(summary("predict")["poisson"], sunflower.poisson.typical);
  EXPECT_EQ(summary("predict")["density"], 400) << "that of the command line stays";
  EXPECT_EQ(summary("predict")["given"], json::array({"density"}));
  ASSERT_EQ(predict({"--material", "silicone rubber"}), 0);
  const ObjectPrior rubber = object_prior({"silicone rubber", "", "", {}, {}});
  EXPECT_EQ(summary("predict")["poisson"], rubber.poisson.typical);
  EXPECT_EQ(summary("predict")["density"], rubber.density.typical);
  EXPECT_EQ(summary("predict")["given"], json::array());
  // So it is beside an E of the user.
  ASSERT_EQ(run_quietly(simulate({"--young", "1e5"})), 0);
  EXPECT_EQ(summary("simulate")["session"]["uniform"]["density"], rubber.density.typical);
  // A softness asks for an E alone.
  ASSERT_EQ(run({"--softness", "0.5"}), 0);
  EXPECT_EQ(summary("predict")["given"], json::array({"poisson", "density"}));
  EXPECT_EQ(summary("predict")["density"], 300);
}

}  // namespace
}  // namespace pliant
