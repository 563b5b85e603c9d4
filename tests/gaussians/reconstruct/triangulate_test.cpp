// Features, matches and points from pictures that the program renders of a known cloud.

#include "gaussians/reconstruct/triangulate.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>

#include "gaussians/base/lens.h"
#include "gaussians/base/nearest.h"
#include "tests/gaussians/textured_scene.h"

namespace pliant {
namespace {

std::vector<Vec3d> some_points(int n) {
  std::vector<Vec3d> points;
  Random random(8);
  for (int i = 0; i < n; ++i)
    points.emplace_back(random.uniform(-0.8, 0.8), random.uniform(-0.6, 0.6), random.uniform(-0.5, 0.5));
  return points;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

TEST(Epipolar, MatrixVanishesOnTheTwoImagesOfAPoint) {
  const std::vector<Camera> cameras = arc_of_cameras(2, 0.4);
  const Mat3d F = fundamental_matrix(cameras[0], cameras[1]);
  const Mat3d E = essential_matrix(cameras[0].cam_from_world, cameras[1].cam_from_world);
  for (const Vec3d& point : some_points(20)) {
    const Vec2f u1 = project(cameras[0], point)->cast<float>(), u2 = project(cameras[1], point)->cast<float>();
    EXPECT_LT(sampson_distance(F, u1, u2), 1e-4);
    const Vec3d x1 = cameras[0].cam_from_world * point, x2 = cameras[1].cam_from_world * point;
    EXPECT_NEAR(x2.dot(E * x1), 0, 1e-12);
  }
}

/// Two cameras side by side: partners lie on the same row, and a row too far off is shared by both photos.
TEST(Epipolar, SampsonDistanceOfRowsIsTheDistanceOverRootTwo) {
  Camera left = arc_of_cameras(1)[0], right = left;
  right.cam_from_world.translation().x() -= 0.3;
  EXPECT_NEAR(sampson_distance(fundamental_matrix(left, right), {100, 80}, {70, 83}), 3 / std::sqrt(2.0), 1e-6);
}

TEST(TriangulatePoint, IsExactForExactSightings) {
  const std::vector<Camera> cameras = arc_of_cameras(4);
  for (const Vec3d& truth : some_points(20)) {
    std::vector<Sighting> sightings;
    for (const Camera& camera : cameras) sightings.push_back({&camera, project(camera, truth)->cast<float>()});
    Vec3d point;
    ASSERT_TRUE(triangulate_point(sightings, point));
    EXPECT_NEAR((point - truth).norm(), 0, 1e-6);
  }
}

TEST(TriangulatePoint, MinimisesTheReprojectionError) {
  const std::vector<Camera> cameras = arc_of_cameras(4);
  std::vector<Sighting> sightings;
  Random random(4);
  for (const Camera& camera : cameras) {
    const Vec2f noise(static_cast<float>(random.normal()), static_cast<float>(random.normal()));
    sightings.push_back({&camera, project(camera, {0.1, 0.2, 0.3})->cast<float>() + noise});
  }
  const auto cost = [&](const Vec3d& p) {
    double sum = 0;
    for (const Sighting& s : sightings) sum += (*project(*s.camera, p) - s.pixel.cast<double>()).squaredNorm();
    return sum;
  };
  Vec3d point;
  ASSERT_TRUE(triangulate_point(sightings, point));
  for (int k = 0; k < 3; ++k) {
    for (const double h : {-1e-3, 1e-3}) EXPECT_GT(cost(point + h * Vec3d::Unit(k)), cost(point));
  }
}

TEST(TriangulatePoint, RefusesParallelRaysAndPointsBehind) {
  const std::vector<Camera> cameras = arc_of_cameras(2, 0.4);
  Vec3d point;
  const Sighting parallel[] = {{&cameras[0], {100, 100}}, {&cameras[0], {100, 100}}};
  EXPECT_FALSE(triangulate_point(parallel, point));
  // Rays that part in front of the cameras meet behind them.
  const Sighting parting[] = {{&cameras[0], {10, 120}}, {&cameras[1], {310, 120}}};
  const Sighting meeting[] = {{&cameras[0], {163, 118}}, {&cameras[1], {163, 118}}};
  EXPECT_NE(triangulate_point(parting, point), triangulate_point(meeting, point));
}

TEST(Features, LieWhereTheBlobsAre) {
  GaussianCloud cloud;
  const std::vector<Vec3d> centres = some_points(60);
  cloud.resize(centres.size());
  for (size_t i = 0; i < centres.size(); ++i) {
    cloud.position[i] = centres[i].cast<float>();
    cloud.log_scale[i].setConstant(std::log(0.02f));
    cloud.opacity_logit[i] = 3;
    for (int c = 0; c < 3; ++c) cloud.sh_of(i)[c] = 1.5f;
  }
  const TrainingPhotos photos = photos_of(cloud, arc_of_cameras(1));
  const PhotoFeatures features = find_features({}, photos.photos[0]);
  Vec2f sum = Vec2f::Zero();
  int count = 0;
  for (const Vec3d& centre : centres) {
    const Vec2f expected = project(photos.photos[0].camera, centre)->cast<float>();
    for (const Vec2f& pixel : features.pixel) {
      if ((pixel - expected).norm() < 0.7f) {
        sum += pixel - expected;
        ++count;
      }
    }
  }
  ASSERT_GT(count, 30);
  EXPECT_LT((sum / static_cast<float>(count)).norm(), 0.06f);
}

TEST(Features, AreNotTakenWhereThePhotoDoesNotCount) {
  TrainingPhoto photo = photos_of(textured_sheet(), arc_of_cameras(1)).photos[0];
  photo.weight = ImageU8(320, 240, 1, 255);
  for (int y = 0; y < 240; ++y) std::fill_n(photo.weight.at(0, y), 160, uint8_t(0));
  const PhotoFeatures features = find_features({}, photo);
  EXPECT_GT(features.size(), 100u);
  for (const Vec2f& pixel : features.pixel) EXPECT_GE(pixel.x(), 160);
}

TEST(Matches, WithinABandLieInItAndAgreeWithTheGeometry) {
  const TrainingPhotos photos = photos_of(textured_sheet(), arc_of_cameras(2));
  const PhotoFeatures a = find_features({}, photos.photos[0]), b = find_features({}, photos.photos[1]);
  const Mat3d F = fundamental_matrix(photos.photos[0].camera, photos.photos[1].camera);
  const MatchOptions options = {.ratio = 0.8, .band = 2};
  const std::vector<FeatureMatch> guided = match_features(options, a, b, &F), free = match_features(options, a, b);
  EXPECT_GT(guided.size(), 150u);
  for (const FeatureMatch& m : guided) {
    const Vec3d line = F * Vec3d(a.pixel[m.first].x(), a.pixel[m.first].y(), 1);
    EXPECT_LT(std::abs(line.dot(Vec3d(b.pixel[m.second].x(), b.pixel[m.second].y(), 1))) / line.head<2>().norm(),
              2.001);
  }
  std::vector<double> distances;
  for (const FeatureMatch& m : free) distances.push_back(sampson_distance(F, a.pixel[m.first], b.pixel[m.second]));
  ASSERT_GT(distances.size(), 100u);
  EXPECT_LT(median(distances), 0.3);
}

TEST(OverlappingPairs, LookTheSameWayFromDifferentPlaces) {
  std::vector<Camera> cameras = arc_of_cameras(24, 2 * M_PI / 24);
  cameras.push_back(cameras[0]);  // no parallax to the first
  const std::vector<PhotoPair> pairs = overlapping_pairs(cameras, 6);
  std::vector<int> partners(cameras.size());
  for (const auto& [i, j] : pairs) {
    EXPECT_LT(i, j);
    EXPECT_GT(cameras[i].forward().dot(cameras[j].forward()), 0.2);
    EXPECT_FALSE(i == 0 && j == 24);
    ++partners[i];
    ++partners[j];
  }
  for (const int n : partners) EXPECT_GE(n, 6);
  EXPECT_TRUE(overlapping_pairs({cameras[0]}, 6).empty());
  EXPECT_TRUE(overlapping_pairs({cameras[0], cameras[0], cameras[0]}, 6).empty());
}

TEST(TriangulatePhotos, PointsLieOnTheSurfaceWithItsColours) {
  const GaussianCloud cloud = textured_sheet();
  const TrainingPhotos photos = photos_of(cloud, arc_of_cameras(9));
  const SparsePoints points = triangulate_photos({}, photos);
  ASSERT_GT(points.position.size(), 300u);
  std::vector<double> height_errors, errors, color_errors;
  for (const Vec3f& p : points.position) {
    height_errors.push_back(std::abs(p.z() - 0.25 * std::sin(3 * p.x()) * std::cos(2.5 * p.y())));
  }
  for (const auto& [point, camera, pixel] : points.observations) {
    EXPECT_FALSE(photos.photos[camera].held_out);
    errors.push_back(
        (*project(photos.photos[camera].camera, points.position[point].cast<double>()) - pixel.cast<double>()).norm());
    const uint8_t* rgb = photos.photos[camera].pixels.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
    for (int c = 0; c < 3; ++c) color_errors.push_back(std::abs(points.color[point][c] - rgb[c] / 255.0f));
  }
  EXPECT_LT(median(errors), 0.25);
  EXPECT_LT(*std::max_element(errors.begin(), errors.end()), 2 * 0.32 + 0.01);  // 2 px of a photo of 1000 px
  EXPECT_LT(median(height_errors), 0.02);                                       // the Gaussians are that large
  std::sort(height_errors.begin(), height_errors.end());
  EXPECT_LT(height_errors[height_errors.size() * 95 / 100], 0.08);
  EXPECT_LT(median(color_errors), 0.05);
  EXPECT_NE(points.source.find("points triangulated from features of 8 photos"), std::string::npos) << points.source;
}

TEST(TriangulatePhotos, OneWithAWrongPoseSeesHardlyAnyPointAndIsNamed) {
  TrainingPhotos photos = photos_of(textured_sheet(), arc_of_cameras(9));
  EXPECT_TRUE(photos_without_points(photos, triangulate_photos({}, photos)).empty());
  photos.photos[3].camera.cam_from_world.linear() =
      (Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 1, 0).normalized()) * photos.photos[3].camera.cam_from_world.linear())
          .eval();
  const std::vector<std::string> warnings = photos_without_points(photos, triangulate_photos({}, photos));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].rfind("view_d: sees", 0), 0u) << warnings[0];
}

TEST(TriangulatePhotos, AreEqualForAnyNumberOfThreads) {
  const TrainingPhotos photos = photos_of(textured_sheet(), arc_of_cameras(5));
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const SparsePoints one = triangulate_photos({}, photos);
  omp_set_num_threads(4);
  const SparsePoints four = triangulate_photos({}, photos);
  omp_set_num_threads(threads);
  EXPECT_GT(one.position.size(), 100u);
  EXPECT_EQ(one.position, four.position);
  EXPECT_EQ(one.color, four.color);
  ASSERT_EQ(one.observations.size(), four.observations.size());
  for (size_t i = 0; i < one.observations.size(); ++i) EXPECT_EQ(one.observations[i].pixel, four.observations[i].pixel);
}

TEST(TriangulatePhotos, OfBlankPhotosAreNone) {
  TrainingPhotos photos = photos_of(textured_sheet(), arc_of_cameras(4));
  for (TrainingPhoto& photo : photos.photos) photo.pixels = ImageU8(320, 240, 3, 90);
  EXPECT_TRUE(triangulate_photos({}, photos).empty());
}

}  // namespace
}  // namespace pliant
