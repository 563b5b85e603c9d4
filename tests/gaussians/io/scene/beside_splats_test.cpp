// What lies beside splats or stands for them: cameras, photos that were moved, the options of their training, and how
// they are described.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/scene/describe.h"
#include "gaussians/io/scene/scene.h"
#include "gaussians/io/splats/ply.h"
#include "tests/gaussians/format_files.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

Camera named_camera(const std::string& name) {
  Camera camera = look_at({3, 0, 0}, {0, 0, 0}, {0, 0, 1}, 40, 30, 33);
  camera.name = name;
  return camera;
}

TEST(Describe, SplatsAreDescribedWithWhatLiesBesideThem) {
  const TemporaryFolder folder;
  write_ply(folder / "s.ply", some_gaussians(1000, 0));
  EXPECT_EQ(describe(folder / "s.ply")["cameras"]["source"], "automatic orbit");
  write_transforms(folder / "transforms.json", {named_camera("a"), named_camera("b"), named_camera("c")});
  const json found = describe(folder / "s.ply");
  EXPECT_EQ(found["kind"], "splats");
  EXPECT_EQ(found["cameras"]["count"], 3);
  EXPECT_EQ(found["up_source"], load_scene(folder / "s.ply").up_source);
  EXPECT_EQ(found["warnings"], json(load_scene(folder / "s.ply").warnings));
  // What the commands refuse is a warning here.
  GaussianCloud tiny = some_gaussians(1000, 0);
  for (Vec3f& x : tiny.position) x *= 0.01f;
  tiny.log_scale.assign(1000, Vec3f::Constant(-8));
  write_ply(folder / "s.ply", tiny);
  std::vector<Camera> near = {named_camera("a")};
  near[0].cam_from_world.translation() *= 0.02;
  write_transforms(folder / "transforms.json", near);
  EXPECT_THROW(load_scene(folder / "s.ply"), Error);
  const json refused = describe(folder / "s.ply");
  EXPECT_EQ(refused["splats"]["gaussians"], 1000);
  EXPECT_NE(refused["warnings"].dump().find("nothing nearer is rendered"), std::string::npos);
  write_ply(folder / "s.ply", GaussianCloud());
  EXPECT_EQ(describe(folder / "s.ply")["splats"]["gaussians"], 0);
}

TEST(Describe, PhotosWithCamerasAreDescribedWithoutSplats) {
  const TemporaryFolder folder;
  write_transforms(folder / "transforms.json", {named_camera("a"), named_camera("b")});
  for (const char* name : {"a.png", "b.png"}) write_image(folder / name, ImageF(40, 30, 3));
  const auto check = [&](const fs::path& path) {
    const json photos = describe(path);
    EXPECT_EQ(photos["kind"], "photos");
    EXPECT_EQ(photos["cameras"]["count"], 2);
    EXPECT_EQ(photos["cameras"]["photos"], 2);
  };
  check(folder.path());
  EXPECT_THROW(describe(folder.path(), 1), Error);
  folder.file("scene.json", R"({"cameras": "transforms.json", "object": "cup"})");
  check(folder.path());
  check(folder / "scene.json");
  EXPECT_EQ(describe(folder.path())["settings"]["object"], "cup");
}

TEST(Scene, OfAModelThatWasTrainedOnWhiteHasAWhiteBackground) {
  const TemporaryFolder folder;
  write_ply(folder / "point_cloud/iteration_7/point_cloud.ply", some_gaussians(100, 0));
  folder.file("cfg_args", "Namespace(sh_degree=3, white_background=False, eval=True)");
  EXPECT_FALSE(load_scene(folder.path()).settings.background);
  folder.file("cfg_args", "Namespace(sh_degree=3, white_background=True, eval=True)");
  for (const char* path : {"", "point_cloud/iteration_7/point_cloud.ply"}) {
    EXPECT_EQ(load_scene(folder / path).settings.background_color(), Vec3f::Ones());
    EXPECT_NE(describe(folder / path)["settings"]["background_source"].dump().find("cfg_args"), std::string::npos);
  }
  folder.file("scene.json", R"({"splats": "point_cloud/iteration_7/point_cloud.ply", "background": [0, 0, 0]})");
  EXPECT_EQ(load_scene(folder.path()).settings.background_color(), Vec3f::Zero());
  EXPECT_FALSE(describe(folder.path())["settings"].contains("background_source"));
}

TEST(Scene, FindsPhotosThatWereMovedWithIt) {
  for (const char* place : {"/home/them/lego/train/", "C:\\data\\lego\\train\\", "../elsewhere/train/"}) {
    const TemporaryFolder folder;
    write_ply(folder / "s.ply", some_gaussians(100, 0));
    write_transforms(folder / "transforms.json", {named_camera("a"), named_camera("b")});
    json file = json::parse(read_text(folder / "transforms.json"));
    for (json& frame : file["frames"]) frame["file_path"] = place + frame["file_path"].get<std::string>() + ".png";
    write_text(folder / "transforms.json", file.dump());
    for (const char* name : {"train/a.png", "train/b.png"}) write_image(folder / name, ImageF(40, 30, 3));
    for (const fs::path& source : {folder / "s.ply", folder.path()}) {
      const Scene scene = load_scene(source);
      ASSERT_EQ(scene.cameras.size(), 2u);
      EXPECT_EQ(scene.cameras[1].photo, (folder / "train/b.png").string()) << place;
    }
  }
}

}  // namespace
}  // namespace pliant
