// After another selection nothing that was made of the earlier object is taken for that of the new one, though both
// have the same ID and name.

#include <gtest/gtest.h>

#include "app/run/attach_scene.h"
#include "tests/app/predict/predict_case.h"

namespace pliant {
namespace {

class StaleObject : public Predict {
 protected:
  std::string directory() const { return (folder_ / "run").string(); }
  RunDirectory opened() const { return RunDirectory::open(directory()); }
  /// What the program says to these words, which end with this code.
  std::string said(const std::vector<std::string>& words, int code) const {
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_pliant(words), code) << words[0];
    return testing::internal::GetCapturedStderr();
  }
};

TEST_F(StaleObject, IsRefusedByEachCommandThatWouldUseIt) {
  ASSERT_EQ(run({"--label", "sunflower"}), 0);
  const std::vector<std::string> simulate = {"simulate", directory(), "--fps", "20", "--duration", "0.2"};
  EXPECT_FALSE(is_selected_anew(opened()));
  EXPECT_NE(load_run_scene(opened()).metres_per_unit, 1);

  // The nearer half of the beam.
  ASSERT_EQ(run_quietly({"segment", (folder_ / "scene").string(), "--out", directory(), "--aabb",
                         "-0.1,-0.1,0.9,0.45,0.3,1.3", "--orbit-views", "6"}),
            0);
  EXPECT_TRUE(is_selected_anew(opened()));
  EXPECT_NE(said(simulate, 0).find("`pliant extract`"), std::string::npos);
  ASSERT_EQ(run_quietly({"extract", directory(), "--object", "object"}), 0);
  EXPECT_FALSE(is_selected_anew(opened()));
  EXPECT_EQ(load_run_scene(opened()).metres_per_unit, 1) << "the height was assumed of the whole beam";

  const int usage = static_cast<int>(Failure::kUsage);
  for (const std::vector<std::string>& words :
       {simulate,
        {"simulate", directory(), "--young", "1e5", "--poisson", "0.3", "--density", "500"},
        {"predict", directory()},
        {"fit", directory(), "--markers", (folder_ / "scene/scene.json").string()},
        {"render", directory()},
        {"export", directory(), "--ply-sequence", (folder_ / "frames").string()}})
    EXPECT_NE(said(words, usage).find("`pliant seed`"), std::string::npos) << words[0];

  ASSERT_EQ(run_quietly({"seed", directory(), "--particles", "300", "--no-pin-contact"}), 0);
  EXPECT_NE(said({"render", directory()}, usage).find("`pliant simulate`"), std::string::npos);
  const std::string foreign = said(simulate, usage);
  for (const char* word : {"another object", "`pliant predict`"})
    EXPECT_NE(foreign.find(word), std::string::npos) << foreign;
  ASSERT_EQ(run_quietly({"predict", directory()}), 0);
  EXPECT_TRUE(summary("predict")["guessed"]) << "the label was that of the whole beam";
  EXPECT_EQ(run_quietly(simulate), 0);
}

TEST_F(StaleObject, IsStillTheSameOneUnderAnotherName) {
  ASSERT_EQ(run({"--label", "sunflower"}), 0);
  const double scale = load_run_scene(opened()).metres_per_unit;
  ASSERT_EQ(run_quietly({"segment", "edit", directory(), "--name", "object=flower"}), 0);
  const std::vector<std::string> simulate = {"simulate", directory(), "--fps", "20", "--duration", "0.1"};
  EXPECT_EQ(said(simulate, 0).find("`pliant extract`"), std::string::npos);
  ASSERT_EQ(run_quietly({"extract", directory(), "--object", "flower"}), 0);
  EXPECT_EQ(load_run_scene(opened()).metres_per_unit, scale);
  EXPECT_TRUE(predicts_object(opened()));
  EXPECT_EQ(run_quietly(simulate), 0);
}

}  // namespace
}  // namespace pliant
