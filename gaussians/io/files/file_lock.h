#pragma once

#include <filesystem>
#include <string>

namespace pliant {

/// Holds `file`, which it makes, until the end of its life, so that two programs do not write into one folder
/// (fcntl(2): a process does not exclude itself).  Throws Error{kUsage} that names `folder` and the process which holds
/// it; where the file system has no locks, or the file cannot be made, nothing is held.
class FileLock {
 public:
  FileLock(const std::filesystem::path& file, const std::string& folder);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace pliant
