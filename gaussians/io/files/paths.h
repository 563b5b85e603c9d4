#pragma once

#include <filesystem>

namespace pliant {

/// The path without `.` and `..` where that leads to the same file, else the path as it is: `..` behind a symbolic link
/// goes up from where the link leads.
std::filesystem::path tidy_path(const std::filesystem::path& path);

/// How a file in `folder`, which need not exist yet, names `path` (not empty): relative, also where symbolic links lead
/// to either of them.  A link that `path` itself is stays.
std::filesystem::path path_as_seen_from(const std::filesystem::path& folder, const std::filesystem::path& path);

}  // namespace pliant
