#include "gaussians/io/images/photo.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <opencv2/core.hpp>
#include <string>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/codecs.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

bool is_jpeg(std::string_view bytes) { return bytes.substr(0, 3) == "\xff\xd8\xff"; }

/// Big- or little-endian unsigned number of `size` bytes; 0 when it lies outside.
uint32_t number(std::string_view bytes, size_t at, int size, bool big_endian) {
  if (at > bytes.size() || bytes.size() - at < static_cast<size_t>(size)) return 0;
  uint32_t value = 0;
  for (int k = 0; k < size; ++k) {
    value = value << 8 | static_cast<uint8_t>(bytes[at + (big_endian ? k : size - 1 - k)]);
  }
  return value;
}

/// Orientation in a TIFF header and its first directory (TIFF 6.0, section 2).
int tiff_orientation(std::string_view tiff) {
  const bool big = tiff.substr(0, 2) == "MM";
  if ((!big && tiff.substr(0, 2) != "II") || number(tiff, 2, 2, big) != 42) return 1;
  const size_t directory = number(tiff, 4, 4, big);
  const uint32_t entries = number(tiff, directory, 2, big);
  for (uint32_t i = 0; i < entries; ++i) {
    const size_t entry = directory + 2 + 12 * size_t(i);
    if (entry + 12 > tiff.size()) break;
    if (number(tiff, entry, 2, big) != 274) continue;
    const uint32_t value = number(tiff, entry + 8, 2, big);
    return value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
  }
  return 1;
}

/// Calls use(marker, contents) for the segments of a JPEG until it returns true; passes over the coded pictures.
/// Returns whether it was stopped.
template <class Use>
bool any_jpeg_segment(std::string_view bytes, Use&& use) {
  for (size_t at = 2; at + 2 <= bytes.size();) {
    const auto marker = static_cast<uint8_t>(bytes[at + 1]);
    // Coded data run up to a marker that is neither a stuffed zero, nor fill, nor a restart.
    if (static_cast<uint8_t>(bytes[at]) != 0xff || marker == 0 || marker == 0xff ||
        (marker >= 0xd0 && marker <= 0xd7)) {
      const size_t next = bytes.find('\xff', at + 1);
      if (next == std::string_view::npos) return false;
      at = next;
      continue;
    }
    if (marker == 0xd9) return use(marker, std::string_view());
    const size_t length = number(bytes, at + 2, 2, true);
    if (length < 2 || at + 2 + length > bytes.size()) return false;
    if (use(marker, bytes.substr(at + 4, length - 2))) return true;
    at += 2 + length;
  }
  return false;
}

/// Size in the frame header of a JPEG (ITU T.81, B.2.2) or in the first chunk of a PNG.
void read_stored_size(std::string_view bytes, PhotoHead& head) {
  if (is_jpeg(bytes)) {
    any_jpeg_segment(bytes, [&](uint8_t marker, std::string_view contents) {
      const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
      if (!frame) return marker == 0xda;
      head.height = static_cast<int>(number(contents, 1, 2, true));
      head.width = static_cast<int>(number(contents, 3, 2, true));
      return true;
    });
  } else if (bytes.size() >= 24 && bytes.substr(0, 4) == "\x89PNG" && bytes.substr(12, 4) == "IHDR") {
    head.width = static_cast<int>(std::min(number(bytes, 16, 4, true), 0x7fffffffu));
    head.height = static_cast<int>(std::min(number(bytes, 20, 4, true), 0x7fffffffu));
  }
}

/// At which side of the upright picture the stored rows and columns begin, as the tag tells it.
struct Turn {
  bool swapped, flip_u, flip_v;
};
Turn turn_of(int orientation) {
  CHECK(orientation >= 1 && orientation <= 8);
  return {orientation >= 5, orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8,
          orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7};
}

ImageU8 to_8_bit(const cv::Mat& picture, int first, int channels) {
  ImageU8 image(picture.cols, picture.rows, channels);
  const int stored = picture.channels();
  for (int y = 0; y < image.height; ++y) {
    const uint8_t* row = picture.ptr<uint8_t>(y);
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < channels; ++c) {
        // Colour is stored as B, G, R.
        const int from = x * stored + (stored < 3 ? 0 : channels == 3 ? 2 - c : first);
        image(x, y, c) = row[from];
      }
    }
  }
  return image;
}

}  // namespace

int exif_orientation(std::string_view bytes) {
  int orientation = 1;
  if (is_jpeg(bytes)) {
    any_jpeg_segment(bytes, [&](uint8_t marker, std::string_view contents) {
      const bool exif = marker == 0xe1 && contents.substr(0, 6) == std::string_view("Exif\0\0", 6);
      if (exif) orientation = tiff_orientation(contents.substr(6));
      return exif || marker == 0xda;
    });
  } else if (bytes.substr(0, 4) == "\x89PNG") {
    for (size_t at = 8; at + 12 <= bytes.size();) {
      const size_t length = number(bytes, at, 4, true);
      if (length > bytes.size() - at - 12) break;
      if (bytes.substr(at + 4, 4) == "eXIf") return tiff_orientation(bytes.substr(at + 8, length));
      at += 12 + length;
    }
  }
  return orientation;
}

bool jpeg_is_whole(std::string_view bytes) {
  return is_jpeg(bytes) && any_jpeg_segment(bytes, [](uint8_t marker, std::string_view) { return marker == 0xd9; });
}

PhotoHead read_photo_head(const fs::path& file) {
  constexpr size_t kHead = 1 << 18;  // bytes; the EXIF segment, at most 64 KiB, comes first
  std::string bytes;
  std::ifstream in(file, std::ios::binary);
  PhotoHead head;
  // The frame header of a JPEG follows all metadata, which may be long: profiles, depth maps, other pictures.
  for (size_t piece = kHead; in && head.width == 0; piece *= 2) {
    const size_t before = bytes.size();
    bytes.resize(before + piece);
    in.read(bytes.data() + before, static_cast<std::streamsize>(piece));
    bytes.resize(before + static_cast<size_t>(in.gcount()));
    read_stored_size(bytes, head);
    if (!is_jpeg(bytes)) break;
  }
  head.orientation = exif_orientation(bytes);
  return head;
}

Eigen::Matrix2i stored_from_upright(int orientation) {
  const Turn turn = turn_of(orientation);
  Eigen::Matrix2i axes = Eigen::Vector2i(turn.flip_u ? -1 : 1, turn.flip_v ? -1 : 1).asDiagonal();
  if (turn.swapped) axes.col(0).swap(axes.col(1));
  return axes;
}

template <class T>
Image<T> oriented(const Image<T>& stored, int orientation) {
  const auto [swapped, flip_u, flip_v] = turn_of(orientation);
  if (orientation == 1) return stored;
  Image<T> out(swapped ? stored.height : stored.width, swapped ? stored.width : stored.height, stored.channels);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      int u = swapped ? y : x, v = swapped ? x : y;
      if (flip_u) u = stored.width - 1 - u;
      if (flip_v) v = stored.height - 1 - v;
      std::copy_n(stored.at(u, v), stored.channels, out.at(x, y));
    }
  }
  return out;
}
template ImageU8 oriented(const ImageU8&, int);
template ImageF oriented(const ImageF&, int);

Photo read_photo(const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) throw input_error(file.string(), "", "does not exist", "check the name");
  const std::string bytes = read_text(file);
  if (bytes.empty()) throw input_error(file.string(), "", "is empty", "copy the photo again");
  if (is_jpeg(bytes) && !jpeg_is_whole(bytes))
    throw input_error(file.string(), "", "is a JPEG that ends before its image does", "copy the photo again");
  cv::Mat picture;
  std::string why;
  try {
    const cv::Mat view(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
    picture = codecs::imdecode(view, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& error) {
    why = ": " + error.err;
  }
  if (picture.empty())
    throw input_error(file.string(), "", "is not an image that can be decoded" + why, "copy it again; use PNG or JPEG");
  const int depth = picture.depth();
  if (depth != CV_8U && depth != CV_16U)
    throw input_error(file.string(), "", "has an unusual number format", "use 8-bit or 16-bit images");
  if (depth == CV_16U) picture.convertTo(picture, CV_8U, 1.0 / 257);
  Photo photo;
  photo.orientation = exif_orientation(bytes);
  photo.pixels = to_8_bit(picture, 0, 3);
  if (picture.channels() == 4) {
    photo.alpha = to_8_bit(picture, 3, 1);
    const auto opaque = [](uint8_t a) { return a == 255; };
    if (std::all_of(photo.alpha.data.begin(), photo.alpha.data.end(), opaque)) photo.alpha = {};
  }
  return photo;
}

}  // namespace pliant
