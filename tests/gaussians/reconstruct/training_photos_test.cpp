// From photo files to pictures of pinhole cameras: lens, size, orientation, background, and what cannot be used.

#include "gaussians/reconstruct/training_photos.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "gaussians/base/lens.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/reconstruct/trainer.h"
#include "gaussians/reconstruct/undistort.h"
#include "tests/gaussians/photo_files.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr Lens kBarrel = {-0.12, 0.02, 0.001, -0.002, 0, 0}, kPincushion = {0.08, -0.03, -0.001, 0.0005, 0, 0};

/// A smooth pattern on the plane z = 1, and how light it is in [0, 255].
double pattern(const Eigen::Vector2d& x, int c) {
  return 127.5 + 100 * std::sin(9 * x.x() + c) * std::cos(7 * x.y() - 0.5 * c);
}

Camera camera_of(int width, int height, const Lens& lens, const std::string& name) {
  Camera camera = look_at({0.1, 0.2, -2}, {0, 0, 0}, {0, -1, 0}, width, height, 0.9 * width);
  camera.fy *= 1.01;
  camera.cx += 4;
  camera.cy -= 3;
  camera.distortion = lens;
  camera.name = name;
  return camera;
}

cv::Mat photo_of_pattern(const Camera& camera) {
  return picture_of(camera.width, camera.height, [&](int x, int y, int c) {
    return pattern(unproject(camera, {x + 0.5, y + 0.5}).value(), c);
  });
}

/// The file with `camera` three times, under three names, so that there are enough photos.
CameraFile three_of(const TemporaryFolder& folder, Camera camera, const std::string& bytes,
                    const std::string& extension) {
  std::vector<Camera> cameras;
  for (const char* name : {"a", "b", "c"}) {
    camera.name = name;
    camera.photo = folder.file(name + extension, bytes).string();
    cameras.push_back(camera);
  }
  return camera_file(cameras);
}

double worst_error(const TrainingPhoto& photo, double (*expected)(const Eigen::Vector2d&, int)) {
  double worst = 0;
  const Camera& c = photo.camera;
  for (int y = 0; y < c.height; ++y) {
    for (int x = 0; x < c.width; ++x) {
      const Eigen::Vector2d p((x + 0.5 - c.cx) / c.fx, (y + 0.5 - c.cy) / c.fy);
      for (int k = 0; k < 3; ++k) worst = std::max(worst, std::abs(photo.pixels(x, y, k) - expected(p, k)));
    }
  }
  return worst;
}

TEST(TrainingPhotos, WithoutLensAndOfTheRightSizeAreTheFilesOnDisk) {
  const TemporaryFolder folder;
  const Camera camera = camera_of(60, 40, {}, "a");
  const TrainingPhotos photos =
      load_training_photos({}, three_of(folder, camera, encoded(".png", photo_of_pattern(camera)), ".png"));
  ASSERT_EQ(photos.photos.size(), 3u);
  EXPECT_FALSE(photos.changed);
  EXPECT_TRUE(photos.warnings.empty());
  EXPECT_LE(worst_error(photos.photos[1], pattern), 0.5);
  EXPECT_TRUE(photos.photos[0].held_out);
  EXPECT_FALSE(photos.photos[1].held_out);
  const std::vector<Camera> written = write_training_photos(folder / "photos", photos);
  EXPECT_EQ(written[2].photo, (folder / "c.png").string());
  EXPECT_FALSE(fs::exists(folder / "photos"));
}

TEST(TrainingPhotos, UndistortedPhotoIsThePictureOfItsPinhole) {
  for (const Lens& lens : {kBarrel, kPincushion}) {
    const TemporaryFolder folder;
    const Camera camera = camera_of(300, 200, lens, "a");
    const TrainingPhotos photos =
        load_training_photos({}, three_of(folder, camera, encoded(".png", photo_of_pattern(camera)), ".png"));
    const TrainingPhoto& photo = photos.photos[0];
    EXPECT_TRUE(photos.changed && photo.changed);
    EXPECT_EQ(photo.camera.distortion, Lens());
    EXPECT_TRUE(photo.weight.empty());
    EXPECT_LE(worst_error(photo, pattern), 1.5);
    EXPECT_LE(photo.camera.width, 300);
    EXPECT_GT(photo.camera.width * photo.camera.height, 0.9 * 300 * 200);
  }
}

TEST(TrainingPhotos, ScaledPhotoIsTheAreaAverageSeenByTheScaledCamera) {
  const TemporaryFolder folder;
  const Camera camera = camera_of(450, 300, kPincushion, "a");
  PhotoOptions options;
  options.longest_side = 200;
  const TrainingPhotos photos =
      load_training_photos(options, three_of(folder, camera, encoded(".png", photo_of_pattern(camera)), ".png"));
  const TrainingPhoto& photo = photos.photos[0];
  EXPECT_LE(std::max(photo.camera.width, photo.camera.height), 200);
  EXPECT_GT(photo.camera.width, 180);
  EXPECT_LE(worst_error(photo, pattern), 2.0);
}

/// A 3D point is painted as a blob where the lens puts it; after loading, the blob must lie where the new camera sees
/// the point.
TEST(TrainingPhotos, PointsInSpaceStayOnTheirFeatures) {
  const Eigen::Vector3d points[] = {{0.3, 0.25, 0.1}, {-0.4, 0.1, 0.3}, {0.05, -0.3, -0.2}, {-0.1, 0.05, 0}};
  const TemporaryFolder folder;
  const Camera camera = camera_of(480, 360, kBarrel, "a");
  const cv::Mat picture = picture_of(480, 360, [&](int x, int y, int) {
    double value = 0;
    for (const auto& point : points) {
      value += 250 * std::exp(-(*project(camera, point) - Eigen::Vector2d(x + 0.5, y + 0.5)).squaredNorm() / (2 * 4));
    }
    return value;
  });
  for (const int side : {0, 240, 211}) {
    PhotoOptions options;
    options.longest_side = side;
    const TrainingPhoto photo =
        load_training_photos(options, three_of(folder, camera, encoded(".png", picture), ".png")).photos[0];
    for (const auto& point : points) {
      const Eigen::Vector2d expected = *project(photo.camera, point);
      Eigen::Vector3d sum(0, 0, 0);
      for (int y = 0; y < photo.camera.height; ++y) {
        for (int x = 0; x < photo.camera.width; ++x) {
          const Eigen::Vector2d at(x + 0.5, y + 0.5);
          if ((at - expected).norm() < 8) sum += photo.pixels(x, y) * Eigen::Vector3d(at.x(), at.y(), 1);
        }
      }
      EXPECT_NEAR((sum.head<2>() / sum.z() - expected).norm(), 0, 0.04) << side;
    }
  }
}

TEST(TrainingPhotos, PixelsThatTheLensDoesNotReachHaveNoWeight) {
  Camera camera = look_at({0, 0, -2}, {0, 0, 0}, {0, -1, 0}, 100, 100, 90);
  camera.name = "folding";
  camera.distortion = {-0.44, 0, 0, 0, 0, 0};  // the middles of the sides are seen, the corners are not
  const Undistortion folding = make_undistortion(camera);
  EXPECT_FALSE(folding.all_inside);
  EXPECT_FALSE(folding.seen[0].allFinite());
  EXPECT_TRUE(folding.seen[folding.seen.size() / 2 + folding.pinhole.width / 2].allFinite());
  camera.distortion = {-40, 0, 0, 0, 0, 0};
  expect_error(Failure::kInput, {"folding", "distortion"}, [&] { make_undistortion(camera); });
}

TEST(TrainingPhotos, AreTurnedOnlyWhenTheirCameraHasTheShapeOfTheTurnedPicture) {
  const TemporaryFolder folder;
  const Camera upright = camera_of(160, 240, {}, "a");
  cv::Mat turned;
  cv::rotate(photo_of_pattern(upright), turned, cv::ROTATE_90_COUNTERCLOCKWISE);  // flag 6 turns it back
  const std::string bytes = with_orientation(encoded(".jpg", turned, 100), 6, true);
  TrainingPhotos photos = load_training_photos({}, three_of(folder, upright, bytes, ".jpg"));
  EXPECT_LE(worst_error(photos.photos[0], pattern), 6);  // of JPEG
  ASSERT_EQ(photos.warnings.size(), 1u);
  EXPECT_NE(photos.warnings[0].find("3 of 3 photos are rotated"), std::string::npos);
  EXPECT_TRUE(photos.changed);

  photos = load_training_photos({}, three_of(folder, camera_of(240, 160, {}, "a"), bytes, ".jpg"));
  EXPECT_FALSE(photos.changed);
  EXPECT_EQ(photos.photos[0].pixels.width, 240);
  EXPECT_TRUE(photos.warnings.empty());

  const std::string upside_down = with_orientation(encoded(".jpg", turned), 3, true);
  photos = load_training_photos({}, three_of(folder, camera_of(240, 160, {}, "a"), upside_down, ".jpg"));
  EXPECT_FALSE(photos.changed);
  ASSERT_EQ(photos.warnings.size(), 3u);
  EXPECT_NE(photos.warnings[0].find("orientation flag is 3"), std::string::npos);
}

TEST(TrainingPhotos, TransparentOnesAreOnTheBackground) {
  const TemporaryFolder folder;
  cv::Mat picture(20, 30, CV_8UC4, cv::Scalar(0, 100, 200, 255));
  picture.at<cv::Vec4b>(2, 3)[3] = 0;
  picture.at<cv::Vec4b>(2, 4)[3] = 51;
  PhotoOptions options;
  options.background = Vec3f(1, 1, 1);
  const TrainingPhotos photos =
      load_training_photos(options, three_of(folder, camera_of(30, 20, {}, "a"), encoded(".png", picture), ".png"));
  EXPECT_TRUE(photos.changed);
  const ImageU8& pixels = photos.photos[0].pixels;
  EXPECT_EQ(pixels(3, 2, 0), 255);
  EXPECT_EQ(pixels(4, 2, 0), 244);  // 0.2 * 200 + 0.8 * 255
  EXPECT_EQ(pixels(4, 2, 2), 204);
  EXPECT_EQ(pixels(5, 2, 0), 200);
  EXPECT_EQ(photos.photos[0].alpha(3, 2), 0);
  EXPECT_EQ(photos.photos[0].alpha(4, 2), 51);
  EXPECT_EQ(photos.photos[0].alpha(5, 2), 255);
}

TEST(TrainingPhotos, AlphaIsScaledUndistortedAndPutOnAnotherColourWithItsPhoto) {
  const TemporaryFolder folder;
  cv::Mat picture(90, 120, CV_8UC4);
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 120; ++x) picture.at<cv::Vec4b>(y, x) = cv::Vec4b(40, 120, 200, static_cast<uint8_t>(2 * x));
  PhotoOptions options;
  options.longest_side = 60;
  const Vec3f to(0.3f, 0.9f, 0.1f);
  std::vector<ImageF> put;
  for (const Vec3f& background : {Vec3f(0, 0, 0), to}) {
    options.background = background;
    const TrainingPhoto photo = load_training_photos(options, three_of(folder, camera_of(120, 90, kBarrel, "a"),
                                                                       encoded(".png", picture), ".png"))
                                    .photos[0];
    ASSERT_EQ(photo.alpha.width, photo.pixels.width);
    ASSERT_EQ(photo.alpha.height, photo.pixels.height);
    Camera camera;
    ImageF pixels, weight;
    photo_at_level(photo, 1, camera, pixels, weight);
    change_backdrop(photo, background, to, pixels);
    put.push_back(pixels);
  }
  double worst = 0;
  for (size_t i = 0; i < put[0].data.size(); ++i)
    worst = std::max(worst, std::abs(double(put[0].data[i]) - put[1].data[i]));
  EXPECT_LT(worst, 2.0 / 255);
  EXPECT_GT(std::abs(put[0](1, 10, 1) - put[0](28, 10, 1)), 0.2f);
}

TEST(TrainingPhotos, ChangedOnesAreWrittenAndReadBackWithTheirCameras) {
  const TemporaryFolder folder;
  const Camera camera = camera_of(120, 90, kBarrel, "a");
  CameraFile file = three_of(folder, camera, encoded(".png", photo_of_pattern(camera)), ".png");
  file.cameras[1].distortion = {};
  const TrainingPhotos photos = load_training_photos({}, file);
  const std::vector<Camera> written = write_training_photos(folder / "photos", photos);
  EXPECT_EQ(written[0].photo, (folder / "photos/a.png").string());
  EXPECT_EQ(written[1].photo, (folder / "b.png").string());
  write_cameras(folder / "transforms.json", written);
  const CameraFile again = read_cameras(folder / "transforms.json");
  EXPECT_TRUE(again.warnings.empty());
  const TrainingPhotos reread = load_training_photos({}, again);
  EXPECT_FALSE(reread.changed);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(reread.photos[i].pixels.data, photos.photos[i].pixels.data);
    EXPECT_DOUBLE_EQ(reread.photos[i].camera.cx, photos.photos[i].camera.cx);
  }
}

TEST(TrainingPhotos, DamagedAndMisshapenOnesAreLeftOutAndNamed) {
  const TemporaryFolder folder;
  std::vector<Camera> cameras;
  const Camera camera = camera_of(60, 40, {}, "");
  const std::string good = encoded(".jpg", photo_of_pattern(camera));
  const std::string twice = encoded(".jpg", photo_of_pattern(camera.scaled(2)));
  const std::string square = encoded(".jpg", photo_of_pattern(camera_of(50, 50, {}, "")));
  for (const auto& [name, bytes] :
       std::vector<std::pair<std::string, std::string>>{{"f", good},
                                                        {"b_cut", good.substr(0, good.size() / 2)},
                                                        {"c_twice", twice},
                                                        {"d_square", square},
                                                        {"e_text", "text"},
                                                        {"a", good}}) {
    cameras.push_back(camera);
    cameras.back().name = name;
    cameras.back().photo = folder.file(name + ".jpg", bytes).string();
  }
  const TrainingPhotos photos = load_training_photos({}, camera_file(cameras));
  ASSERT_EQ(photos.photos.size(), 3u);
  EXPECT_EQ(photos.photos[0].camera.name, "a");
  EXPECT_EQ(photos.photos[1].camera.name, "c_twice");
  EXPECT_EQ(photos.photos[1].camera.fx, 2 * camera.fx);
  EXPECT_EQ(photos.photos[1].camera.cx, 2 * camera.cx);
  EXPECT_LE(worst_error(photos.photos[1], pattern), 25);
  std::string all;
  for (const std::string& warning : photos.warnings) all += warning + "\n";
  for (const char* words : {"b_cut.jpg", "ends before its image does", "d_square.jpg: has 50 x 50", "e_text.jpg",
                            "3 of 6 photos (50 %) cannot be used", "1 of 6 photos have another size"}) {
    EXPECT_NE(all.find(words), std::string::npos) << words << " in " << all;
  }
  cameras.resize(3);
  expect_error(Failure::kInput,
               {"cameras.test", "only 2 usable photos", "at least 3", "1 of 3 photos (33 %)", "b_cut.jpg"},
               [&] { load_training_photos({}, camera_file(cameras)); });
  cameras.resize(1);
  expect_error(Failure::kInput, {"only one usable photo"}, [&] { load_training_photos({}, camera_file(cameras)); });
  expect_error(Failure::kInput, {"no usable photo"}, [&] { load_training_photos({}, camera_file({})); });
}

TEST(TrainingPhotos, OnesThatAreTooSmallToMeasureAreNamed) {
  const TemporaryFolder folder;
  const Camera camera = camera_of(30, 20, {}, "a");
  const CameraFile file = three_of(folder, camera, encoded(".png", photo_of_pattern(camera)), ".png");
  PhotoOptions options;
  options.longest_side = 12;
  expect_error(Failure::kInput, {"no usable photo", "a.png", "12 x 8", "at least 11", "--max-image-size"},
               [&] { load_training_photos(options, file); });
  options.longest_side = 17;
  EXPECT_EQ(load_training_photos(options, file).photos[0].camera.height, 11);
}

TEST(TrainingPhotos, KnowTheLensThatWasUndone) {
  const TemporaryFolder folder;
  const Camera camera = camera_of(120, 90, kPincushion, "a");
  PhotoOptions options;
  options.longest_side = 60;
  const TrainingPhoto photo =
      load_training_photos(options, three_of(folder, camera, encoded(".png", photo_of_pattern(camera)), ".png"))
          .photos[0];
  EXPECT_EQ(photo.lens.distortion, kPincushion);
  EXPECT_EQ(photo.lens.width, 60);
  EXPECT_EQ(photo.lens.fx, camera.fx / 2);
  EXPECT_EQ(undistortion_onto(photo.camera, photo.lens).seen, make_undistortion(camera.scaled(0.5)).seen);
  const Camera straight = camera_of(120, 90, {}, "a");
  const TrainingPhotos without =
      load_training_photos({}, three_of(folder, straight, encoded(".png", photo_of_pattern(straight)), ".png"));
  EXPECT_EQ(without.photos[0].lens.width, 0);
}

TEST(Undistortion, OfNumbersIsThatOfBytes) {
  const Camera camera = camera_of(60, 45, kBarrel, "a");
  ImageU8 bytes(60, 45, 3);
  ImageF numbers(60, 45, 3);
  for (size_t i = 0; i < bytes.data.size(); ++i) {
    bytes.data[i] = static_cast<uint8_t>(37 * i % 256);
    numbers.data[i] = bytes.data[i] / 255.0f;
  }
  const Undistortion lens = make_undistortion(camera);
  const ImageU8 of_bytes = undistorted(lens, bytes);
  const ImageF of_numbers = undistorted(lens, numbers);
  ASSERT_EQ(of_numbers.data.size(), of_bytes.data.size());
  for (size_t i = 0; i < of_bytes.data.size(); ++i) EXPECT_NEAR(255 * of_numbers.data[i], of_bytes.data[i], 0.501) << i;
}

TEST(TrainingPhotos, SomeAreLeftToTrainOn) {
  const TemporaryFolder folder;
  const Camera camera = camera_of(30, 20, {}, "a");
  const CameraFile file = three_of(folder, camera, encoded(".png", photo_of_pattern(camera)), ".png");
  PhotoOptions options;
  options.hold_out_every = 1;
  expect_error(Failure::kUsage, {"--hold-out-every: 1", "all 3"}, [&] { load_training_photos(options, file); });
  options.hold_out_every = 0;
  for (const TrainingPhoto& photo : load_training_photos(options, file).photos) EXPECT_FALSE(photo.held_out);
}

TEST(TrainingPhotos, ReaderLeavesLensAndSizesToThem) {
  const TemporaryFolder folder;
  std::vector<Camera> cameras;
  for (const char* name : {"a", "b", "c"}) {
    Camera camera = camera_of(120, 90, kBarrel, name);
    camera.photo =
        folder.file(std::string(name) + ".png", encoded(".png", photo_of_pattern(camera.scaled(0.5)))).string();
    cameras.push_back(camera);
  }
  std::ofstream(cameras[0].photo) << "damaged";
  write_transforms(folder / "transforms.json", cameras);
  EXPECT_THROW(read_cameras(folder.path()), Error);  // its first photo cannot be read
  const CameraFile file = read_cameras(folder.path(), {}, PhotoFit::kEachPhoto);
  EXPECT_TRUE(file.warnings.empty());
  EXPECT_EQ(file.cameras[1].width, 120);
  EXPECT_EQ(file.cameras[1].distortion, kBarrel);
}

}  // namespace
}  // namespace pliant
