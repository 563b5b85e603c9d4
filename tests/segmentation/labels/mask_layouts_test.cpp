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

TEST(MaskLayouts, MasksThatCoverTheirPhotosHaveNoBackground) {
  TemporaryFolder folder;
  for (int x = 0; x < 6; ++x) write_column(folder / ("part" + std::to_string(x)) / "1.png", x);
  const MaskSet masks = load_masks(folder.path(), "", numbered_cameras(1));
  EXPECT_EQ(masks.ids().size(), 6u);
  EXPECT_TRUE(masks.warnings.empty());
}

}  // namespace
}  // namespace pliant
