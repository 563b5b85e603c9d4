// Photos as files: what is decoded, orientation flags, and files that are damaged.

#include "gaussians/io/images/photo.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "tests/gaussians/photo_files.h"

namespace pliant {
namespace {

/// No symmetry, and smooth enough for JPEG.
cv::Mat gradient(int width, int height) {
  return picture_of(width, height, [](int x, int y, int c) {
    return c == 0 ? 10 * x : c == 1 ? 12 * y : 3 * x + 5 * y;
  });
}

void expect_same(const cv::Mat& bgr, const ImageU8& rgb) {
  ASSERT_EQ(rgb.width, bgr.cols);
  ASSERT_EQ(rgb.height, bgr.rows);
  for (int y = 0; y < rgb.height; ++y) {
    for (int x = 0; x < rgb.width; ++x) {
      for (int c = 0; c < 3; ++c) ASSERT_EQ(rgb(x, y, c), bgr.at<cv::Vec3b>(y, x)[2 - c]) << x << ' ' << y;
    }
  }
}

TEST(Photo, IsTheStoredPictureWhateverTheOrientationAndTurnsLikeOpenCv) {
  const TemporaryFolder folder;
  const std::string plain = encoded(".jpg", gradient(24, 16));
  for (int orientation = 1; orientation <= 8; ++orientation) {
    for (const bool big_endian : {false, true}) {
      SCOPED_TRACE(orientation);
      const auto file = folder.file("a.jpg", with_orientation(plain, orientation, big_endian));
      const Photo photo = read_photo(file);
      EXPECT_EQ(photo.orientation, orientation);
      expect_same(codecs::imread(folder.file("plain.jpg", plain).string()), photo.pixels);
      expect_same(codecs::imread(file.string(), cv::IMREAD_COLOR), oriented(photo.pixels, photo.orientation));
    }
  }
  EXPECT_EQ(exif_orientation(with_orientation(plain, 9, true)), 1);
  EXPECT_EQ(exif_orientation(with_orientation(plain, 6, true).substr(0, 30)), 1);
  EXPECT_EQ(exif_orientation(plain), 1);
}

TEST(Photo, OrientationOfPngIsRead) {
  const std::string png = encoded(".png", gradient(8, 6));
  const std::string jpeg = with_orientation(encoded(".jpg", gradient(8, 6)), 6, true);
  const std::string tiff = jpeg.substr(12, 26);
  std::string chunk = std::string("\0\0\0", 3) + static_cast<char>(tiff.size()) + "eXIf" + tiff + "crc.";
  EXPECT_EQ(exif_orientation(png.substr(0, 33) + chunk + png.substr(33)), 6);  // behind the header
  EXPECT_EQ(exif_orientation(png), 1);
}

TEST(Photo, ItsHeadTellsSizeAndOrientationAsStored) {
  const TemporaryFolder folder;
  for (const char* suffix : {".jpg", ".png"}) {
    const PhotoHead head = read_photo_head(folder.file("a", encoded(suffix, gradient(24, 16))));
    EXPECT_EQ(head.width, 24) << suffix;
    EXPECT_EQ(head.height, 16) << suffix;
    EXPECT_EQ(head.orientation, 1) << suffix;
  }
  const std::string turned = with_orientation(encoded(".jpg", gradient(24, 16)), 6, true);
  const PhotoHead head = read_photo_head(folder.file("a.jpg", turned));
  EXPECT_EQ(head.width, 24);
  EXPECT_EQ(head.orientation, 6);
  for (size_t length = 0; length < 60; ++length)
    for (const std::string& whole : {turned, encoded(".png", gradient(8, 6))})
      EXPECT_LE(read_photo_head(folder.file("a.jpg", whole.substr(0, length))).width, 24) << length;
  EXPECT_EQ(read_photo_head(folder / "none.jpg").width, 0);
}

TEST(Photo, ItsHeadIsReadBehindLongMetadata) {
  const TemporaryFolder folder;
  const std::string turned = with_orientation(encoded(".jpg", gradient(24, 16)), 6, true);
  std::string metadata;
  for (int k = 0; k < 5; ++k) metadata += std::string("\xff\xe1\xff\xff", 4) + std::string(65533, 'x');
  const size_t exif_end = 4 + 32 + 2;  // start of image, and the segment with its 6 + 26 bytes
  ASSERT_EQ(turned[exif_end], '\xff');
  for (const size_t at : {size_t(2), exif_end}) {
    const std::string bytes = turned.substr(0, at) + metadata + turned.substr(at);
    const PhotoHead head = read_photo_head(folder.file("a.jpg", bytes));
    EXPECT_EQ(head.width, 24) << at;
    EXPECT_EQ(head.height, 16) << at;
    EXPECT_EQ(head.orientation, 6) << at;
  }
}

TEST(Photo, AxesOfTheUprightPictureAreThoseAlongWhichItIsTurned) {
  ImageU8 stored(3, 2, 1);
  for (int k = 0; k < 6; ++k) stored.data[k] = static_cast<uint8_t>(k);
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const ImageU8 upright = oriented(stored, orientation);
    const Eigen::Matrix2i axes = stored_from_upright(orientation);
    const auto at = [](int value) { return Eigen::Vector2i(value % 3, value / 3); };
    EXPECT_EQ(at(upright(1, 0, 0)) - at(upright(0, 0, 0)), axes.col(0)) << orientation;
    EXPECT_EQ(at(upright(0, 1, 0)) - at(upright(0, 0, 0)), axes.col(1)) << orientation;
  }
}

TEST(Photo, GreyAndDeepAndTransparentOnesAreRead) {
  const TemporaryFolder folder;
  const cv::Mat color = gradient(20, 10);
  cv::Mat grey(10, 20, CV_8UC1, cv::Scalar(77)), deep, transparent(10, 20, CV_8UC4, cv::Scalar(10, 20, 30, 255));
  color.convertTo(deep, CV_16U, 257);
  EXPECT_EQ(read_photo(folder.file("g.png", encoded(".png", grey))).pixels.data, std::vector<uint8_t>(600, 77));
  EXPECT_EQ(read_photo(folder.file("g.jpg", encoded(".jpg", grey))).pixels.data, std::vector<uint8_t>(600, 77));
  expect_same(color, read_photo(folder.file("d.png", encoded(".png", deep))).pixels);
  EXPECT_TRUE(read_photo(folder.file("opaque.png", encoded(".png", transparent))).alpha.empty());
  transparent.at<cv::Vec4b>(3, 7)[3] = 128;
  const Photo photo = read_photo(folder.file("t.png", encoded(".png", transparent)));
  ASSERT_EQ(photo.alpha.pixels(), 200u);
  EXPECT_EQ(photo.alpha(7, 3), 128);
  EXPECT_EQ(photo.alpha(8, 3), 255);
  EXPECT_EQ(photo.pixels(7, 3, 0), 30);
}

TEST(Photo, JpegThatEndsEarlyIsRefusedAtEveryLength) {
  const TemporaryFolder folder;
  const std::string whole = with_orientation(encoded(".jpg", gradient(64, 48)), 1, false);
  EXPECT_TRUE(jpeg_is_whole(whole));
  EXPECT_TRUE(jpeg_is_whole(whole + "trailing bytes"));
  for (size_t length = 0; length < whole.size(); ++length)
    ASSERT_FALSE(jpeg_is_whole(whole.substr(0, length))) << length;
  // The decoder alone would take it: half of it would be grey.
  const auto file = folder.file("half.jpg", whole.substr(0, whole.size() - whole.size() / 4));
  expect_error(Failure::kInput, {"half.jpg", "ends before"}, [&] { read_photo(file); });
  const auto zeros = folder.file("zeros.jpg", whole.substr(0, whole.size() / 2) + std::string(whole.size() / 2, '\0'));
  expect_error(Failure::kInput, {"zeros.jpg", "ends before"}, [&] { read_photo(zeros); });
}

TEST(Photo, OtherDamageIsNamed) {
  const TemporaryFolder folder;
  const std::string png = encoded(".png", gradient(64, 48));
  for (const std::string& bytes : {std::string("no picture"), png.substr(0, png.size() / 2), png.substr(0, 20)}) {
    const auto file = folder.file("bad.png", bytes);
    expect_error(Failure::kInput, {"bad.png", "decoded"}, [&] { read_photo(file); });
  }
  const auto empty = folder.file("empty.jpg", "");
  expect_error(Failure::kInput, {"empty.jpg", "is empty"}, [&] { read_photo(empty); });
  expect_error(Failure::kInput, {"none.jpg", "does not exist"}, [&] { read_photo(folder / "none.jpg"); });
}

}  // namespace
}  // namespace pliant
