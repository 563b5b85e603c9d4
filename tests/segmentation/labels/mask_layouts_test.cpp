// Folders of binary pictures: which of two layouts they have, and what pixels outside of all objects are.

#include "segmentation/labels/mask_layouts.h"

#include "gaussians/io/images/image_io.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

/// Cameras named 1, 2, ...
std::vector<Camera> numbered_cameras(int count) {
  std::vector<Camera> cameras(count);
  for (int i = 0; i < count; ++i) {
    cameras[i].name = std::to_string(i + 1);
    cameras[i].width = 6;
    cameras[i].height = 4;
  }
  return cameras;
}

/// White in column `x` of a black picture.
void write_column(const std::filesystem::path& file, int x) {
  std::filesystem::create_directories(file.parent_path());
  IdImage ids(6, 4, 1);
  for (int y = 0; y < 4; ++y) ids(x, y) = 255;
  write_ids(file, ids);
}

TEST(MaskLayouts, TheOneThatMoreFilesFitHoldsForAllFolders) {
  TemporaryFolder folder;
  for (const char* photo : {"1", "2", "3"}) {
    write_column(folder / "objects/1" / (photo + std::string(".png")), 0);
    write_column(folder / "objects/cup" / (photo + std::string(".png")), 3);
    write_column(folder / "photos" / photo / "1.png", 0);
    write_column(folder / "photos" / photo / "cup.png", 3);
  }
  for (const char* layout : {"objects", "photos"}) {
    const BinaryMasks read = load_binary_masks(folder / layout, numbered_cameras(3));
    ASSERT_EQ(read.masks.views.size(), 3u) << layout;
    EXPECT_EQ(read.complete, (std::vector<size_t>{0, 1, 2})) << layout;
    for (const MaskSet::View& view : read.masks.views) {
      EXPECT_EQ(view.ids(0, 1), 1u) << layout;
      EXPECT_EQ(read.masks.name_of(view.ids(3, 1)), "cup") << layout;
    }
  }
}

TEST(MaskLayouts, FoldersAndFilesThatAreAllNamedLikePhotosAreRefused) {
  TemporaryFolder folder;
  for (const char* object : {"1", "2"})
    for (const char* photo : {"1", "2", "3"}) write_column(folder / object / (photo + std::string(".png")), 0);
  expect_error(Failure::kInput, {"<object>/<photo>", "<photo>/<object>", "object_1"},
               [&] { load_binary_masks(folder.path(), numbered_cameras(3)); });
}

TEST(MaskLayouts, WhereAPhotoHasAMaskOfEveryObjectTheOtherPixelsAreTheBackground) {
  TemporaryFolder folder;
  write_column(folder / "cup/1.png", 0);
  write_column(folder / "egg/1.png", 3);
  write_column(folder / "cup/2.png", 1);  // whether it shows the egg is not known
  MaskSet masks = load_masks(folder.path(), "", numbered_cameras(2));
  EXPECT_EQ(masks.names, (std::map<uint32_t, std::string>{{1, "cup"}, {2, "egg"}, {3, "background"}}));
  EXPECT_EQ(masks.views[0].ids(5, 0), 3u);
  EXPECT_EQ(masks.views[1].ids(5, 0), 0u);
  ASSERT_EQ(masks.warnings.size(), 1u);
  EXPECT_NE(masks.warnings[0].find("2 objects"), std::string::npos) << masks.warnings[0];
  EXPECT_NE(masks.warnings[0].find("in the 1 of 2 photos"), std::string::npos) << masks.warnings[0];
  // The rest of it becomes the same object on request.
  EXPECT_EQ(label_background(masks), 3u);
  EXPECT_EQ(masks.views[1].ids(5, 0), 3u);
  EXPECT_EQ(masks.ids(), (std::vector<uint32_t>{1, 2, 3}));
}

/// Cameras 1, 2, ..., whose photos are in the folders.
std::vector<Camera> cameras_in_folders(const std::vector<std::string>& folders) {
  std::vector<Camera> cameras = numbered_cameras(static_cast<int>(folders.size()));
  for (size_t i = 0; i < cameras.size(); ++i)
    cameras[i].photo = "/somewhere/images/" + folders[i] + "/" + cameras[i].name + ".jpg";
  return cameras;
}

void write_picture(const std::filesystem::path& file, uint32_t left, uint32_t right) {
  std::filesystem::create_directories(file.parent_path());
  IdImage ids(6, 4, 1);
  for (int y = 0; y < 4; ++y) {
    ids(0, y) = left;
    ids(5, y) = right;
  }
  write_ids(file, ids);
}

TEST(MaskLayouts, IdMasksInFoldersLikeThoseOfThePhotosKeepTheirIds) {
  for (const std::vector<std::string>& folders : std::vector<std::vector<std::string>>{
           {"cam1", "cam2"}, {"cam1", "cam1"}, {"cam1/left", "cam2/left"}, {"cam1/left", "cam1/left"}}) {
    TemporaryFolder folder;
    const std::vector<Camera> cameras = cameras_in_folders(folders);
    for (size_t c = 0; c < 2; ++c) write_picture(folder / folders[c] / (cameras[c].name + ".png"), 1, 2);
    const MaskSet masks = load_masks(folder.path(), "", cameras);
    ASSERT_EQ(masks.views.size(), 2u) << folders[1];
    EXPECT_EQ(masks.ids(), (std::vector<uint32_t>{1, 2})) << folders[1];
    EXPECT_TRUE(masks.names.empty()) << folders[1];
    EXPECT_EQ(masks.views[1].ids(5, 0), 2u) << folders[1];
  }
}

TEST(MaskLayouts, InOneFolderAnIdOf255IsOneOfSeveralAndWhiteWithASoftEdgeIsAnObject) {
  const std::vector<Camera> cameras = cameras_in_folders({"cup", "cup"});
  TemporaryFolder folder;
  write_picture(folder / "ids/cup/1.png", 1, 2);
  write_picture(folder / "ids/cup/2.png", 2, 255);
  const MaskSet ids = load_masks(folder / "ids", "", cameras);
  EXPECT_EQ(ids.ids(), (std::vector<uint32_t>{1, 2, 255}));
  EXPECT_TRUE(ids.names.empty());
  write_picture(folder / "white/cup/1.png", 255, 100);
  write_picture(folder / "white/cup/2.png", 255, 255);
  const MaskSet white = load_masks(folder / "white", "", cameras);
  EXPECT_EQ(white.name_of(white.views.at(0).ids(0, 0)), "cup");
  EXPECT_EQ(white.name_of(white.views.at(0).ids(5, 0)), "background");
}

TEST(MaskLayouts, FoldersTellPhotosOfOneStemApart) {
  TemporaryFolder folder;
  std::vector<Camera> cameras = cameras_in_folders({"train", "test"});
  for (Camera& camera : cameras) camera.photo = std::filesystem::path(camera.photo).parent_path().string() + "/r_0.png";
  cameras[0].name = "train_r_0";
  cameras[1].name = "test_r_0";
  write_picture(folder / "train/r_0.png", 1, 2);
  write_picture(folder / "test/r_0.png.png", 2, 3);
  const MaskSet masks = load_masks(folder.path(), "", cameras);
  ASSERT_EQ(masks.views.size(), 2u);
  EXPECT_EQ(masks.views[0].ids(5, 0), 2u);
  EXPECT_EQ(masks.views[1].ids(5, 0), 3u);
}

TEST(MaskLayouts, WhitePicturesInOneFolderAreAnObjectWhateverThePhotosFolder) {
  TemporaryFolder folder;
  for (const char* object : {"cup", "egg"}) write_column(folder / object / "1.png", object[0] == 'c' ? 0 : 3);
  const MaskSet masks = load_masks(folder.path(), "", cameras_in_folders({"cup", "cup"}));
  EXPECT_EQ(masks.name_of(masks.views.at(0).ids(0, 0)), "cup");
  EXPECT_EQ(masks.name_of(masks.views.at(0).ids(3, 0)), "egg");
}

TEST(MaskLayouts, IdMasksInOtherFoldersAreRefused) {
  TemporaryFolder folder;
  write_picture(folder / "a/1.png", 1, 2);
  write_picture(folder / "b/2.png", 2, 3);
  expect_error(Failure::kInput, {"3 or more small values", "folders like those of the photos"},
               [&] { load_masks(folder.path(), "", numbered_cameras(2)); });
  write_picture(folder / "a/1.png", 3, 255);  // weak traces beside white are none
  EXPECT_EQ(load_binary_masks(folder.path(), numbered_cameras(2)).masks.views.size(), 2u);
}

TEST(MaskLayouts, WeakTracesOfAnObjectThatAPhotoDoesNotShowAreNotTheObject) {
  TemporaryFolder folder;
  write_picture(folder / "cup/1.png", 255, 100);
  write_picture(folder / "cup/2.png", 3, 1);
  const BinaryMasks read = load_binary_masks(folder.path(), numbered_cameras(2));
  ASSERT_EQ(read.masks.views.size(), 2u);
  EXPECT_EQ(read.complete, (std::vector<size_t>{0, 1}));
  EXPECT_EQ(read.masks.views[0].ids(0, 0), 1u);
  EXPECT_EQ(read.masks.views[0].ids(5, 0), 0u);
  for (const uint32_t id : read.masks.views[1].ids.data) EXPECT_EQ(id, 0u);
}

TEST(MaskLayouts, MasksThatCoverTheirPhotosHaveNoBackground) {
  TemporaryFolder folder;
  for (int x = 0; x < 6; ++x) write_column(folder / ("part" + std::to_string(x)) / "1.png", x);
  const MaskSet masks = load_masks(folder.path(), "", numbered_cameras(1));
  EXPECT_EQ(masks.ids().size(), 6u);
  EXPECT_TRUE(masks.warnings.empty());
}

}  // namespace
}  // namespace pliant
