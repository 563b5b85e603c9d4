// What holds an object leaves something of it to move.

#include "app/seed/object_pins.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

/// A block of samples .01 apart from z = 1 on, so many in its height, and Gaussians at the same places.
struct Block {
  SolidSamples samples;
  GaussianCloud cloud;

  explicit Block(int layers) {
    samples.spacing = 0.01f;
    for (int i = 0; i < 100 * layers; ++i)
      samples.position.push_back(0.01f * Vec3f(i % 10, i / 10 % 10, 100 + static_cast<float>(i / 100)));
    samples.volume.assign(samples.size(), 1e-6f);
    cloud.resize(samples.size());
    cloud.position = samples.position;
    for (float& opacity : cloud.opacity_logit) opacity = 4;
  }
  double held(const std::vector<Region>& pins) const {
    double sum = 0;
    for (const Vec3f& x : samples.position) sum += pins.size() == 1 && pins[0].contains(x.cast<double>());
    return sum / static_cast<double>(samples.size());
  }
};

class ObjectPins : public testing::Test {
 protected:
  ObjectPins() {
    scene_.up = Vec3d::UnitZ();
    progress_.listen([this](const ProgressEvent& event) { said_ += event.text + "\n"; });
  }
  std::vector<Region> pins(const Block& block) {
    return object_pins({progress_, {}}, scene_, stage_, extract_, block.cloud, block.samples);
  }
  /// A support below the block, which touches it up to `band` above its lowest samples.
  void stand(double band) {
    extract_["contact"] = {{"support", "table"}, {"point", {0, 0, 1}}, {"normal", {0, 0, 1}}, {"band", band}};
  }
  std::string refusal(const Block& block) {
    try {
      pins(block);
    } catch (const Error& error) {
      EXPECT_EQ(error.failure, Failure::kUsage);
      return error.what();
    }
    return "";
  }

  Progress progress_{true};
  std::string said_;
  Scene scene_;
  FillStage stage_;
  nlohmann::json extract_ = nlohmann::json::object();
};

}  // namespace

TEST_F(ObjectPins, AreWhereAnObjectTouchesItsSupportElseItsLowestTenth) {
  const Block tall(40);
  EXPECT_NEAR(tall.held(pins(tall)), kHeldShare, 0.05);
  EXPECT_NE(said_.find("lowest tenth"), std::string::npos) << said_;
  stand(0.055);
  EXPECT_NEAR(tall.held(pins(tall)), 6.0 / 40, 1e-6);
  EXPECT_NE(said_.find("touches 'table'\n"), std::string::npos) << said_;
}

TEST_F(ObjectPins, ThatTouchAWholeObjectReachUpToHalfOfIt) {
  stand(0.1);
  const Block low(4);
  EXPECT_EQ(low.held(pins(low)), 0.5);
  EXPECT_NE(said_.find("up to half"), std::string::npos) << said_;
}

TEST_F(ObjectPins, OfTheSceneFileThatHoldAnotherObjectAreLeftOut) {
  const Block block(10);
  SceneFile::Region& elsewhere = scene_.settings.pinned.emplace_back();
  elsewhere.low = Vec3f(5, 5, 5);
  elsewhere.high = Vec3f(6, 6, 6);
  scene_.settings.file = "scene.json";
  // The object is held as if they were not there.
  EXPECT_NEAR(block.held(pins(block)), 0.1, 0.05);
  EXPECT_NE(said_.find("pinned[0] holds nothing"), std::string::npos) << said_;
  scene_.settings.pinned.emplace_back();
  scene_.settings.pinned[1].low = Vec3f(-1, -1, 0.9f);
  scene_.settings.pinned[1].high = Vec3f(1, 1, 1.045f);
  EXPECT_NEAR(block.held(pins(block)), 0.5, 1e-6);
}

TEST_F(ObjectPins, HoldNothingOfASheet) {
  const Block sheet(1);
  EXPECT_TRUE(pins(sheet).empty());
  stand(0.1);
  EXPECT_TRUE(pins(sheet).empty());
  EXPECT_NE(said_.find("flat"), std::string::npos) << said_;
}

TEST_F(ObjectPins, ThatTheUserGaveAndThatLeaveNothingAreRefusedByTheirName) {
  const Block block(4);
  stage_.pin_below = 2;
  const std::string option = refusal(block);
  EXPECT_NE(option.find("--pin-below"), std::string::npos) << option;
  EXPECT_NE(option.find("between 1 and 1.03"), std::string::npos) << option;
  stage_.pin_below.reset();
  scene_.settings.pinned.push_back({true, Vec3f(0, 0, 1), Vec3f(9, 0, 0)});
  const std::string file = refusal(block);
  EXPECT_NE(file.find("scene.json: pinned"), std::string::npos) << file;
}

}  // namespace pliant
