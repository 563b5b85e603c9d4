#pragma once

#include <array>
#include <filesystem>
#include <vector>

namespace pliant {

/// Extensions of the images that read_image reads, in lower case and with their dot.
inline constexpr std::array<const char*, 7> kImageExtensions = {".png", ".jpg", ".jpeg", ".webp",
                                                                ".bmp", ".tif", ".tiff"};

/// Whether a file is an image that read_image reads, by its extension in upper or lower case.
bool is_image_file(const std::filesystem::path& file);
/// Whether it is a photo in a format that read_image does not read (HEIC, HEIF, AVIF, DNG), by its extension.
bool is_unread_photo_file(const std::filesystem::path& file);
bool is_jpeg_file(const std::filesystem::path& file);

/// The image files of a folder, without hidden ones, by name; none where there is no folder.
std::vector<std::filesystem::path> images_in(const std::filesystem::path& folder);

}  // namespace pliant
