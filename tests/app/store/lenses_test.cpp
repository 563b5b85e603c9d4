// Lenses that a training removed from photos are read back for their cameras; damaged files are named.

#include "app/store/lenses.h"

#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace pliant {
namespace {

TEST(Lenses, AreReadBackByTheNameOfTheirCamera) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / kLensFile;
  TrainingPhotos photos;
  photos.photos.resize(2);
  Camera& camera = photos.photos[1].camera = look_at({0.1, 0.2, -2}, {0, 0, 0}, {0, -1, 0}, 57, 41, 50);
  camera.name = "a";
  Camera& lens = photos.photos[1].lens = camera;
  lens.width = 60;
  lens.height = 45;
  lens.fy = 50.5;
  lens.cx = 31.0 / 3;
  lens.distortion = {0.1, -0.02, 1e-3, -2e-3, 1e-4, 0.3};
  EXPECT_FALSE(read_lens(file, camera));
  write_lenses(file, photos);
  const Camera back = read_lens(file, camera).value();
  EXPECT_EQ(back.width, 60);
  EXPECT_EQ(back.height, 45);
  EXPECT_EQ(back.fx, lens.fx);
  EXPECT_EQ(back.fy, lens.fy);
  EXPECT_EQ(back.cx, lens.cx);
  EXPECT_EQ(back.cy, lens.cy);
  EXPECT_EQ(back.distortion, lens.distortion);
  EXPECT_TRUE(back.cam_from_world.isApprox(camera.cam_from_world));
  Camera another = camera;
  another.name = "another";
  EXPECT_FALSE(read_lens(file, another));
  // A training that removed none leaves no lenses of an earlier one.
  lens.width = 0;
  write_lenses(file, photos);
  EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(Lenses, DamagedFilesAreNamed) {
  const TemporaryFolder folder;
  Camera camera;
  camera.name = "a";
  for (const auto& [text, words] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {"[]", {kLensFile}},
           {R"({"a": 1})", {kLensFile, "a"}},
           {R"({"a": {"width": 0.5}})", {kLensFile, "a.width", "0.5"}},
           {R"({"a": {"width": 60, "height": 1e9}})", {"a.height"}},
           {R"({"a": {"width": 60, "height": 45, "fx": 0}})", {"a.fx"}},
           {R"({"a": {"width": 60, "height": 45, "fx": 9, "fy": 9, "cx": 30, "cy": 20, "distortion": [1]}})",
            {"a.distortion"}}}) {
    SCOPED_TRACE(text);
    folder.file(kLensFile, text);
    expect_error(Failure::kInput, words, [&] { read_lens(folder / kLensFile, camera); });
  }
}

}  // namespace
}  // namespace pliant
