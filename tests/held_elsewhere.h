#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>

#include "gaussians/io/files/file_lock.h"

namespace pliant {

/// Another process that holds a file (file_lock.h) for as long as this lives.
class HeldElsewhere {
 public:
  explicit HeldElsewhere(const std::filesystem::path& file) {
    int ready[2], done[2];
    if (pipe(ready) != 0 || pipe(done) != 0) throw std::runtime_error("no pipe");
    process_ = fork();
    char byte = 0;
    if (process_ == 0) {
      ::close(done[1]);
      const FileLock lock(file, "");
      if (write(ready[1], &byte, 1) == 1) (void)!read(done[0], &byte, 1);
      _exit(0);
    }
    (void)!read(ready[0], &byte, 1);
    for (const int end : {ready[0], ready[1], done[0]}) ::close(end);
    end_ = done[1];
  }
  ~HeldElsewhere() {
    ::close(end_);
    waitpid(process_, nullptr, 0);
  }
  HeldElsewhere(const HeldElsewhere&) = delete;

  pid_t process() const { return process_; }

 private:
  pid_t process_ = 0;
  int end_ = -1;
};

}  // namespace pliant
