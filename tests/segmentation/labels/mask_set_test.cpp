// Reading id masks: names, wide ids, and one typed message per thing that can be wrong.

#include "segmentation/labels/mask_set.h"

#include "gaussians/io/images/image_io.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

std::vector<Camera> cameras(int count) {
  std::vector<Camera> out(count);
  for (int i = 0; i < count; ++i) {
    out[i].name = "photo" + std::to_string(i);
    out[i].width = 6;
    out[i].height = 4;
  }
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
  folder.file("labels.json", R"({"7": "", "300": "ball"})");
  const MaskSet masks = load_masks(folder.path(), folder / "labels.json", cameras(3));
  EXPECT_EQ(masks.ids(), (std::vector<uint32_t>{7, 300, 70001}));
  EXPECT_EQ(masks.name_of(300), "ball");
  EXPECT_EQ(masks.name_of(7), "object_7") << "an empty name is none";
  EXPECT_TRUE(masks.warnings.empty());
}

TEST(MaskSet, GreyMasksSavedAsRgbKeepTheirIdsAndNames) {
  TemporaryFolder folder;
  ImageF grey(6, 4, 3, 1.0f / 255);
  for (int k = 0; k < 3; ++k) grey(2, 1, k) = 2.0f / 255;
  write_image(folder / "photo0.png", grey);
  const auto labels = folder.file("labels.json", R"({"1": "floor", "2": "ball"})");
  const MaskSet masks = load_masks(folder.path(), labels, cameras(1));
  EXPECT_EQ(masks.ids(), (std::vector<uint32_t>{1, 2}));
  EXPECT_EQ(masks.views[0].ids(2, 1), 2u);
  EXPECT_EQ(masks.name_of(2), "ball");
}

TEST(MaskSet, PhotosGivenAsMasksAreRefused) {
  TemporaryFolder folder;
  std::vector<Camera> views = cameras(1);
  views[0].width = 200;
  views[0].height = 150;
  IdImage ids(200, 150, 1);
  for (size_t i = 0; i < ids.data.size(); ++i) ids.data[i] = static_cast<uint32_t>(i);
  write_ids(folder / "photo0.png", ids);
  expect_error(Failure::kInput, {"different IDs", "photos"}, [&] { load_masks(folder.path(), "", views); });
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
  expect_error(Failure::kInput, {"unlabeled", "ID above 0"}, [&] { load_masks(folder.path(), "", cameras(1)); });
}

TEST(MaskSet, LabelsThatAreNoIdsOrNoNamesAreErrors) {
  TemporaryFolder folder;
  write_ids(folder / "photo0.png", picture(1));
  for (const char* bad : {"{\"one\": \"flower\"}", "{\"1\": 5}", "[1]", "{", "{\"-3\": \"x\"}"}) {
    const auto labels = folder.file("labels.json", bad);
    expect_error(Failure::kInput, {"labels.json"}, [&] { load_masks(folder.path(), labels, cameras(1)); });
  }
}

/// A binary picture: 255 (or `value`) in a rectangle.
void write_rectangle(const std::filesystem::path& file, int x0, int y0, int x1, int y1, uint32_t value = 255) {
  std::filesystem::create_directories(file.parent_path());
  IdImage ids(6, 4, 1);
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) ids(x, y) = value;
  write_ids(file, ids);
}

TEST(MaskSet, FoldersOfOneObjectAreIdsInTheOrderOfTheirNames) {
  TemporaryFolder folder;
  for (const auto& [name, x] : {std::pair{"photo0", 0}, {"photo2", 1}})  // ones and zeros
    write_rectangle(folder / "red apple" / (name + std::string(".png")), x, 0, x + 2, 2, 1);
  write_rectangle(folder / "egg/photo0.png", 3, 1, 6, 4);
  const MaskSet masks = load_masks(folder.path(), "", cameras(3));
  EXPECT_EQ(masks.name_of(1), "egg");
  EXPECT_EQ(masks.name_of(2), "red apple");
  ASSERT_EQ(masks.views.size(), 2u);
  EXPECT_EQ(masks.views[0].ids(0, 0), 2u);
  EXPECT_EQ(masks.views[0].ids(3, 1), 1u);
  EXPECT_EQ(masks.name_of(masks.views[0].ids(2, 3)), "background");
  EXPECT_EQ(masks.views[1].camera, 2);
  EXPECT_EQ(masks.views[1].ids(1, 0), 2u);
  EXPECT_EQ(masks.warnings.size(), 2u);
}

TEST(MaskSet, FoldersOfOneViewMayBeNamedOrNumberedAsInLerfMask) {
  TemporaryFolder folder;
  for (const char* view : {"photo1", "photo2"}) {
    write_rectangle(folder / "a" / view / "plate.png", 0, 0, 6, 4);
    write_rectangle(folder / "a" / view / "spoon.png", 2, 1, 4, 2);  // lies on the plate
  }
  // Numbered folders count the views that are not in images_train/: photo1 and photo2 here.
  folder.file("scene/images_train/photo0.jpg", "");
  for (const char* view : {"0", "1"}) {
    write_rectangle(folder / "scene/test_mask" / view / "plate.png", 0, 0, 6, 4);
    write_rectangle(folder / "scene/test_mask" / view / "spoon.png", 2, 1, 4, 2);
  }
  const MaskSet named = load_masks(folder / "a", "", cameras(3)),
                numbered = load_masks(folder / "scene/test_mask", "", cameras(3));
  for (const MaskSet* masks : {&named, &numbered}) {
    ASSERT_EQ(masks->views.size(), 2u);
    EXPECT_EQ(masks->views[0].camera, 1);
    EXPECT_EQ(masks->views[1].camera, 2);
    EXPECT_EQ(masks->name_of(masks->views[0].ids(2, 1)), "spoon");
    EXPECT_EQ(masks->name_of(masks->views[0].ids(0, 0)), "plate");
  }
}

TEST(MaskSet, FoldersNamedByWholeNumbersAreTheirIds) {
  TemporaryFolder folder;
  write_rectangle(folder / "12/photo0.png", 0, 0, 2, 2);
  write_rectangle(folder / "70001/photo0.png", 4, 0, 6, 2);
  EXPECT_EQ(load_masks(folder.path(), "", cameras(1)).ids(), (std::vector<uint32_t>{12, 70001, 70002}));
}

TEST(MaskSet, NumbersThatNoPictureHoldsAreNamesOfTheirFolders) {
  TemporaryFolder folder;
  write_rectangle(folder / "12/photo0.png", 0, 0, 2, 2);
  write_rectangle(folder / std::to_string(kLargestId + 1) / "photo0.png", 4, 0, 6, 2);
  EXPECT_EQ(load_masks(folder.path(), "", cameras(1)).names,
            (std::map<uint32_t, std::string>{{1, "12"}, {2, "16777216"}, {3, "background"}}));
}

TEST(MaskSet, NamesOfFoldersAreNotReplacedByAFileElsewhere) {
  TemporaryFolder folder;
  write_rectangle(folder / "masks/red apple/photo0.png", 0, 0, 2, 2);
  write_rectangle(folder / "masks/egg/photo0.png", 3, 1, 6, 4);
  const auto elsewhere = folder.file("labels.json", R"({"1": "flower", "2": "box", "12": "cup"})");
  const MaskSet masks = load_masks(folder / "masks", elsewhere, cameras(1));
  EXPECT_EQ(masks.names, (std::map<uint32_t, std::string>{{1, "egg"}, {2, "red apple"}, {3, "background"}}));
  ASSERT_EQ(masks.warnings.size(), 2u);
  EXPECT_NE(masks.warnings[0].find("labels.json"), std::string::npos);
  const auto among_them = folder.file("masks/labels.json", R"({"2": "pear"})");
  EXPECT_EQ(load_masks(folder / "masks", among_them, cameras(1)).names,
            (std::map<uint32_t, std::string>{{1, "egg"}, {2, "pear"}, {3, "background"}}));
  // Folders named by whole numbers give no names.
  write_rectangle(folder / "ids/12/photo0.png", 0, 0, 2, 2);
  write_rectangle(folder / "ids/13/photo0.png", 3, 1, 6, 4);
  EXPECT_EQ(load_masks(folder / "ids", elsewhere, cameras(1)).name_of(12), "cup");
}

TEST(MaskSet, BinaryMasksOfOneObjectShowTheBackgroundToo) {
  TemporaryFolder folder;
  write_rectangle(folder / "binary/egg/photo0.png", 0, 0, 2, 2);
  const MaskSet masks = load_masks(folder / "binary", "", cameras(1));
  EXPECT_EQ(masks.names, (std::map<uint32_t, std::string>{{1, "egg"}, {2, "background"}}));
  EXPECT_EQ(masks.views[0].ids(1, 1), 1u);
  EXPECT_EQ(masks.views[0].ids(3, 3), 2u);
  ASSERT_EQ(masks.warnings.size(), 1u);
  EXPECT_NE(masks.warnings[0].find("egg"), std::string::npos);
  write_ids(folder / "ids/photo0.png", picture(1));  // 0 is unlabelled there
  EXPECT_EQ(load_masks(folder / "ids", "", cameras(1)).ids(), std::vector<uint32_t>{1});
}

TEST(MaskSet, JpegsNamedLikeThePhotosAreMasksOfOneObjectAndPhotosAreNone) {
  std::vector<Camera> views = cameras(2);
  for (Camera& camera : views) {
    camera.width = 64;
    camera.height = 48;
  }
  TemporaryFolder folder;
  ImageF mask(64, 48, 1), photo(64, 48, 1);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      mask(x, y) = x >= 16 && x < 40 && y >= 8 && y < 32;
      photo(x, y) = static_cast<float>(x) / 63;
    }
  write_image(folder / "photo0.jpg", mask);
  const MaskSet masks = load_masks(folder.path(), "", views);
  ASSERT_EQ(masks.views.size(), 1u);
  EXPECT_EQ(masks.views[0].camera, 0);
  EXPECT_EQ(masks.name_of(1), "object");
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) ASSERT_EQ(masks.views[0].ids(x, y), mask(x, y) > 0 ? 1u : 2u) << x << "," << y;
  write_image(folder / "photo1.jpg", photo);
  expect_error(Failure::kInput, {"photo1.jpg", "more than black and white"},
               [&] { load_masks(folder.path(), "", views); });
}

TEST(MaskSet, BinaryMasksOfAnotherSizeAreRefused) {
  TemporaryFolder folder;
  write_rectangle(folder / "egg/photo0.png", 0, 0, 2, 2);
  std::vector<Camera> wide = cameras(1);
  wide[0].width = 12;
  expect_error(Failure::kInput, {"egg", "6x4", "12x4"}, [&] { load_masks(folder.path(), "", wide); });
}

TEST(MaskSet, MasksOfAnySizeButOfTheCamerasShapeAreFittedOnRequest) {
  TemporaryFolder folder;
  write_ids(folder / "ids/photo0.png", picture(7, 12, 8));
  write_ids(folder / "binary/egg/photo0.png", picture(255, 12, 8));
  std::vector<int> widths;
  const FitMask fit = [&](const IdImage& ids, int camera) {
    EXPECT_EQ(camera, 0);
    widths.push_back(ids.width);
    return picture(5);
  };
  for (const char* layout : {"ids", "binary"}) {
    EXPECT_EQ(load_masks(folder / layout, "", cameras(1), fit).ids().front(), 5u);
    expect_error(Failure::kInput, {"12x8", "6x4"}, [&] { load_masks(folder / layout, "", cameras(1)); });
  }
  EXPECT_EQ(widths, (std::vector<int>{12, 12}));
  write_ids(folder / "binary/apple/photo0.png", picture(255, 6, 4));
  expect_error(Failure::kInput, {"egg", "12x8", "6x4"}, [&] { load_masks(folder / "binary", "", cameras(1), fit); });
  write_ids(folder / "ids/photo0.png", picture(7, 12, 4));
  expect_error(Failure::kInput, {"photo0.png", "12x4", "6x4"},
               [&] { load_masks(folder / "ids", "", cameras(1), fit); });
}

TEST(MaskSet, MasksMayCarryTheNameOfThePhotoWithItsExtension) {
  TemporaryFolder folder;
  std::vector<Camera> one = cameras(1);
  one[0].photo = "/somewhere/IMG_7.JPG";
  write_ids(folder / "IMG_7.JPG.png", picture(5));
  EXPECT_EQ(load_masks(folder.path(), "", one).ids(), std::vector<uint32_t>{5});
}

TEST(MaskSet, MuchOrAllThatHasNoLabelOfItsOwnIsToldUnlessTheBackgroundIsAnObject) {
  EXPECT_NE(warning_of_zero({"ball"}, 0).find("one ID"), std::string::npos);
  EXPECT_EQ(warning_of_zero({"ball", "table"}, 0.25), "");
  EXPECT_EQ(warning_of_zero({"ball", "table"}, 0.4).rfind("40 % of what the photos show has no label", 0), 0u);
  EXPECT_EQ(warning_of_zero({"ball", "background"}, 0.4), "");
}

TEST(MaskSet, NamesAmongTheMasksAreTheirs) {
  TemporaryFolder folder;
  EXPECT_EQ(labels_of(folder.path(), "elsewhere.json"), "elsewhere.json");
  const auto beside = folder.file("labels.json", "{}");
  EXPECT_EQ(labels_of(folder.path(), "elsewhere.json"), beside);
}

TEST(MaskSet, ZeroAsBackgroundIsAnObjectOfItsOwn) {
  TemporaryFolder folder;
  write_ids(folder / "photo0.png", picture(7));
  write_ids(folder / "photo1.png", picture(300));
  MaskSet masks = load_masks(folder.path(), "", cameras(2));
  EXPECT_EQ(label_background(masks), 301u);
  EXPECT_EQ(masks.ids(), (std::vector<uint32_t>{7, 300, 301}));
  EXPECT_EQ(masks.name_of(301), "background");
  EXPECT_EQ(masks.views[0].ids(0, 0), 301u);
  EXPECT_EQ(masks.views[1].ids(2, 1), 300u);
}

TEST(MaskSet, TheBackgroundsIdFitsIntoAPicture) {
  MaskSet masks;
  masks.views = {{0, picture(kLargestId)}, {1, picture(1)}};
  EXPECT_EQ(label_background(masks), 2u);
  EXPECT_EQ(masks.ids(), (std::vector<uint32_t>{1, 2, kLargestId}));
}

}  // namespace
}  // namespace pliant
