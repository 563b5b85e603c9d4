// Scenes: scene.json, model folders, where up comes from, descriptions, and what is refused.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gaussians/base/random.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/photo.h"
#include "gaussians/io/scene/describe.h"
#include "gaussians/io/scene/scene.h"
#include "gaussians/io/scene/up_direction.h"
#include "gaussians/io/splats/ply.h"
#include "tests/gaussians/photo_files.h"
#include "tests/temporary_folder.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

GaussianCloud ball(int n, const Vec3f& centre, float radius) {
  GaussianCloud cloud;
  cloud.resize(n);
  Random random(4);
  for (int i = 0; i < n; ++i) {
    Vec3f x;
    do {
      for (int k = 0; k < 3; ++k) x[k] = random.uniform(-1, 1);
    } while (x.norm() > 1);
    cloud.position[i] = centre + radius * x;
    cloud.opacity_logit[i] = 2;
    cloud.log_scale[i] = Vec3f::Constant(-4);
  }
  return cloud;
}

/// A rough floor through the origin with normal `up`, a ball on it and some dirt below.
GaussianCloud ball_on_floor(const Vec3f& up) {
  GaussianCloud cloud = ball(1500, 0.5f * up, 0.45f);
  const Vec3f a = up.unitOrthogonal(), b = up.cross(a);
  Random random(5);
  const int first = static_cast<int>(cloud.size());
  cloud.resize(first + 3100);
  for (int i = first; i < static_cast<int>(cloud.size()); ++i) {
    cloud.position[i] = 2 * a * random.uniform(-1, 1) + 2 * b * random.uniform(-1, 1) + up * 0.01 * random.normal();
    if (i >= first + 3000) cloud.position[i] -= up * random.uniform(0, 1);
    cloud.opacity_logit[i] = 2;
  }
  return cloud;
}

TEST(UpDirection, OfASupportPlanePointsToWhatStandsOnIt) {
  for (const Vec3f& up : {Vec3f(0, 0, 1), Vec3f(0, -1, 0), Vec3f(0, 1, 0), Vec3f(0.3f, -0.5f, 0.7f)}) {
    const auto found = up_of_support_plane(ball_on_floor(up.normalized()));
    ASSERT_TRUE(found);
    EXPECT_GT(found->up.dot(up.normalized().cast<double>()), std::cos(1.5 * M_PI / 180)) << found->up.transpose();
  }
}

TEST(UpDirection, IsNotGuessedFromARoundThing) { EXPECT_FALSE(up_of_support_plane(ball(3000, Vec3f::Zero(), 1))); }

/// A cone on its base, its tip in the direction `sign` * y.
GaussianCloud cone(float sign) {
  GaussianCloud cloud;
  cloud.resize(4000);
  Random random(6);
  for (Vec3f& x : cloud.position) {
    const float height = 1 - std::cbrt(random.uniform(0, 1)),
                radius = 0.5f * (1 - height) * std::sqrt(random.uniform(0, 1));
    const float angle = random.uniform(0, 2 * M_PI);
    x = Vec3f(radius * std::cos(angle), sign * height, radius * std::sin(angle));
  }
  cloud.log_scale.assign(4000, Vec3f::Constant(-4));
  cloud.opacity_logit.assign(4000, 2);
  return cloud;
}

TEST(UpDirection, OfAThingWithoutAGroundIsTheEndOfYOnWhichItCouldStand) {
  EXPECT_EQ(up_of_cloud(cone(1)).up, Eigen::Vector3d(0, 1, 0));
  EXPECT_EQ(up_of_cloud(cone(-1)).up, Eigen::Vector3d(0, -1, 0));
  EXPECT_EQ(up_of_cloud(ball(2000, {0, 0, 0}, 1)).up, Eigen::Vector3d(0, -1, 0));
}

TEST(UpDirection, IsZWhereTheFileDeclaresSoUnlessAPlaneNearItIsFound) {
  EXPECT_EQ(up_of_cloud(cone(1), true).up, Eigen::Vector3d(0, 0, 1));
  const TemporaryFolder folder;
  for (const bool declared : {false, true}) {
    write_ply(folder / "a.ply", ball(600, {0, 0, 0}, 1));
    std::string text = read_text(folder / "a.ply");
    if (declared) text.insert(text.find("element"), "comment Vertical Axis: z\n");
    write_text(folder / "a.ply", text);
    EXPECT_EQ(load_scene(folder / "a.ply").up, declared ? Eigen::Vector3d(0, 0, 1) : Eigen::Vector3d(0, -1, 0));
  }
}

/// A flat thing that stands upright: a board of 2 x 0.5 x 0.04 with a foot in front of it.
TEST(UpDirection, IsNotTheNormalOfTheFlatSideOfAThing) {
  GaussianCloud cloud;
  cloud.resize(3300);
  Random random(7);
  for (size_t i = 0; i < cloud.size(); ++i) {
    cloud.position[i] = i < 3000
                            ? Vec3f(random.uniform(-0.02, 0.02), random.uniform(-2, 0), random.uniform(-0.25, 0.25))
                            : Vec3f(random.uniform(0, 0.5), random.uniform(-0.1, 0), random.uniform(-0.25, 0.25));
  }
  cloud.log_scale.assign(cloud.size(), Vec3f::Constant(-4));
  cloud.opacity_logit.assign(cloud.size(), 2);
  EXPECT_FALSE(up_of_support_plane(cloud));
  EXPECT_EQ(up_of_cloud(cloud).up, Eigen::Vector3d(0, -1, 0));
}

/// A plant on a table of 1 x 1: a stem, whose crown is nearly as wide as the table.
TEST(UpDirection, OfATableIsItsNormalAlsoUnderACrownThatOverhangs) {
  for (const Vec3f& up : {Vec3f(0, 0, 1), Vec3f(1, 0, 0)}) {
    GaussianCloud cloud = ball(1500, 0.8f * up, 0.6f);
    const Vec3f a = up.unitOrthogonal(), b = up.cross(a);
    Random random(8);
    cloud.resize(4800);
    for (size_t i = 1500; i < cloud.size(); ++i) {
      const float x = static_cast<float>(random.uniform(-0.5, 0.5)), y = static_cast<float>(random.uniform(-0.5, 0.5));
      cloud.position[i] =
          i < 1800 ? Vec3f(0.05f * (x * a + y * b) + up * random.uniform(0, 0.3)) : Vec3f(x * a + y * b);
      cloud.log_scale[i] = Vec3f::Constant(-4);
      cloud.opacity_logit[i] = 2;
    }
    EXPECT_GT(up_of_cloud(cloud).up.dot(up.cast<double>()), 0.999) << up.transpose();
  }
}

TEST(UpDirection, AxesHaveNames) {
  EXPECT_EQ(axis_of_name("x"), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(axis_of_name("-y"), Eigen::Vector3d(0, -1, 0));
  EXPECT_EQ(axis_of_name("z"), Eigen::Vector3d(0, 0, 1));
  for (const char* wrong : {"", "-", "w", "--z", "xy", "0,0,1", "Z"}) EXPECT_FALSE(axis_of_name(wrong)) << wrong;
}

constexpr double kDegree = M_PI / 180;

/// Cameras of a world whose z is up, at headings over `arc` degrees and `pitch` degrees below the horizon, with normal
/// deviations of heading, pitch and roll in degrees.
struct Ring {
  int count = 40;
  double arc = 360, pitch = 25, heading_noise = 0, pitch_noise = 0, roll_noise = 0;
};

std::vector<Camera> ring_cameras(const Ring& ring, uint64_t seed = 3) {
  Random random(seed);
  std::vector<Camera> cameras(ring.count);
  for (int i = 0; i < ring.count; ++i) {
    const double heading = kDegree * (ring.arc * i / ring.count + ring.heading_noise * random.normal()),
                 pitch = kDegree * (ring.pitch + ring.pitch_noise * random.normal()),
                 roll = kDegree * ring.roll_noise * random.normal();
    const Eigen::Vector3d ahead(std::cos(heading), std::sin(heading), 0), right(ahead.y(), -ahead.x(), 0);
    const Eigen::Vector3d forward = std::cos(pitch) * ahead - std::sin(pitch) * Eigen::Vector3d::UnitZ(),
                          down = forward.cross(right);
    cameras[i].cam_from_world.linear().row(0) = std::cos(roll) * right + std::sin(roll) * down;
    cameras[i].cam_from_world.linear().row(1) = std::cos(roll) * down - std::sin(roll) * right;
    cameras[i].cam_from_world.linear().row(2) = forward;
  }
  return cameras;
}

/// Angle in degrees between the up that is found and that of the world.
double error_of_up(const std::vector<Camera>& cameras, const std::string& source) {
  const auto found = up_of_cameras(cameras);
  if (!found) return 180;
  EXPECT_NE(found->source.find(source), std::string::npos) << found->source;
  EXPECT_NEAR(found->up.norm(), 1, 1e-12);
  return std::acos(std::clamp(found->up.z(), -1.0, 1.0)) / kDegree;
}

double error_of_mean(const std::vector<Camera>& cameras) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Camera& camera : cameras) mean -= camera.cam_from_world.linear().row(1).transpose();
  return std::acos(mean.normalized().z()) / kDegree;
}

TEST(UpDirection, OfCamerasWithoutRollIsTheVerticalWhateverTheirPitchAndWherever) {
  for (const double arc : {60.0, 120.0, 200.0, 360.0})
    for (const double pitch : {-20.0, 0.0, 25.0, 60.0, 90.0}) {
      if (pitch == 90.0 && arc < 200) continue;  // such pictures could as well be upright and rolled
      EXPECT_LT(error_of_up(ring_cameras({.arc = arc, .pitch = pitch, .pitch_noise = pitch == 90 ? 3.0 : 8.0}), "rows"),
                1e-5)
          << arc << " " << pitch;
    }
  EXPECT_GT(error_of_mean(ring_cameras({.arc = 120})), 15);
  EXPECT_FALSE(up_of_cameras(ring_cameras({.count = 2})));
}

TEST(UpDirection, OfCamerasThatAreRolledALittleIsNearTheVertical) {
  for (uint64_t seed = 0; seed < 50; ++seed) {
    // Three standard deviations of roll / sqrt(n / 2), the rows being spread over two directions.
    const double bound = 3 * 2 / std::sqrt(20.0);
    EXPECT_LT(error_of_up(ring_cameras({.roll_noise = 2}, seed), "rows"), bound);
    EXPECT_LT(error_of_up(ring_cameras({.arc = 120, .roll_noise = 2}, seed), "rows"), 2 * bound);
    EXPECT_LT(error_of_up(ring_cameras({.pitch = 90, .pitch_noise = 3, .roll_noise = 2}, seed), "rows"), bound);
  }
  EXPECT_LT(error_of_up(ring_cameras({.roll_noise = 2}), "rows"), 1);
}

TEST(UpDirection, OfCamerasThatAllLookOneWayIsTheirMeanPictureUp) {
  for (uint64_t seed = 0; seed < 50; ++seed) {
    // Rows that are nearly the same do not tell a plane, and those of rolled cameras tell that of the pictures.
    for (const Ring& ring : {Ring{.arc = 0, .pitch = 10, .heading_noise = 3, .pitch_noise = 3, .roll_noise = 1},
                             Ring{.count = 5, .arc = 0, .pitch = 10, .heading_noise = 3, .roll_noise = 1},
                             Ring{.arc = 0, .pitch = 10, .heading_noise = 1, .pitch_noise = 1, .roll_noise = 15}}) {
      const std::vector<Camera> cameras = ring_cameras(ring, seed);
      EXPECT_NEAR(error_of_up(cameras, "mean up"), error_of_mean(cameras), 1e-5);
    }
  }
  // Held any way round, cameras tell nothing.
  EXPECT_FALSE(up_of_cameras(ring_cameras({.roll_noise = 1000})));
}

TEST(UpDirection, OfCamerasFollowsTheOrientationFlagsOfPhotosAsTheyAreStored) {
  const TemporaryFolder folder;
  const std::string jpeg = encoded(".jpg", picture_of(48, 32, [](int x, int y, int) { return x + y; }));
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const std::string photo = folder.file("a.jpg", with_orientation(jpeg, orientation, true)).string();
    std::vector<Camera> stored = ring_cameras({.arc = 120}), upright = stored;
    for (Camera& camera : stored) {
      const Eigen::Matrix<double, 2, 3> right_down = camera.cam_from_world.linear().topRows<2>();
      camera.cam_from_world.linear().topRows<2>() =
          stored_from_upright(orientation).cast<double>() * right_down;  // its inverse is its transpose
      camera.photo = photo;
      camera.width = 48;
      camera.height = 32;
    }
    EXPECT_LT(error_of_up(stored, "rows"), 1e-5) << orientation;
    // Cameras of pictures that were turned before do not follow the flag.
    for (Camera& camera : upright) {
      camera.photo = photo;
      camera.width = 32;
      camera.height = 48;
    }
    EXPECT_LT(error_of_up(upright, "rows"), 1e-5) << orientation;
  }
}

TEST(Scene, UpComesFromOptionThenFileThenCamerasThenPlaneThenMinusY) {
  const TemporaryFolder folder;
  write_ply(folder / "s.ply", ball_on_floor({1, 0, 0}));
  EXPECT_GT(load_scene(folder / "s.ply").up.x(), 0.999);
  EXPECT_NE(load_scene(folder / "s.ply").up_source.find("plane"), std::string::npos);
  std::vector<Camera> cameras;
  for (int i = 0; i < 4; ++i) {
    cameras.push_back(look_at({3.0, 1.0 * i, 2}, {0, 0, 0}, {0, 0, 1}, 40, 30, 30));
    cameras.back().name = std::to_string(i);
  }
  write_transforms(folder / "transforms.json", cameras);
  Scene scene = load_scene(folder / "s.ply");
  EXPECT_EQ(scene.cameras.size(), 4u);
  EXPECT_FALSE(scene.cameras_are_orbit);
  EXPECT_GT(scene.up.z(), 0.999);
  folder.file("scene.json", R"({"splats": "s.ply", "up": [0, 2, 0]})");
  EXPECT_EQ(load_scene(folder.path()).up, Eigen::Vector3d(0, 1, 0));
  LoadOptions options;
  options.up = Eigen::Vector3d(0, 0, -3);
  EXPECT_EQ(load_scene(folder.path(), options).up, Eigen::Vector3d(0, 0, -1));
  write_ply(folder / "alone/ball.ply", ball(500, {0, 0, 0}, 1));
  scene = load_scene(folder / "alone/ball.ply");
  EXPECT_EQ(scene.up, Eigen::Vector3d(0, -1, 0));
  EXPECT_NE(scene.up_source.find("-y"), std::string::npos);
  EXPECT_TRUE(scene.cameras_are_orbit);
  EXPECT_EQ(scene.cameras.size(), 24u);
}

TEST(Scene, IsAntialiasedByOptionThenFileThenSplats) {
  const TemporaryFolder folder;
  for (const bool marked : {false, true}) {
    write_ply(folder / "s.ply", ball(100, {0, 0, 0}, 1), marked);
    const auto antialiased = [&](const std::string& said, bool option) {
      folder.file("scene.json", R"({"splats": "s.ply")" + said + "}");
      LoadOptions options;
      options.antialiased = option;
      return load_scene(folder.path(), options).report.antialiased;
    };
    EXPECT_EQ(antialiased("", false), marked);
    EXPECT_TRUE(antialiased(R"(, "antialiased": true)", false));
    EXPECT_FALSE(antialiased(R"(, "antialiased": false)", false));
    EXPECT_TRUE(antialiased(R"(, "antialiased": false)", true));
    EXPECT_TRUE(antialiased("", true));
  }
}

TEST(Scene, OfAModelFolderIsItsLastIteration) {
  const TemporaryFolder folder;
  write_ply(folder / "point_cloud/iteration_7000/point_cloud.ply", ball(100, {0, 0, 0}, 1));
  write_ply(folder / "point_cloud/iteration_30000/point_cloud.ply", ball(200, {0, 0, 0}, 1));
  fs::create_directories(folder / "point_cloud/iteration_90000");
  EXPECT_EQ(load_scene(folder.path()).cloud.size(), 200u);
}

TEST(SceneFile, EveryKeyIsRead) {
  const TemporaryFolder folder;
  write_ply(folder / "splats/s.ply", ball(100, {0, 0, 0}, 1));
  fs::create_directories(folder / "masks");
  const SceneFile scene = read_scene_file(folder.file("scene.json", R"({"splats": "splats/s.ply", "masks": "masks",
    "video": {"file": "v.mp4", "camera": "view_3", "fps": 24}, "up": [0, 0, 2], "metres_per_unit": 0.5,
    "support": "table", "object": "flower", "pinned": [{"box": [0, 0, 0, 1, 2, 3]}, {"sphere": [1, 1, 1, 0.5]}],
    "material": {"young": 2e5, "poisson": 0.3, "density": 900}, "antialiased": true, "background": [1, 0.5, 0]})"));
  EXPECT_EQ(scene.splats, folder / "splats/s.ply");
  EXPECT_EQ(scene.masks, folder / "masks");
  EXPECT_EQ(scene.video->camera, "view_3");
  EXPECT_EQ(scene.video->file, folder / "v.mp4");
  EXPECT_EQ(*scene.up, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(scene.metres_per_unit, 0.5);
  EXPECT_EQ(scene.support + scene.object, "tableflower");
  ASSERT_EQ(scene.pinned.size(), 2u);
  EXPECT_TRUE(scene.pinned[0].contains({0.5f, 1.5f, 2.5f}));
  EXPECT_FALSE(scene.pinned[0].contains({0.5f, 2.5f, 2.5f}));
  EXPECT_TRUE(scene.pinned[1].contains({1.4f, 1, 1}));
  EXPECT_FALSE(scene.pinned[1].contains({1.4f, 1.4f, 1}));
  EXPECT_EQ(scene.material.young, 2e5);
  EXPECT_EQ(scene.material.poisson, 0.3);
  EXPECT_EQ(scene.material.density, 900);
  EXPECT_EQ(scene.antialiased, true);
  EXPECT_EQ(scene.background_color(), Vec3f(1, 0.5f, 0));
  EXPECT_EQ(SceneFile().background_color(), Vec3f(0, 0, 0));
  EXPECT_EQ(*read_scene_file(folder.file("scene.json", R"({"up": "-y"})")).up, Eigen::Vector3d(0, -1, 0));
}

TEST(SceneFile, PathsLeadUpFromWhereALinkLeads) {
  const TemporaryFolder folder;
  for (const char* name : {"real/deep/disk", "home/photos"}) fs::create_directories(folder / name);
  fs::create_directory_symlink(folder / "real/deep/disk", folder / "scratch");
  folder.file("real/deep/disk/scene.json", R"({"photos": "../../../home/./photos"})");
  EXPECT_TRUE(fs::equivalent(read_scene_file(folder / "scratch/scene.json").photos, folder / "home/photos"));
  EXPECT_EQ(read_scene_file(folder / "real/deep/disk/scene.json").photos, folder / "home/photos");
}

TEST(SceneFile, UnknownKeysAndImpossibleValuesAreNamed) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& text, std::vector<std::string> words, Failure failure = Failure::kUsage) {
    SCOPED_TRACE(text);
    const auto path = folder.file("scene.json", text);
    words.push_back("scene.json");
    expect_error(failure, words, [&] { read_scene_file(path); });
  };
  refused(R"({"splat": "a.ply"})", {"splat", "did you mean 'splats'"});
  refused(R"({"material": {"yung": 3}})", {"material.yung", "'young'"});
  refused(R"({"material": {"young": -3}})", {"material.young", "-3"});
  refused(R"({"material": {"young": "soft"}})", {"material.young", "soft"});
  refused(R"({"material": {"poisson": 0.5}})", {"material.poisson", "0.5"});
  refused(R"({"material": {"poisson": -1}})", {"material.poisson"});
  refused(R"({"material": {"density": 0}})", {"material.density"});
  refused(R"({"material": 3})", {"material", "object"});
  refused(R"({"metres_per_unit": 0})", {"metres_per_unit"});
  refused(R"({"up": [0, 0, 0]})", {"up", "zero"});
  refused(R"({"up": [0, 0]})", {"up", "3 numbers"});
  refused(R"({"up": "upwards"})", {"up", "upwards", "-z"});
  refused(R"({"up": [0, 0, null]})", {"up", "null"});
  refused(R"({"pinned": [{"box": [0, 0, 0, 1, 1]}]})", {"pinned[0].box"});
  refused(R"({"pinned": [{"box": [2, 0, 0, 1, 1, 1]}]})", {"pinned[0].box", "corner"});
  refused(R"({"pinned": [{"box": [0, 0, 0, 1, 1, 0]}]})", {"pinned[0].box", "corner", "volume"});
  refused(R"({"pinned": [{"sphere": [0, 0, 0, -1]}]})", {"pinned[0].sphere", "positive"});
  refused(R"({"pinned": [{}]})", {"pinned[0]"});
  refused(R"({"pinned": {}})", {"pinned", "array"});
  refused(R"({"video": {"file": "v.mp4"}})", {"video.camera", "missing"});
  refused(R"({"antialiased": 1})", {"antialiased", "1", "true or false"});
  refused(R"({"background": [0, 0]})", {"background", "3 numbers"});
  refused(R"({"background": [0, 255, 0]})", {"background", "0..1"});
  refused(R"({"background": [0, -0.1, 0]})", {"background", "0..1"});
  refused(R"([1])", {"object"});
  refused(R"({"splats": "none.ply"})", {"splats", "none.ply", "does not exist"}, Failure::kInput);
  refused("{", {"JSON"}, Failure::kInput);
  refused(R"({"metres_per_unit": 1e999})", {"JSON"}, Failure::kInput);
}

TEST(Scene, WhatCannotBeLoadedIsNamed) {
  const TemporaryFolder folder;
  expect_error(Failure::kInput, {"nowhere", "does not exist"}, [&] { load_scene(folder / "nowhere"); });
  expect_error(Failure::kInput, {"scene.json", "point_cloud"}, [&] { load_scene(folder.path()); });
  expect_error(Failure::kInput, {"a.spz", "damaged"}, [&] { load_scene(folder.file("a.spz", "x")); });
  write_ply(folder / "empty.ply", GaussianCloud());
  expect_error(Failure::kInput, {"empty.ply", "no usable Gaussian"}, [&] { load_scene(folder / "empty.ply"); });
  folder.file("scene.json", "{}");
  expect_error(Failure::kInput, {"splats", "missing"}, [&] { load_scene(folder.path()); });
  write_ply(folder / "s.ply", ball(10, {0, 0, 0}, 1));
  LoadOptions options;
  options.metres_per_unit = -1;
  expect_error(Failure::kUsage, {"metres_per_unit", "-1"}, [&] { load_scene(folder / "s.ply", options); });
}

TEST(Scene, TheScaleIsAssumedUnlessALengthIsGiven) {
  const TemporaryFolder folder;
  write_ply(folder / "s.ply", ball(100, {0, 0, 0}, 1));
  EXPECT_TRUE(load_scene(folder / "s.ply").scale_is_assumed);
  EXPECT_NE(describe(folder.path())["warnings"].dump().find("scale of the scene is unknown"), std::string::npos);
  LoadOptions options;
  options.object_height = 0.4;
  EXPECT_FALSE(load_scene(folder / "s.ply", options).scale_is_assumed);
  options = {.metres_per_unit = 1};
  EXPECT_FALSE(load_scene(folder / "s.ply", options).scale_is_assumed);
  folder.file("scene.json", R"({"splats": "s.ply", "metres_per_unit": 1})");
  EXPECT_FALSE(load_scene(folder.path()).scale_is_assumed);
  EXPECT_EQ(describe(folder.path())["warnings"].dump().find("scale of the scene"), std::string::npos);
}

TEST(Describe, CountsBoundsAndOpacitiesOfSplatsCamerasAndScenes) {
  const TemporaryFolder folder;
  GaussianCloud cloud = ball(1000, {1, 2, 3}, 1);
  cloud.opacity_logit.assign(1000, 0.0f);
  cloud.position[0] = Vec3f(50, 2, 3);
  write_ply(folder / "s.ply", cloud);
  const json splats = describe(folder / "s.ply");
  EXPECT_EQ(splats["kind"], "splats");
  EXPECT_EQ(splats["splats"]["gaussians"], 1000);
  EXPECT_EQ(splats["splats"]["opacity"]["mean"], 0.5);
  EXPECT_EQ(splats["splats"]["bounds"]["high"][0], 50);
  EXPECT_LT(splats["splats"]["bounds_2_98"]["high"][0], 2.0);
  write_transforms(folder / "transforms.json", {look_at({3, 0, 0}, {0, 0, 0}, {0, 0, 1}, 40, 30, 33)});
  EXPECT_THROW(describe(folder / "transforms.json"), Error);  // a camera without a name
  Camera camera = look_at({3, 0, 0}, {0, 0, 0}, {0, 0, 1}, 40, 30, 33);
  camera.name = "a";
  write_transforms(folder / "transforms.json", {camera});
  EXPECT_EQ(describe(folder / "transforms.json")["cameras"]["focal"], json({33, 33}));
  folder.file("scene.json", R"({"splats": "s.ply", "object": "ball"})");
  const json scene = describe(folder.path());
  EXPECT_EQ(scene["kind"], "scene");
  EXPECT_EQ(scene["settings"]["object"], "ball");
  EXPECT_EQ(scene["cameras"]["count"], 1);
  EXPECT_NE(description_text(scene).find("  gaussians: 1000\n"), std::string::npos);
  expect_error(Failure::kInput, {"a.txt"}, [&] { describe(folder.file("a.txt", "")); });
}

}  // namespace
}  // namespace pliant
