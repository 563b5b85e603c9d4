#include "gaussians/io/images/image_files.h"

#include "tests/temporary_folder.h"

namespace pliant {
namespace {

TEST(ImageFiles, AreThoseOfEveryReadableExtensionInEitherCaseByNameWithoutHiddenOnes) {
  const TemporaryFolder folder;
  for (const char* name : {"b.PNG", "a.jpg", "c.JPEG", "d.webp", "e.TIF", ".hidden.png", "notes.txt", "png"})
    folder.file(name, "");
  std::filesystem::create_directory(folder / "f.png");
  std::vector<std::string> names;
  for (const auto& file : images_in(folder.path())) names.push_back(file.filename());
  EXPECT_EQ(names, (std::vector<std::string>{"a.jpg", "b.PNG", "c.JPEG", "d.webp", "e.TIF"}));
  EXPECT_TRUE(images_in(folder / "nowhere").empty());
}

TEST(ImageFiles, AJpegIsToldByItsExtensionInEitherCase) {
  EXPECT_TRUE(is_jpeg_file("a.JPG"));
  EXPECT_TRUE(is_jpeg_file("a.jpeg"));
  EXPECT_FALSE(is_jpeg_file("jpg"));
  EXPECT_FALSE(is_jpeg_file("a.png"));
}

}  // namespace
}  // namespace pliant
