// A trained scene follows its source: photos and masks that moved, an up that is no longer said, photos that are gone.

#include <nlohmann/json.hpp>

#include "app/reconstruct/photo_set.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "tests/app/reconstruct/made_photos.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

TEST_F(Reconstruct, AnUpThatTheSourceNoLongerSaysGoes) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 4);
  for (const char* size : {"960", "40"}) {  // photos as they are, and scaled
    json source = {{"cameras", "transforms.json"}, {"photos", "photos"}, {"up", {1, 0, 0}}};
    write_json(folder / "set/scene.json", source);
    const fs::path out = folder / size;
    const auto train = [&] {
      EXPECT_EQ(run_quietly(command(folder / "set", out, {"--iterations", "3", "--max-image-size", size})), 0);
      return read_json(out / "scene.json");
    };
    EXPECT_EQ(train()["up"], source["up"]);
    EXPECT_EQ(train()["up"], source["up"]);
    source.erase("up");
    write_json(folder / "set/scene.json", source);
    EXPECT_FALSE(train().contains("up")) << size;
    EXPECT_FALSE(fs::exists(out / "point_cloud.1")) << "nothing is trained again";
    source["up"] = {0, 1, 0};
    write_json(folder / "set/scene.json", source);
    EXPECT_EQ(train()["up"], source["up"]);
  }
}

TEST_F(Reconstruct, PhotosAndMasksThatMovedAreNamedWhereTheSourceHasThemNow) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 4);
  IdImage ids(kWidth, kHeight, 1, 2);
  for (int y = 0; y < kHeight; ++y) std::fill_n(ids.at(0, y), kWidth / 2, 1);
  for (int i = 10; i < 14; ++i) write_ids(folder / ("set/masks/v" + std::to_string(i) + ".png"), ids);
  json source = {{"cameras", "transforms.json"}, {"photos", "photos"}, {"masks", "masks"}};
  write_json(folder / "set/scene.json", source);
  const auto train = [&](const fs::path& set, const char* size) {
    EXPECT_EQ(run_quietly(command(set, folder / size, {"--iterations", "3", "--max-image-size", size})), 0);
  };
  train(folder / "set", "960");
  train(folder / "set", "40");
  const std::string trained = sha256_of_file(folder / "960/results.json"),
                    cameras = sha256_of_file(folder / "960/transforms.json"),
                    of_scaled = sha256_of_file(folder / "40/transforms.json");
  train(folder / "set", "960");
  EXPECT_EQ(sha256_of_file(folder / "960/transforms.json"), cameras) << "nothing has moved";

  const auto expect_photos_in = [&](const fs::path& photos, const fs::path& masks) {
    const Scene scene = load_scene(folder / "960");
    ASSERT_EQ(scene.cameras.size(), 4u);
    EXPECT_TRUE(fs::equivalent(scene.settings.photos, photos));
    EXPECT_TRUE(fs::equivalent(scene.settings.masks, masks));
    EXPECT_TRUE(fs::equivalent(scene.cameras[2].photo, photos / "v12.png"));
    EXPECT_EQ(scene.cameras[2].name, "v12");
    // Also without the folder that scene.json names.
    EXPECT_EQ(read_cameras(folder / "960/transforms.json").photos_found, 4);
  };
  const fs::path moved = folder / "elsewhere/moved";
  fs::create_directories(moved.parent_path());
  fs::rename(folder / "set", moved);
  train(moved, "960");
  expect_photos_in(moved / "photos", moved / "masks");
  fs::rename(moved / "photos", moved / "pictures");
  fs::rename(moved / "masks", moved / "ids");
  source["photos"] = "pictures";
  source["masks"] = "ids";
  write_json(moved / "scene.json", source);
  train(moved, "960");
  expect_photos_in(moved / "pictures", moved / "ids");
  EXPECT_EQ(sha256_of_file(folder / "960/results.json"), trained) << "nothing is trained again";

  train(moved, "40");
  EXPECT_EQ(sha256_of_file(folder / "40/transforms.json"), of_scaled) << "scaled photos and masks are its own";
  EXPECT_EQ(read_json(folder / "40/scene.json")["photos"], "photos");
  EXPECT_EQ(read_json(folder / "40/scene.json")["masks"], "masks");
}

TEST_F(Reconstruct, APhotoThatIsMissingIsNamedAndWhereItWasLookedFor) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 4);
  fs::remove(folder / "set/photos/v11.png");
  std::string all;
  for (const std::string& warning : read_photo_cameras(find_photo_set(folder / "set")).warnings) all += warning + "\n";
  for (const std::string& words : {std::string("1 of 4 frames name photos that do not exist"),
                                   "'photos/v11.png' was looked for in " + (folder / "set").string(),
                                   "beside " + (folder / "set/transforms.json").string()})
    EXPECT_NE(all.find(words), std::string::npos) << words << " in " << all;
  fs::rename(folder / "set/photos", folder / "pictures");
  expect_error(
      Failure::kInput,
      {"none of which was found", "'photos/v10.png' was looked for in " + (folder / "set").string(), "--photos"},
      [&] { read_photo_cameras(find_photo_set(folder / "set")); });
  EXPECT_EQ(read_photo_cameras(find_photo_set(folder / "set", folder / "pictures")).cameras.size(), 3u);
}

}  // namespace
}  // namespace pliant
