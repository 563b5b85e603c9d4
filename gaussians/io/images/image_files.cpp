#include "gaussians/io/images/image_files.h"

#include <algorithm>
#include <cctype>
#include <string>

namespace pliant {
namespace fs = std::filesystem;

namespace {

std::string extension_of(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

}  // namespace

bool is_image_file(const fs::path& file) {
  return std::find(kImageExtensions.begin(), kImageExtensions.end(), extension_of(file)) != kImageExtensions.end();
}

bool is_unread_photo_file(const fs::path& file) {
  const std::string extension = extension_of(file);
  return extension == ".heic" || extension == ".heif" || extension == ".avif" || extension == ".dng";
}

bool is_jpeg_file(const fs::path& file) {
  const std::string extension = extension_of(file);
  return extension == ".jpg" || extension == ".jpeg";
}

std::vector<fs::path> images_in(const fs::path& folder) {
  std::vector<fs::path> images;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none))
    if (entry.is_regular_file(none) && is_image_file(entry.path()) && entry.path().filename().string()[0] != '.')
      images.push_back(entry.path());
  std::sort(images.begin(), images.end());
  return images;
}

}  // namespace pliant
