// Poses against photos: every reading that people mix up is found and can be undone, and what no reading mends is said.

#include "gaussians/reconstruct/check_poses.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "gaussians/base/lens.h"
#include "tests/gaussians/photo_files.h"
#include "tests/gaussians/textured_scene.h"

namespace pliant {
namespace {

TrainingPhotos with_cameras(TrainingPhotos photos, const std::vector<Camera>& cameras) {
  for (size_t i = 0; i < cameras.size(); ++i) photos.photos[i].camera = cameras[i];
  return photos;
}

/// What a reader makes of cameras whose file was written in another convention.
std::vector<Camera> misread(PoseConvention convention, bool opengl, std::vector<Camera> cameras) {
  for (Camera& camera : cameras) {
    // The matrix that is due in the file, and the one that is there.
    const Eigen::Matrix4d flip = Eigen::Vector4d(1, -1, -1, 1).asDiagonal();
    const Eigen::Matrix4d cam_from_world = camera.cam_from_world.matrix();
    const bool inverse = convention == PoseConvention::kInverse || convention == PoseConvention::kInverseFlipped;
    const bool flipped = convention == PoseConvention::kFlipped || convention == PoseConvention::kInverseFlipped;
    Eigen::Matrix4d stored = flipped != opengl ? Eigen::Matrix4d(flip * cam_from_world) : cam_from_world;
    if (inverse != opengl) stored = stored.inverse().eval();
    // What the reader does.
    if (opengl) stored = (flip * stored.inverse()).eval();
    camera.cam_from_world.matrix() = stored;
  }
  return cameras;
}

SparsePoints observed_points(const std::vector<Camera>& cameras) {
  SparsePoints points;
  Random random(6);
  for (int p = 0; p < 100; ++p) {
    points.position.push_back(
        Vec3d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5)).cast<float>());
    for (size_t c = 0; c < cameras.size(); ++c) {
      const Vec2f noise(static_cast<float>(0.3 * random.normal()), static_cast<float>(0.3 * random.normal()));
      points.observations.push_back(
          {p, static_cast<int>(c), project(cameras[c], points.position[p].cast<double>())->cast<float>() + noise});
    }
  }
  points.color.resize(points.position.size(), Vec3f::Ones());
  return points;
}

TEST(PoseConvention, NamesAreReadBack) {
  for (const PoseConvention convention : kPoseConventions)
    EXPECT_EQ(pose_convention_named(name_of(convention)), convention);
  EXPECT_FALSE(pose_convention_named("sideways"));
}

TEST(PoseConvention, AppliedToMisreadCamerasGivesTheTrueOnes) {
  const std::vector<Camera> truth = arc_of_cameras(3);
  for (const PoseConvention convention : kPoseConventions) {
    if (convention == PoseConvention::kTurned) continue;
    for (const bool opengl : {false, true}) {
      const auto cameras =
          apply_convention(convention, opengl ? "transforms.json" : "COLMAP text", misread(convention, opengl, truth));
      for (size_t i = 0; i < truth.size(); ++i) {
        EXPECT_TRUE(cameras[i].cam_from_world.isApprox(truth[i].cam_from_world, 1e-9)) << name_of(convention) << opengl;
      }
    }
  }
}

TEST(PoseConvention, UndoneGivesTheCamerasAsGiven) {
  const std::vector<Camera> given = arc_of_cameras(3);
  for (const PoseConvention convention : kPoseConventions) {
    for (const char* format : {"transforms.json", "COLMAP text"}) {
      const auto cameras = undo_convention(convention, format, apply_convention(convention, format, given));
      for (size_t i = 0; i < given.size(); ++i) {
        EXPECT_TRUE(cameras[i].cam_from_world.isApprox(given[i].cam_from_world, 1e-9)) << name_of(convention) << format;
        EXPECT_DOUBLE_EQ(cameras[i].cx, given[i].cx);
        EXPECT_DOUBLE_EQ(cameras[i].cy, given[i].cy);
      }
    }
  }
}

TEST(PoseConvention, TurnedCamerasSeePointsOnTheTurnedPhoto) {
  Camera camera = arc_of_cameras(1)[0];
  camera.distortion = {0.1, -0.05, 0.01, -0.02, 0, 0};
  const Camera turned = apply_convention(PoseConvention::kTurned, "COLMAP text", {camera})[0];
  const Eigen::Vector3d point(0.3, -0.2, 0.1);
  EXPECT_NEAR((*project(camera, point) + *project(turned, point) - Eigen::Vector2d(320, 240)).norm(), 0, 1e-9);
}

TEST(CheckPoses, ByPointsFindsEveryMisreading) {
  const std::vector<Camera> truth = arc_of_cameras(6);
  const SparsePoints points = observed_points(truth);
  const TrainingPhotos photos = with_cameras({std::vector<TrainingPhoto>(6), false, {}}, truth);
  const PoseReport report = check_poses({}, camera_file(truth), photos, points);
  EXPECT_EQ(report.points.checked, 600);
  EXPECT_GT(report.points.fits[0].share, 0.9);
  EXPECT_NEAR(report.points.fits[0].error, 0.3 * 1.1774, 0.04);  // the median of a Rayleigh distribution
  EXPECT_TRUE(report.warnings.empty());
  EXPECT_NE(report.sentence.find("100 % of 600 observations"), std::string::npos) << report.sentence;
  for (const PoseConvention convention : kPoseConventions) {
    if (convention == PoseConvention::kAsGiven) continue;
    for (const bool opengl : {false, true}) {
      SCOPED_TRACE(name_of(convention));
      std::vector<Camera> wrong = misread(convention, opengl, truth);
      if (convention == PoseConvention::kTurned) wrong = apply_convention(convention, "", truth);
      expect_error(Failure::kInput,
                   {"cameras.test", std::string("--pose-convention ") + name_of(convention), "100 % agree", "px"}, [&] {
                     check_poses({}, camera_file(wrong, opengl ? "transforms.json" : "COLMAP text"),
                                 with_cameras(photos, wrong), points);
                   });
    }
  }
}

TEST(CheckPoses, ByFeaturesFindsEveryMisreading) {
  const std::vector<Camera> truth = arc_of_cameras(4);
  const TrainingPhotos photos = photos_of(textured_sheet(), truth);
  const PoseReport report = check_poses({}, camera_file(truth), photos, {});
  EXPECT_TRUE(report.points.fits.empty());
  EXPECT_GT(report.matches.checked, 200);
  EXPECT_GT(report.matches.fits[0].share, 0.9);
  EXPECT_LT(report.matches.fits[0].error, 0.3);
  EXPECT_TRUE(report.warnings.empty());
  for (const PoseConvention convention : kPoseConventions) {
    if (convention == PoseConvention::kAsGiven) continue;
    SCOPED_TRACE(name_of(convention));
    std::vector<Camera> wrong = misread(convention, true, truth);
    if (convention == PoseConvention::kTurned) wrong = apply_convention(convention, "", truth);
    expect_error(Failure::kInput,
                 {"cameras.test", std::string("--pose-convention ") + name_of(convention), "feature matches", "px"},
                 [&] { check_poses({}, camera_file(wrong, "transforms.json"), with_cameras(photos, wrong), {}); });
  }
}

/// Points that were found in the photos before they were turned agree with the poses; the pixels do not.
TEST(CheckPoses, FindPhotosThatWereTurnedAfterTheirPointsWereFound) {
  const std::vector<Camera> truth = arc_of_cameras(5);
  TrainingPhotos photos = photos_of(textured_sheet(), truth);
  for (TrainingPhoto& photo : photos.photos) {
    const ImageU8 upright = photo.pixels;
    for (int y = 0; y < upright.height; ++y) {
      for (int x = 0; x < upright.width; ++x) std::copy_n(upright.at(x, y), 3, photo.pixels.at(319 - x, 239 - y));
    }
  }
  expect_error(Failure::kInput, {"upside down", "--pose-convention turned", "feature matches"},
               [&] { check_poses({}, camera_file(truth), photos, observed_points(truth)); });
}

/// The cameras as a COLMAP text model with points that all of them see.
void write_model(const TemporaryFolder& folder, const std::vector<Camera>& cameras, const SparsePoints& points) {
  const auto text = [](const char* format, auto... values) {
    char line[400];
    std::snprintf(line, sizeof line, format, values...);
    return std::string(line);
  };
  std::string lenses, images, rows;
  std::vector<std::string> tracks(points.position.size());
  for (size_t c = 0; c < cameras.size(); ++c) {
    const Camera& k = cameras[c];
    const Eigen::Quaterniond q(k.cam_from_world.linear());
    const Eigen::Vector3d t = k.cam_from_world.translation();
    lenses += text("%zu OPENCV %d %d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", c + 1, k.width, k.height, k.fx,
                   k.fy, k.cx, k.cy, k.distortion[0], k.distortion[1], k.distortion[2], k.distortion[3]);
    images += text("%zu %.17g %.17g %.17g %.17g %.17g %.17g %.17g %zu %s.jpg\n", c + 1, q.w(), q.x(), q.y(), q.z(),
                   t.x(), t.y(), t.z(), c + 1, k.name.c_str());
    for (size_t p = 0; p < tracks.size(); ++p) {
      const Eigen::Vector2d pixel = *project(k, points.position[p].cast<double>());
      images += text("%.9g %.9g %zu ", pixel.x(), pixel.y(), p);
      tracks[p] += text(" %zu %zu", c + 1, p);
    }
    images += "\n";
  }
  for (size_t p = 0; p < tracks.size(); ++p) {
    const Vec3f& x = points.position[p];
    rows += text("%zu %.9g %.9g %.9g 9 9 9 0.5", p, x.x(), x.y(), x.z()) + tracks[p] + "\n";
  }
  folder.file("cameras.txt", lenses);
  folder.file("images.txt", images);
  folder.file("points3D.txt", rows);
}

/// Whoever answers the error about photos that were turned gets the points on the turned photos.
TEST(CheckPoses, PointsOfColmapAgreeWithTheCamerasThatWereTurned) {
  const TemporaryFolder folder;
  std::vector<Camera> model = arc_of_cameras(6);
  for (Camera& camera : model) camera.distortion = {0.1, -0.05, 0.01, -0.02, 0, 0};
  write_model(folder, model, observed_points(model));
  const SparsePoints given = read_sparse_points(folder.path(), model);
  ASSERT_EQ(given.observations.size(), 600u);
  const std::vector<Camera> turned = apply_convention(PoseConvention::kTurned, "COLMAP text", model);
  const SparsePoints points = read_sparse_points(folder.path(), turned);
  ASSERT_EQ(points.observations.size(), 600u);
  for (size_t i = 0; i < 600; ++i) {
    const Vec2f sum = points.observations[i].pixel + given.observations[i].pixel;
    EXPECT_NEAR((sum - Vec2f(320, 240)).norm(), 0, 1e-2) << i;
  }
  std::vector<Camera> pinholes = turned;
  for (Camera& camera : pinholes) camera.distortion = {};
  const PoseReport report = check_poses({.refuse = false}, camera_file(pinholes),
                                        with_cameras({std::vector<TrainingPhoto>(6), false, {}}, pinholes),
                                        read_sparse_points(folder.path(), pinholes));
  EXPECT_EQ(report.points.best, PoseConvention::kAsGiven);
  EXPECT_GT(report.points.fits[0].share, 0.99);
  EXPECT_TRUE(report.warnings.empty());
  // Where the poses are read in another way, the photos show the points where they are.
  const std::vector<Camera> inverse = apply_convention(PoseConvention::kInverse, "COLMAP text", model);
  const SparsePoints seen = read_sparse_points(folder.path(), inverse);
  for (size_t i = 0; i < 600; ++i)
    EXPECT_NEAR((seen.observations[i].pixel - given.observations[i].pixel).norm(), 0, 1e-2) << i;
}

TEST(CheckPoses, WarnOfAnotherReadingWhenTheUserHasChosen) {
  const std::vector<Camera> truth = arc_of_cameras(6), wrong = misread(PoseConvention::kFlipped, false, truth);
  const PoseReport report =
      check_poses({.refuse = false}, camera_file(wrong),
                  with_cameras({std::vector<TrainingPhoto>(6), false, {}}, wrong), observed_points(truth));
  EXPECT_EQ(report.points.best, PoseConvention::kFlipped);
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("axes are flipped"), std::string::npos);
}

TEST(CheckPoses, JudgeTheReadingThatWasChosenAgainstAllOthers) {
  const std::vector<Camera> truth = arc_of_cameras(6);
  for (const char* format : {"transforms.json", "COLMAP text"}) {
    const std::vector<Camera> stored =
        misread(PoseConvention::kFlipped, format == std::string("transforms.json"), truth);
    for (const PoseConvention chosen : kPoseConventions) {
      SCOPED_TRACE(std::string(name_of(chosen)) + " " + format);
      const std::vector<Camera> read = apply_convention(chosen, format, stored);
      const PoseReport report =
          check_poses({.refuse = false, .chosen = chosen}, camera_file(read, format),
                      with_cameras({std::vector<TrainingPhoto>(6), false, {}}, read), observed_points(truth));
      EXPECT_EQ(report.points.best, PoseConvention::kFlipped);
      EXPECT_EQ(report.points.fits[static_cast<size_t>(chosen)].share > 0.9, chosen == PoseConvention::kFlipped);
      ASSERT_EQ(report.warnings.size(), chosen == PoseConvention::kFlipped ? 0u : 1u);
      if (report.warnings.empty()) continue;
      const std::string& said = report.warnings[0];
      EXPECT_NE(said.find(std::string("--pose-convention ") + name_of(chosen) + " was given"), std::string::npos)
          << said;
      EXPECT_NE(said.find("give --pose-convention flipped instead"), std::string::npos) << said;
    }
  }
}

TEST(CheckPoses, WarnOfScenesInsideTheNearPlane) {
  std::vector<Camera> cameras = arc_of_cameras(4);
  TrainingPhotos photos = photos_of(textured_sheet(), cameras);
  for (Camera& camera : cameras) camera.cam_from_world.translation() *= 0.05;
  const PoseReport report = check_poses({}, camera_file(cameras), with_cameras(photos, cameras), {});
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("nothing nearer than 0.2 is rendered"), std::string::npos) << report.warnings[0];
}

TEST(CheckPoses, WarnWhenNoReadingFits) {
  const std::vector<Camera> truth = arc_of_cameras(6);
  std::vector<Camera> shuffled = truth;
  for (int i = 0; i < 6; ++i) shuffled[i] = truth[(i * 5 + 2) % 6];
  for (int i = 0; i < 6; i += 2)
    shuffled[i].cam_from_world.linear() =
        (Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 1, 0).normalized()) * shuffled[i].cam_from_world.linear()).eval();
  const PoseReport report =
      check_poses({}, camera_file(shuffled), with_cameras({std::vector<TrainingPhoto>(6), false, {}}, shuffled),
                  observed_points(truth));
  EXPECT_LT(report.points.fits[0].share, 0.3);
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("may not belong together"), std::string::npos);
}

TEST(CheckPoses, SayThatBlankPhotosCannotBeChecked) {
  TrainingPhotos photos = with_cameras({std::vector<TrainingPhoto>(4), false, {}}, arc_of_cameras(4));
  for (TrainingPhoto& photo : photos.photos) photo.pixels = ImageU8(320, 240, 3, 90);
  const PoseReport report = check_poses({}, camera_file(arc_of_cameras(4)), photos, {});
  EXPECT_EQ(report.matches.checked, 0);
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("could not be checked"), std::string::npos);
}

TEST(CheckPoses, RefuseCamerasAtOnePoint) {
  std::vector<Camera> cameras = arc_of_cameras(5, 0.3);
  for (Camera& camera : cameras)
    camera.cam_from_world.translation() = -camera.cam_from_world.linear() * Eigen::Vector3d(3, -4, 5);
  expect_error(Failure::kInput, {"cameras.test", "all 5 cameras at one point", "walk around"}, [&] {
    check_poses({}, camera_file(cameras), with_cameras({std::vector<TrainingPhoto>(5), false, {}}, cameras), {});
  });
}

TEST(CheckPoses, JudgeCoordinatesAgainstTheirSpread) {
  const std::vector<Camera> truth = arc_of_cameras(5, 0.3);
  const auto moved = [&](double distance) {
    std::vector<Camera> cameras = truth;
    for (Camera& camera : cameras)
      camera.cam_from_world.translation() -= camera.cam_from_world.linear() * Eigen::Vector3d(distance, 0, 0);
    return cameras;
  };
  const auto check = [&](const std::vector<Camera>& cameras, const SparsePoints& points) {
    return check_poses({}, camera_file(cameras), with_cameras({std::vector<TrainingPhoto>(5), false, {}}, cameras),
                       points);
  };
  expect_error(Failure::kInput, {"units from the origin", "common offset"}, [&] { check(moved(5e6), {}); });
  SparsePoints points = observed_points(truth);
  for (Vec3f& p : points.position) p.x() += 5e3f;
  const PoseReport report = check(moved(5e3), points);
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("lose precision"), std::string::npos);
}

TEST(CheckPoses, RefusePrincipalPointsOutsideThePicture) {
  std::vector<Camera> cameras = arc_of_cameras(3);
  for (Camera& camera : cameras) {
    camera.width = 240;
    camera.height = 400;
    camera.cx = 250;
    camera.cy = 120;
  }
  expect_error(Failure::kInput, {"cx, cy", "view_a", "(250, 120)", "240 x 400", "swap cx and cy"}, [&] {
    check_poses({}, camera_file(cameras), with_cameras({std::vector<TrainingPhoto>(3), false, {}}, cameras), {});
  });
}

}  // namespace
}  // namespace pliant
