// Which object is cut where nobody names one.

#include "app/segment/choose_object.h"

#include <gtest/gtest.h>

#include "gaussians/base/error.h"
#include "tests/segmentation/made_scene.h"

namespace pliant {
namespace {

/// Two balls, of which the larger is the more prominent, and the ground.
struct Balls {
  Scene scene;
  Segmentation segmentation;
  size_t small = 0, large = 0;

  Balls(const std::string& name_of_small, const std::string& name_of_large) {
    const MadeScene made = made_scene({{Vec3f(-0.3f, 0, 0.1f), 0.2f, 1, Vec3f(0.8f, 0.1f, 0.1f)},
                                       {Vec3f(0.3f, 0, 0.2f), 0.4f, 2, Vec3f(0.1f, 0.1f, 0.8f)}});
    scene.cloud = made.cloud;
    scene.cameras = made.cameras;
    segmentation.label = made.truth;
    segmentation.class_id = {1, 2, 3};
    segmentation.class_name = {name_of_small, name_of_large, "rest"};
    small = 0;
    large = 1;
  }

  ChosenClass chosen(const std::string& label) const { return choose_object(scene, segmentation, {label, {}}); }
};

TEST(ChooseObject, TheMostProminentWhereNothingElseIsKnown) {
  const Balls balls("object_1", "object_2");
  const ChosenClass chosen = balls.chosen("");
  EXPECT_EQ(chosen.index, balls.large);
  EXPECT_NE(chosen.why.find("most prominent of 2"), std::string::npos) << chosen.why;
  EXPECT_FALSE(chosen.unnamed);
}

TEST(ChooseObject, ALabelPicksTheObjectThatIsCalledSo) {
  for (const auto& [name, label] : {std::pair("palm", "potted palm"), {"Potted-Palms", "palm"}, {"vase", "vases"}}) {
    const Balls balls(name, "bear");
    const ChosenClass chosen = balls.chosen(label);
    EXPECT_EQ(chosen.index, balls.small) << label;
    EXPECT_FALSE(chosen.unnamed);
  }
  // Of two, the more prominent.
  EXPECT_EQ(Balls("palm", "green palm").chosen("palm").index, 1u);
}

TEST(ChooseObject, ALabelThatIsNoNameIsSaidToBeTakenOnTrust) {
  const Balls balls("object_1", "object_2");
  const ChosenClass chosen = balls.chosen("daffodil");
  EXPECT_EQ(chosen.index, balls.large);
  EXPECT_TRUE(chosen.unnamed);
  // Part of a word is no word.
  EXPECT_TRUE(Balls("pa", "palmistry").chosen("palm").unnamed);
}

TEST(ChooseObject, OfNothingNothingIsChosen) {
  Balls balls("a", "b");
  balls.segmentation.class_id = {0};
  balls.segmentation.class_name = {"unlabelled"};
  EXPECT_THROW(balls.chosen(""), Error);
}

}  // namespace
}  // namespace pliant
