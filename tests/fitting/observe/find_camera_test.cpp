// The camera of a picture is found among known ones and refined until the scene looks like the picture.

#include "fitting/observe/find_camera.h"

#include <Eigen/Geometry>

#include "tests/gaussians/textured_scene.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

constexpr double kDistance = 2.6;  // of the cameras from the sheet

/// A picture with noise and another exposure.
ImageF photo_of(const GaussianCloud& cloud, const Camera& camera) {
  ImageF picture = render(cloud, camera).color;
  for (size_t i = 0; i < picture.data.size(); ++i)
    picture.data[i] = std::clamp(static_cast<float>(0.93 * picture.data[i] + 0.01 * Random(5, i).normal()), 0.0f, 1.0f);
  return picture;
}

Camera perturbed(const Camera& camera, double degrees, double shift, uint64_t seed) {
  Random random(seed);
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() =
      Eigen::AngleAxisd(degrees * M_PI / 180, Vec3d(random.normal(), random.normal(), random.normal()).normalized())
          .toRotationMatrix();
  motion.translation() = shift * Vec3d(random.normal(), random.normal(), random.normal()).normalized();
  Camera out = camera;
  out.cam_from_world = motion * camera.cam_from_world;
  return out;
}

double degrees_between(const Camera& a, const Camera& b) {
  return 180 / M_PI *
         Eigen::AngleAxisd(a.cam_from_world.linear() * b.cam_from_world.linear().transpose().eval()).angle();
}

TEST(FindCamera, APoseTwoDegreesAndTwoPercentOffIsRecovered) {
  const GaussianCloud cloud = textured_sheet();
  const Camera truth = arc_of_cameras(3)[1].resized(240, 180);
  const ImageF picture = photo_of(cloud, truth);
  for (const uint64_t seed : {1, 2}) {
    const Camera start = perturbed(truth, 2, 0.02 * kDistance, seed);
    const RefinedCamera refined = refine_camera({}, cloud, {}, start, picture);
    EXPECT_LT(degrees_between(refined.camera, truth), 0.2) << refined.renders << " renders";
    EXPECT_LT((refined.camera.centre() - truth.centre()).norm(), 0.003 * kDistance);
    EXPECT_LT(refined.before.score, 0.5);
    EXPECT_GT(refined.after.score, 0.9);
    EXPECT_LT(refined.after.shift, 0.3);
    RecordProperty("microdegrees_" + std::to_string(seed),
                   static_cast<int>(1e6 * degrees_between(refined.camera, truth)));
    RecordProperty("renders_" + std::to_string(seed), refined.renders);
  }
}

TEST(FindCamera, TheRightOneAmongKnownCamerasIsTaken) {
  const GaussianCloud cloud = textured_sheet();
  std::vector<Camera> cameras = arc_of_cameras(5, 0.3);
  for (Camera& camera : cameras) camera = camera.resized(160, 120);
  const Camera truth = perturbed(cameras[3], 1, 0.01 * kDistance, 4);
  FindCameraOptions options;
  options.candidates = 2;
  const FoundCamera found = find_camera(options, cloud, {}, cameras, photo_of(cloud, truth));
  EXPECT_TRUE(found.found);
  EXPECT_EQ(found.nearest, 3);
  EXPECT_LT(degrees_between(found.refined.camera, truth), 0.2);
  EXPECT_NE(found.sentence.find(cameras[3].name), std::string::npos);
}

TEST(FindCamera, APictureOfSomethingElseIsNotFound) {
  const GaussianCloud cloud = textured_sheet(800);
  std::vector<Camera> cameras = arc_of_cameras(3);
  for (Camera& camera : cameras) camera = camera.resized(120, 90);
  FindCameraOptions options;
  options.candidates = 1;
  options.refine.sizes = {64};
  const FoundCamera found = find_camera(options, cloud, {}, cameras, photo_of(textured_sheet(800, 77), cameras[1]));
  EXPECT_FALSE(found.found);
  EXPECT_NE(found.sentence.find("none of the 3"), std::string::npos);
  cameras[0].width = cameras[1].width = cameras[2].width = 300;
  expect_error(Failure::kInput, {"120 x 90", "none of the 3"},
               [&] { find_camera({}, cloud, {}, cameras, ImageF(120, 90, 3)); });
}

}  // namespace
}  // namespace pliant
