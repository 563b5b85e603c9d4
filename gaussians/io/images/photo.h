#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string_view>

#include "gaussians/base/image.h"

namespace pliant {

/// A photo as it is stored: the orientation tag is not applied.
struct Photo {
  ImageU8 pixels;       ///< [H, W, 3]; grey photos have three equal channels, 16-bit ones are rounded to 8
  ImageU8 alpha;        ///< [H, W, 1]; empty when every pixel is opaque
  int orientation = 1;  ///< EXIF tag 274, 1 to 8; 1 = upright
};

/// Decodes a photo.  Throws Error{kInput} naming the file, also when a JPEG ends before its picture does.
Photo read_photo(const std::filesystem::path& file);

/// The EXIF orientation in the bytes of a JPEG or PNG; 1 when there is none or it makes no sense.
int exif_orientation(std::string_view bytes);

/// What the head of a JPEG or PNG says of the picture as it is stored.
struct PhotoHead {
  int width = 0, height = 0;  ///< 0 = not found
  int orientation = 1;        ///< as in Photo
};
/// Reads the head without decoding the picture, of a JPEG up to its frame header; all is as by default for files of
/// other kinds.
PhotoHead read_photo_head(const std::filesystem::path& file);

/// Whether the bytes of a JPEG reach its end marker.  Decoders fill what is missing with grey and say nothing.
bool jpeg_is_whole(std::string_view bytes);

/// Right and down of the upright picture in the stored one, a column each.
Eigen::Matrix2i stored_from_upright(int orientation);

/// The picture turned and mirrored as the orientation tag (1 to 8) says.
template <class T>
Image<T> oriented(const Image<T>& stored, int orientation);

}  // namespace pliant
