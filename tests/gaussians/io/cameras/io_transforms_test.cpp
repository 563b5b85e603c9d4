// Camera files: axes, half pixel, intrinsics per file and per frame, missing photos, and malformed frames.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gaussians/base/orbit.h"
#include "gaussians/base/random.h"
#include "gaussians/io/cameras/cameras_json.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "tests/temporary_folder.h"

using nlohmann::json;
namespace fs = std::filesystem;

namespace pliant {
namespace {

json identity() { return {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}; }

json one_frame() {
  return {{"fl_x", 500},
          {"fl_y", 510},
          {"cx", 330},
          {"cy", 240},
          {"w", 640},
          {"h", 480},
          {"frames", {{{"file_path", "images/a.png"}, {"transform_matrix", identity()}}}}};
}

TEST(Transforms, AnOpenGlCameraLooksAlongMinusZWithYUp) {
  const TemporaryFolder folder;
  json file = one_frame();
  file["frames"][0]["transform_matrix"][0][3] = 2.0;
  const Camera camera = read_transforms(folder.file("t.json", file.dump())).cameras.at(0);
  EXPECT_TRUE(camera.forward().isApprox(Eigen::Vector3d(0, 0, -1)));
  EXPECT_TRUE(camera.centre().isApprox(Eigen::Vector3d(2, 0, 0)));
  const Eigen::Vector3d above = camera.cam_from_world * Eigen::Vector3d(2, 1, -5);
  EXPECT_TRUE(above.isApprox(Eigen::Vector3d(0, -1, 5)));  // y down, z forward
  EXPECT_EQ(camera.name, "a");
}

TEST(Transforms, PrincipalPointIsTakenWithoutAHalfPixelShift) {
  const TemporaryFolder folder;
  const Camera camera = read_transforms(folder.file("t.json", one_frame().dump())).cameras.at(0);
  EXPECT_EQ(camera.cx, 330);
  EXPECT_EQ(camera.cy, 240);
  json file = one_frame();
  file.erase("cx");
  file.erase("cy");
  // The centre of the picture is the corner between the middle pixels.
  EXPECT_EQ(read_transforms(folder.file("t.json", file.dump())).cameras.at(0).cx, 320);
}

TEST(Transforms, ValuesOfAFrameWinOverThoseOfTheFile) {
  const TemporaryFolder folder;
  json file = one_frame();
  file["frames"].push_back(
      {{"file_path", "images/b.png"}, {"transform_matrix", identity()}, {"fl_x", 700}, {"w", 100}, {"h", 50}});
  const std::vector<Camera> cameras = read_transforms(folder.file("t.json", file.dump())).cameras;
  EXPECT_EQ(cameras[0].fx, 500);
  EXPECT_EQ(cameras[1].fx, 700);
  EXPECT_EQ(cameras[1].fy, 510);
  EXPECT_EQ(cameras[1].width, 100);
}

TEST(Transforms, BlenderAngleGivesTheFocalLengthAndThePhotoTheSize) {
  const TemporaryFolder folder;
  write_image(folder / "train/r_0.png", ImageF(80, 60, 3, 0.5f));
  const json file = {{"camera_angle_x", M_PI / 2},
                     {"frames", {{{"file_path", "./train/r_0"}, {"transform_matrix", identity()}}}}};
  const Camera camera = read_transforms(folder.file("t.json", file.dump())).cameras.at(0);
  EXPECT_EQ(camera.width, 80);
  EXPECT_EQ(camera.height, 60);
  EXPECT_NEAR(camera.fx, 40, 1e-12);
  EXPECT_NEAR(camera.fy, 40, 1e-12);
  EXPECT_EQ(camera.photo, (folder / "train/r_0.png").string());
}

TEST(Transforms, TheVerticalAngleCountsWhereTheHorizontalOneDoes) {
  const TemporaryFolder folder;
  json file = {{"w", 100},
               {"h", 80},
               {"camera_angle_x", 1.0},
               {"camera_angle_y", 0.4},
               {"frames", {{{"file_path", "a.png"}, {"transform_matrix", identity()}}}}};
  const auto camera = [&] { return read_transforms(folder.file("t.json", file.dump())).cameras.at(0); };
  EXPECT_NEAR(camera().fx, 50 / std::tan(0.5), 1e-12);
  EXPECT_NEAR(camera().fy, 40 / std::tan(0.2), 1e-12);
  file["fl_x"] = 70;
  EXPECT_EQ(camera().fy, 70);
  file.erase("fl_x");
  file["camera_angle_y"] = 4;
  expect_error(Failure::kUsage, {"camera_angle_y"}, camera);
}

TEST(Transforms, ANumberAfterADotIsNoSuffix) {
  const TemporaryFolder folder;
  json file = one_frame();
  file["frames"].push_back(file["frames"][0]);
  for (int k = 0; k < 2; ++k) file["frames"][k]["file_path"] = "./train/shot.000" + std::to_string(k);
  const std::vector<Camera> cameras = read_transforms(folder.file("t.json", file.dump())).cameras;
  EXPECT_EQ(cameras[0].name, "shot.0000");
  EXPECT_EQ(cameras[1].name, "shot.0001");
}

TEST(Transforms, FramesWithoutPhotosAreLeftOutOnlyWhenSomePhotoExists) {
  const TemporaryFolder folder;
  json file = one_frame();
  file["frames"].push_back({{"file_path", "images/b"}, {"transform_matrix", identity()}});
  const auto path = folder.file("t.json", file.dump());
  const CameraFile without = read_transforms(path);
  EXPECT_EQ(without.cameras.size(), 2u);
  EXPECT_EQ(without.warnings.size(), 1u);
  write_image(folder / "elsewhere/b.jpg", ImageF(640, 480, 3, 0.5f));
  const CameraFile with = read_transforms(path, folder / "elsewhere");
  ASSERT_EQ(with.cameras.size(), 1u);
  EXPECT_EQ(with.cameras[0].name, "b");
  EXPECT_EQ(with.photos_found, 1);
  ASSERT_EQ(with.warnings.size(), 1u);
  EXPECT_NE(with.warnings[0].find("1 of 2"), std::string::npos);
}

TEST(Transforms, CamerasFollowPhotosThatWereScaledAsAWhole) {
  const TemporaryFolder folder;
  const auto path = folder.file("t.json", one_frame().dump());
  write_image(folder / "images/a.png", ImageF(320, 240, 3, 0.5f));
  const CameraFile file = read_transforms(path);
  EXPECT_EQ(file.cameras[0].width, 320);
  EXPECT_EQ(file.cameras[0].fx, 250);
  EXPECT_EQ(file.cameras[0].cx, 165);
  EXPECT_EQ(file.warnings.size(), 1u);
  write_image(folder / "images/a.png", ImageF(320, 100, 3, 0.5f));
  expect_error(Failure::kInput, {"a.png", "320 x 100", "640 x 480"}, [&] { read_transforms(path); });
}

TEST(Transforms, CamerasHaveTheSizeOfThePhotosHoweverItWasRounded) {
  const TemporaryFolder folder;
  json file = one_frame();
  file["w"] = 100;
  file["h"] = 67;
  const auto path = folder.file("t.json", file.dump());
  for (const int height : {33, 34}) {
    write_image(folder / "images/a.png", ImageF(50, height, 3, 0.5f));
    const Camera camera = read_transforms(path).cameras.at(0);
    EXPECT_EQ(camera.width, 50);
    EXPECT_EQ(camera.height, height);
    EXPECT_NEAR(camera.fy, 510.0 * height / 67, 1e-9);
  }
}

TEST(Transforms, EqualStemsTakeTheirFoldersIntoTheName) {
  const TemporaryFolder folder;
  json file = one_frame();
  file["frames"].push_back({{"file_path", "left/a.png"}, {"transform_matrix", identity()}});
  const std::vector<Camera> cameras = read_transforms(folder.file("t.json", file.dump())).cameras;
  EXPECT_EQ(cameras[0].name, "images_a");
  EXPECT_EQ(cameras[1].name, "left_a");
  file["frames"][1]["file_path"] = "images/a.png";
  expect_error(Failure::kInput, {"images/a.png", "two frames"},
               [&] { read_transforms(folder.file("t.json", file.dump())); });
}

TEST(Transforms, WritingAndReadingKeepsEveryCamera) {
  const TemporaryFolder folder;
  std::vector<Camera> cameras;
  Random random(2);
  for (int i = 0; i < 5; ++i) {
    const Eigen::Vector3d eye(random.normal(), random.normal(), random.normal());
    cameras.push_back(look_at(eye * 3, eye * 0.1, {0, 0, 1}, 400, 300, 350 + 10 * i));
    cameras.back().name = "view_" + std::to_string(i);
    cameras.back().cx += 0.25;
    cameras.back().photo = (folder / ("photos/view_" + std::to_string(i) + ".png")).string();
    write_image(cameras.back().photo, ImageF(400, 300, 3, 0.5f));
  }
  write_transforms(folder / "t.json", cameras);
  const CameraFile back = read_transforms(folder / "t.json");
  EXPECT_TRUE(back.warnings.empty());
  ASSERT_EQ(back.cameras.size(), cameras.size());
  for (size_t i = 0; i < cameras.size(); ++i) {
    EXPECT_EQ(back.cameras[i].name, cameras[i].name);
    EXPECT_EQ(back.cameras[i].photo, cameras[i].photo);
    EXPECT_EQ(back.cameras[i].fx, cameras[i].fx);
    EXPECT_EQ(back.cameras[i].cx, cameras[i].cx);
    EXPECT_TRUE(back.cameras[i].cam_from_world.isApprox(cameras[i].cam_from_world, 1e-14));
  }
}

TEST(Transforms, NamesStayWhereTheFileLiesElsewhere) {
  const TemporaryFolder folder;
  json file = one_frame();
  file["frames"].push_back(file["frames"][0]);
  for (int k = 0; k < 2; ++k) {
    const std::string photo = "rig/cam" + std::to_string(k) + "/0000.png";
    write_image(folder / photo, ImageF(64, 48, 3, 0.5f));
    file["frames"][k]["file_path"] = photo;
  }
  const std::vector<Camera> cameras = read_transforms(folder.file("t.json", file.dump())).cameras;
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[1].name, "rig_cam1_0000");
  fs::create_directories(folder / "trained/scene");
  write_transforms(folder / "trained/scene/transforms.json", cameras);
  write_cameras_json(folder / "trained/scene/cameras.json", cameras);
  for (const CameraFile& back : {read_transforms(folder / "trained/scene/transforms.json"),
                                 read_cameras_json(folder / "trained/scene/cameras.json")}) {
    ASSERT_EQ(back.cameras.size(), 2u);
    for (int k = 0; k < 2; ++k) EXPECT_EQ(back.cameras[k].name, cameras[k].name) << back.format;
  }
}

TEST(Transforms, DistortionIsIgnoredWithAWarning) {
  const TemporaryFolder folder;
  json file = one_frame();
  file["k1"] = 0.05;
  file["p1"] = 0.0;
  write_image(folder / "images/a.png", ImageF(640, 480, 3, 0.5f));
  const CameraFile read = read_transforms(folder.file("t.json", file.dump()));
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_NE(read.warnings[0].find("(k1)"), std::string::npos);
}

TEST(Transforms, LensesOfAnotherModelAreRefused) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& pointer, const json& value, const std::string& key) {
    json file = one_frame();
    file[json::json_pointer(pointer)] = value;
    expect_error(Failure::kUsage, {key, "undistort the photos"},
                 [&] { read_transforms(folder.file("t.json", file.dump())); });
  };
  refused("/is_fisheye", true, "is_fisheye");
  refused("/frames/0/is_fisheye", true, "frames[0].is_fisheye");
  refused("/k4", 0.02, "k4");  // of r^8
  refused("/frames/0/k4", 0.02, "frames[0].k4");
  json file = one_frame();
  file["is_fisheye"] = false;
  file["k3"] = 0.01;
  file["k4"] = 0;
  EXPECT_EQ(read_transforms(folder.file("t.json", file.dump())).cameras.at(0).distortion[4], 0.01);
}

TEST(Transforms, MasksOfFramesAreIgnoredWithOneWarning) {
  const TemporaryFolder folder;
  json file = one_frame();
  file["frames"].push_back({{"file_path", "images/b.png"}, {"transform_matrix", identity()}});
  for (json& frame : file["frames"]) frame["mask_path"] = "masks/a.png";
  for (const char* name : {"a", "b"})
    write_image(folder / "images" / (std::string(name) + ".png"), ImageF(640, 480, 3, 0.5f));
  const CameraFile read = read_transforms(folder.file("t.json", file.dump()));
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_NE(read.warnings[0].find("mask_path of 2 frames"), std::string::npos);
}

TEST(Transforms, FramesOfSeveralMomentsAreWarnedOf) {
  const TemporaryFolder folder;
  json file = one_frame();
  file["frames"].push_back({{"file_path", "images/b.png"}, {"transform_matrix", identity()}});
  const auto warned = [&] {
    return json(read_transforms(folder.file("t.json", file.dump())).warnings).dump().find("of 2 moments") !=
           std::string::npos;
  };
  EXPECT_FALSE(warned());
  for (json& frame : file["frames"]) frame["time"] = 0.5;
  EXPECT_FALSE(warned());
  file["frames"][1]["time"] = 1;
  EXPECT_TRUE(warned());
}

TEST(Transforms, AScaledCameraIsTheSamePose) {
  const TemporaryFolder folder;
  json file = one_frame();
  file["frames"][0]["transform_matrix"] = {{0, -0.3, 0, 2}, {0.3, 0, 0, 3}, {0, 0, 0.3, 4}, {0, 0, 0, 1}};
  const Camera scaled = read_transforms(folder.file("t.json", file.dump())).cameras.at(0);
  file["frames"][0]["transform_matrix"] = {{0, -1, 0, 2}, {1, 0, 0, 3}, {0, 0, 1, 4}, {0, 0, 0, 1}};
  const Camera plain = read_transforms(folder.file("t.json", file.dump())).cameras.at(0);
  EXPECT_TRUE(scaled.cam_from_world.isApprox(plain.cam_from_world, 1e-12));
}

TEST(Transforms, PhotosThatDifferByTheirSuffixAloneTakeItIntoTheName) {
  const TemporaryFolder folder;
  json file = one_frame();
  file["frames"].push_back({{"file_path", "./images\\a.jpg"}, {"transform_matrix", identity()}});
  const auto path = folder.file("t.json", file.dump());
  for (const bool photos : {false, true}) {
    for (const char* name : {"images/a.png", "images/a.jpg"})
      if (photos) write_image(folder / name, ImageF(640, 480, 3, 0.5f));
    const std::vector<Camera> cameras = read_transforms(path).cameras;
    ASSERT_EQ(cameras.size(), 2u);
    EXPECT_EQ(cameras[0].name, "images_a_png");
    EXPECT_EQ(cameras[1].name, "images_a_jpg");
  }
  // One photo under two names remains one photo.
  fs::remove(folder / "images/a.jpg");
  file["frames"][1]["file_path"] = "images/a";
  expect_error(Failure::kInput, {"two frames"}, [&] { read_transforms(folder.file("t.json", file.dump())); });
}

TEST(Transforms, MalformedFilesNameFrameAndKey) {
  const TemporaryFolder folder;
  const auto refused = [&](Failure failure, const std::string& text, std::vector<std::string> words) {
    SCOPED_TRACE(text.substr(0, 300));
    const auto path = folder.file("bad.json", text);
    words.push_back("bad.json");
    expect_error(failure, words, [&] { read_transforms(path); });
  };
  const auto changed = [](const std::string& pointer, const json& value) {
    json file = one_frame();
    file[json::json_pointer(pointer)] = value;
    return file.dump();
  };
  refused(Failure::kInput, "", {"not valid JSON"});
  refused(Failure::kInput, one_frame().dump().substr(0, 60), {"not valid JSON"});
  refused(Failure::kUsage, "[]", {"object"});
  refused(Failure::kUsage, "{}", {"frames", "missing"});
  refused(Failure::kUsage, changed("/frames", json::array()), {"frames", "empty"});
  refused(Failure::kUsage, changed("/frames/0", 3), {"frames[0]", "object"});
  refused(Failure::kUsage, changed("/frames/0/file_path", 3), {"frames[0].file_path", "3"});
  refused(Failure::kUsage, changed("/frames/0/transform_matrix", "x"), {"frames[0].transform_matrix"});
  refused(Failure::kUsage, changed("/frames/0/transform_matrix/1", {1, 2}),
          {"frames[0].transform_matrix", "4 numbers"});
  refused(Failure::kUsage, changed("/frames/0/transform_matrix/1/1", nullptr), {"frames[0].transform_matrix", "null"});
  refused(Failure::kUsage, changed("/frames/0/transform_matrix/1/1", 2.0), {"frames[0].transform_matrix", "rotation"});
  refused(Failure::kUsage, changed("/frames/0/transform_matrix/1/1", -1.0), {"frames[0].transform_matrix", "rotation"});
  refused(Failure::kUsage, changed("/frames/0/transform_matrix/3/3", 2.0), {"frames[0].transform_matrix", "last row"});
  refused(Failure::kUsage, changed("/fl_x", -5), {"fl_x", "positive"});
  refused(Failure::kUsage, changed("/fl_x", "wide"), {"fl_x", "wide"});
  refused(Failure::kUsage, changed("/w", 1e9), {"w", "range"});
  refused(Failure::kUsage, changed("/camera_model", "OPENCV_FISHEYE"), {"camera_model", "FISHEYE"});
  json file = one_frame();
  file.erase("fl_x");
  refused(Failure::kUsage, file.dump(), {"fl_x", "camera_angle_x"});
  file = one_frame();
  for (const char* key : {"w", "h", "cx", "cy"}) file.erase(key);
  refused(Failure::kUsage, file.dump(), {"frames[0].w", "missing"});
  std::string nan = one_frame().dump();
  refused(Failure::kInput, nan.replace(nan.find("500"), 3, "NaN"), {"not valid JSON"});
  expect_error(Failure::kInput, {"does not exist"}, [&] { read_transforms(folder / "none.json"); });
  expect_error(Failure::kInput, {"folder"}, [&] { read_transforms(folder.path()); });
}

}  // namespace
}  // namespace pliant
