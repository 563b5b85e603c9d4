#include <algorithm>
#include <cctype>

#include "gaussians/io/cameras/camera_file.h"
#include "gaussians/io/files/paths.h"
#include "gaussians/io/images/image_files.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

/// None, then those of images as they are written: .jpg, .JPG, .Jpg.
std::vector<std::string> make_photo_suffixes() {
  std::vector<std::string> suffixes = {""};
  for (const size_t capitals : {size_t{0}, std::string::npos, size_t{1}})
    for (std::string suffix : kImageExtensions) {
      for (size_t i = 1; i < suffix.size() && i <= capitals; ++i)
        suffix[i] = static_cast<char>(std::toupper(static_cast<unsigned char>(suffix[i])));
      suffixes.push_back(std::move(suffix));
    }
  return suffixes;
}

/// The path in a folder with fewer and fewer of its first folders.
void add_shortened(const fs::path& folder, const fs::path& whole, std::vector<fs::path>& stems) {
  const fs::path below_root = whole.relative_path();
  for (auto first = below_root.begin(); first != below_root.end(); ++first) {
    fs::path rest;
    for (auto part = first; part != below_root.end(); ++part) rest /= *part;
    if (rest != whole) stems.push_back(folder / rest);
  }
}

}  // namespace

fs::path with_slashes(std::string path) {
  std::replace(path.begin(), path.end(), '\\', '/');
  return path;
}

fs::path find_photo(const fs::path& photos, const std::vector<fs::path>& folders, const std::string& name,
                    PhotoFit fit) {
  static const std::vector<std::string> suffixes = make_photo_suffixes();
  std::vector<fs::path> stems;
  if (!photos.empty()) {
    stems = {photos / name};
    add_shortened(photos, name, stems);
  }
  for (const fs::path& folder : folders) stems.push_back(folder / name);
  if (photos.empty() && fit != PhotoFit::kView)
    for (const fs::path& folder : folders) add_shortened(folder, name, stems);
  for (const fs::path& stem : stems) {
    for (const std::string& suffix : suffixes) {
      std::error_code ignored;
      const fs::path candidate = stem.string() + suffix;
      if (fs::is_regular_file(candidate, ignored)) return tidy_path(candidate);
    }
  }
  const std::string slashed = with_slashes(name).string();
  return slashed == name ? fs::path() : find_photo(photos, folders, slashed, fit);
}

std::string name_of_photo(const fs::path& file) {
  const fs::path photo = with_slashes(file.string());
  const std::string suffix = photo.extension().string();
  return (suffix.size() > 1 && std::isalpha(static_cast<unsigned char>(suffix[1])) ? photo.stem() : photo.filename())
      .string();
}

std::string long_name_of_photo(const fs::path& photo) {
  const fs::path path = with_slashes(photo.string()).lexically_normal();
  std::string name = (path.parent_path() / name_of_photo(path)).generic_string();
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

std::string full_name_of_photo(const fs::path& photo) {
  const fs::path path = with_slashes(photo.string());
  const std::string suffix = path.filename().string().substr(name_of_photo(path).size());
  return long_name_of_photo(photo) + (suffix.empty() ? "" : "_" + suffix.substr(1));
}

}  // namespace pliant
