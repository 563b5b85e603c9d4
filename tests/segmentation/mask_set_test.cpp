// Reading id masks: names, wide ids, and one typed message per thing that can be wrong.

#include "segmentation/lift/mask_set.h"

#include "gaussians/io/image_io.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

std::vector<Camera> cameras(int count) {
  std::vector<Camera> out(count);
  for (int i = 0; i < count; ++i) out[i].name = "photo" + std::to_string(i), out[i].width = 6, out[i].height = 4;
  return out;
}

IdImage picture(uint32_t id, int width = 6, int height = 4) {
  IdImage ids(width, height, 1);
  ids(2, 1) = id;
  return ids;
}

TEST(MaskSet, IdsAreReadAtEveryWidthAndNamed) {
  TemporaryFolder folder;
  write_ids(folder / "photo0.png", picture(7));
  write_ids(folder / "photo1.png", picture(300));
  write_ids(folder / "photo2.png", picture(70001));
  folder.file("labels.json", R"({"300": "ball"})");
  const MaskSet masks = load_masks(folder.path(), folder / "labels.json", cameras(3));
  EXPECT_EQ(masks.ids(), (std::vector<uint32_t>{7, 300, 70001}));
  EXPECT_EQ(masks.name_of(300), "ball");
  EXPECT_EQ(masks.name_of(7), "object_7");
  EXPECT_TRUE(masks.warnings.empty());
}

TEST(MaskSet, CamerasWithoutAMaskAreWarnedAbout) {
  TemporaryFolder folder;
  write_ids(folder / "photo1.png", picture(1));
  const MaskSet masks = load_masks(folder.path(), "", cameras(3));
  ASSERT_EQ(masks.views.size(), 1u);
  EXPECT_EQ(masks.views[0].camera, 1);
  ASSERT_EQ(masks.warnings.size(), 1u);
  EXPECT_NE(masks.warnings[0].find("2 of 3 cameras"), std::string::npos);
}

TEST(MaskSet, NoMaskAtAllIsAnError) {
  TemporaryFolder folder;
  expect_error(Failure::kInput, {"photo0.png"}, [&] { load_masks(folder.path(), "", cameras(2)); });
  expect_error(Failure::kInput, {"nowhere", "--aabb"}, [&] { load_masks(folder / "nowhere", "", cameras(2)); });
}

TEST(MaskSet, AnotherSizeThanTheCameraIsAnError) {
  TemporaryFolder folder;
  write_ids(folder / "photo0.png", picture(1, 5, 4));
  expect_error(Failure::kInput, {"photo0.png", "5x4", "6x4"}, [&] { load_masks(folder.path(), "", cameras(1)); });
}

TEST(MaskSet, AnUnreadablePictureIsAnError) {
  TemporaryFolder folder;
  folder.file("photo0.png", "not a picture");
  expect_error(Failure::kInput, {"photo0.png"}, [&] { load_masks(folder.path(), "", cameras(1)); });
}

TEST(MaskSet, MasksWithoutAnyObjectAreAnError) {
  TemporaryFolder folder;
  write_ids(folder / "photo0.png", picture(0));
  expect_error(Failure::kInput, {"unlabelled", "id above 0"}, [&] { load_masks(folder.path(), "", cameras(1)); });
}

TEST(MaskSet, LabelsThatAreNoIdsOrNoNamesAreErrors) {
  TemporaryFolder folder;
  write_ids(folder / "photo0.png", picture(1));
  for (const char* bad : {"{\"one\": \"flower\"}", "{\"1\": 5}", "[1]", "{", "{\"-3\": \"x\"}"}) {
    const auto labels = folder.file("labels.json", bad);
    expect_error(Failure::kInput, {"labels.json"}, [&] { load_masks(folder.path(), labels, cameras(1)); });
  }
}

}  // namespace
}  // namespace pliant
