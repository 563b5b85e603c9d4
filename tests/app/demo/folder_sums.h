#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "gaussians/io/files/files.h"

namespace pliant {

/// Name and SHA-256 of every file below a folder, except encoded videos.
inline std::map<std::string, std::string> folder_sums(const std::filesystem::path& folder) {
  std::map<std::string, std::string> sums;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().extension() != ".mp4")
      sums[std::filesystem::relative(entry.path(), folder).string()] = sha256_of_file(entry.path());
  return sums;
}

}  // namespace pliant
