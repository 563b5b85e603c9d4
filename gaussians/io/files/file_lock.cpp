#include "gaussians/io/files/file_lock.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

#include "gaussians/base/error.h"

namespace pliant {

FileLock::FileLock(const std::filesystem::path& file, const std::string& folder)
    : descriptor_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0) return;
  struct flock lock = {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  if (fcntl(descriptor_, F_SETLK, &lock) == 0 || (errno != EACCES && errno != EAGAIN)) return;
  const bool known = fcntl(descriptor_, F_GETLK, &lock) == 0 && lock.l_type != F_UNLCK && lock.l_pid > 0;
  ::close(descriptor_);
  throw usage_error(folder, "",
                    "is being written by another pliant process" +
                        (known ? " (process " + std::to_string(lock.l_pid) + ")" : std::string()),
                    "wait for it, or use another folder");
}

FileLock::~FileLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace pliant
