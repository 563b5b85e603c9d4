#include "gaussians/io/images/image_io.h"

#include <algorithm>
#include <opencv2/core.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/codecs.h"
#include "gaussians/io/images/image_files.h"
#include "gaussians/io/images/indexed_png.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

cv::Mat decode(const fs::path& file, int flags) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) throw input_error(file.string(), "", "does not exist", "check the name");
  if (!fs::is_regular_file(file, ignored)) throw input_error(file.string(), "", "is not a file", "give an image");
  cv::Mat picture;
  std::string why;
  try {
    picture = codecs::imread(file.string(), flags);
  } catch (const cv::Exception& error) {
    why = ": " + error.err;
  }
  if (picture.empty()) {
    throw input_error(file.string(), "", "is not an image that can be decoded" + why, "use PNG or JPEG");
  }
  return picture;
}

void encode(const fs::path& file, const cv::Mat& picture) {
  std::vector<uint8_t> bytes;
  std::string why = "the encoder failed";
  try {
    if (codecs::imencode(file.extension().string(), picture, bytes, {})) why.clear();
  } catch (const cv::Exception& error) {
    why = error.err;
  }
  if (!why.empty()) throw input_error(file.string(), "", "cannot be written: " + why, "use the extension png or jpg");
  write_text(file, {bytes.begin(), bytes.end()});
}

/// Whether any pixel of an 8-bit picture is not grey.
bool is_colored(const cv::Mat& picture) {
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) {
      const uint8_t* bgr = picture.ptr<uint8_t>(y) + static_cast<size_t>(x) * picture.elemSize();
      if (bgr[0] != bgr[1] || bgr[1] != bgr[2]) return true;
    }
  return false;
}

}  // namespace

ImageF read_image(const fs::path& file) {
  // The orientation tag is ignored because camera poses refer to the stored pixels.
  const cv::Mat picture = decode(file, cv::IMREAD_COLOR | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
  const int depth = picture.depth();
  if (depth != CV_8U && depth != CV_16U && depth != CV_32F) {
    throw input_error(file.string(), "", "has an unusual number format", "use 8-bit or 16-bit images");
  }
  cv::Mat scaled;
  picture.convertTo(scaled, CV_32F, depth == CV_8U ? 1.0 / 255 : depth == CV_16U ? 1.0 / 65535 : 1.0);
  ImageF image(picture.cols, picture.rows, 3);
  for (int y = 0; y < image.height; ++y) {
    const float* bgr = scaled.ptr<float>(y);
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c) image(x, y, c) = bgr[3 * x + 2 - c];
    }
  }
  return image;
}

ImageU8 to_8_bit(const ImageF& image) {
  ImageU8 out(image.width, image.height, image.channels);
  for (size_t i = 0; i < out.data.size(); ++i) {
    const float value = image.data[i];
    out.data[i] = static_cast<uint8_t>(255.0f * (value > 0.0f ? std::min(value, 1.0f) : 0.0f) + 0.5f);
  }
  return out;
}

void write_image(const fs::path& file, const ImageF& image) {
  CHECK(image.channels == 1 || image.channels == 3 || image.channels == 4);
  const int colours = std::min(image.channels, 3);
  const ImageU8 bytes = to_8_bit(image);
  cv::Mat picture(image.height, image.width, CV_8UC(image.channels));
  for (int y = 0; y < image.height; ++y) {
    uint8_t* row = picture.ptr<uint8_t>(y);
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < image.channels; ++c) {
        row[x * image.channels + c] = bytes(x, y, c < colours ? colours - 1 - c : c);
      }
    }
  }
  encode(file, picture);
}

void write_grey_16(const fs::path& file, const ImageF& image) {
  CHECK(image.channels == 1);
  cv::Mat picture(image.height, image.width, CV_16UC1);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x)
      picture.at<uint16_t>(y, x) = static_cast<uint16_t>(65535.0f * std::clamp(image(x, y, 0), 0.0f, 1.0f) + 0.5f);
  }
  encode(file, picture);
}

IdImage read_ids(const fs::path& file) {
  if (std::optional<IdImage> indices = read_palette_indices(file)) return std::move(*indices);
  const cv::Mat picture = decode(file, cv::IMREAD_UNCHANGED);
  if (is_jpeg_file(file)) throw input_error(file.string(), "", "is a JPEG, whose compression changes IDs", "use PNG");
  const bool grey = picture.type() == CV_8UC1 || picture.type() == CV_16UC1;
  const bool rgb = picture.type() == CV_8UC3 || picture.type() == CV_8UC4;
  if (!grey && !rgb) {
    throw input_error(
        file.string(), "",
        "is not an ID mask: it has " + std::to_string(picture.channels()) + " channels of an unexpected depth",
        "use PNG with one channel of 8 or 16 bit, or 8-bit RGB");
  }
  const bool coded = rgb && is_colored(picture);
  IdImage ids(picture.cols, picture.rows, 1);
  for (int y = 0; y < ids.height; ++y) {
    const uint8_t* row = picture.ptr<uint8_t>(y);
    for (int x = 0; x < ids.width; ++x) {
      const uint8_t* bgr = row + static_cast<size_t>(x) * picture.elemSize();
      if (coded)
        ids(x, y) = bgr[2] + 256u * bgr[1] + 65536u * bgr[0];
      else if (picture.type() == CV_16UC1)
        ids(x, y) = picture.at<uint16_t>(y, x);
      else
        ids(x, y) = *bgr;
    }
  }
  return ids;
}

void write_ids(const fs::path& file, const IdImage& ids) {
  const uint32_t largest = ids.data.empty() ? 0 : *std::max_element(ids.data.begin(), ids.data.end());
  CHECK_MSG(largest <= kLargestId, "IDs above 16777215 do not fit into an image");
  cv::Mat picture(ids.height, ids.width, largest < 256 ? CV_8UC1 : largest < 65536 ? CV_16UC1 : CV_8UC3);
  for (int y = 0; y < ids.height; ++y) {
    for (int x = 0; x < ids.width; ++x) {
      const uint32_t id = ids(x, y);
      if (largest < 256)
        picture.at<uint8_t>(y, x) = static_cast<uint8_t>(id);
      else if (largest < 65536)
        picture.at<uint16_t>(y, x) = static_cast<uint16_t>(id);
      else
        picture.at<cv::Vec3b>(y, x) = cv::Vec3b(uint8_t(id >> 16), uint8_t(id >> 8), uint8_t(id));
    }
  }
  encode(file, picture);
}

}  // namespace pliant
