#pragma once

#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/image.h"
#include "gaussians/io/cameras/camera_file.h"
#include "gaussians/io/images/codecs.h"
#include "tests/temporary_folder.h"

namespace pliant {

/// A picture that encodes to the bytes of a file; `value(x, y, c)` is in [0, 255], c = R, G, B.
template <class Value>
cv::Mat picture_of(int width, int height, Value&& value) {
  cv::Mat picture(height, width, CV_8UC3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) picture.at<cv::Vec3b>(y, x)[2 - c] = cv::saturate_cast<uint8_t>(value(x, y, c));
    }
  }
  return picture;
}

inline std::string encoded(const std::string& extension, const cv::Mat& picture, int quality = 95) {
  std::vector<uint8_t> bytes;
  std::vector<int> parameters;
  if (extension == ".jpg") parameters = {cv::IMWRITE_JPEG_QUALITY, quality};
  EXPECT_TRUE(codecs::imencode(extension, picture, bytes, parameters));
  return std::string(bytes.begin(), bytes.end());
}

/// The JPEG with an EXIF segment that holds one entry, the orientation (Exif 2.3, 4.6.4; TIFF 6.0, section 2).
inline std::string with_orientation(const std::string& jpeg, int orientation, bool big_endian) {
  const auto number = [&](int value, int size) {
    std::string bytes;
    for (int k = 0; k < size; ++k) bytes += static_cast<char>(value >> 8 * (big_endian ? size - 1 - k : k));
    return bytes;
  };
  std::string tiff = big_endian ? "MM" : "II";
  tiff += number(42, 2) + number(8, 4);  // the directory follows the header
  tiff += number(1, 2);                  // one entry
  tiff += number(274, 2) + number(3, 2) + number(1, 4) + number(orientation, 2) + number(0, 2);  // one short
  tiff += number(0, 4);                                                                          // no further directory
  const std::string contents = std::string("Exif\0\0", 6) + tiff;
  const auto length = static_cast<int>(contents.size()) + 2;
  std::string segment = "\xff\xe1";
  segment += static_cast<char>(length >> 8);
  segment += static_cast<char>(length);
  return jpeg.substr(0, 2) + segment + contents + jpeg.substr(2);
}

/// Cameras as a reader returns them.
inline CameraFile camera_file(std::vector<Camera> cameras, const std::string& format = "COLMAP binary") {
  CameraFile file;
  file.frames = file.photos_found = static_cast<int>(cameras.size());
  file.cameras = std::move(cameras);
  file.format = format;
  file.files = {"cameras.test"};
  return file;
}

}  // namespace pliant
