// Real photos with cameras, where they are present: what is read, checked and triangulated.

#include <gtest/gtest.h>

#include "gaussians/io/cameras/cameras.h"
#include "gaussians/reconstruct/check_poses.h"
#include "gaussians/reconstruct/triangulate.h"
#include "tests/gaussians/format_files.h"

namespace pliant {
namespace {

struct Known {
  const char* folder;
  size_t photos, points;  // usable photos; points at the least
};

class RealPhotos : public testing::TestWithParam<Known> {};

TEST_P(RealPhotos, AgreeWithTheirPosesAndShareManyPoints) {
  const auto folder = real_data() / GetParam().folder;
  if (real_data().empty() || !std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  const CameraFile file = read_cameras(folder, {}, PhotoFit::kEachPhoto);
  EXPECT_EQ(file.warnings.size(), 1u);  // both lists name photos that are not there
  PhotoOptions options;
  options.longest_side = 480;
  const TrainingPhotos photos = load_training_photos(options, file);
  EXPECT_TRUE(photos.warnings.empty());
  ASSERT_EQ(photos.photos.size(), GetParam().photos);
  const PoseReport report = check_poses({.seeds = 4}, file, photos, {});
  EXPECT_TRUE(report.warnings.empty());
  EXPECT_GT(report.matches.fits[0].share, 0.9);
  EXPECT_LT(report.matches.fits[0].error, 0.5);
  const SparsePoints points = triangulate_photos({.features = {.most = 1200}, .neighbours = 6}, photos);
  EXPECT_GT(points.position.size(), GetParam().points) << points.source;
  EXPECT_TRUE(photos_without_points(photos, points).empty());
}

INSTANTIATE_TEST_SUITE_P(Captures, RealPhotos,
                         testing::Values(Known{"photos_fox", 50, 1200}, Known{"photos_temple", 19, 500}),
                         [](const auto& info) { return std::string(info.param.folder); });

}  // namespace
}  // namespace pliant
