#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "segmentation/models/channel.h"

namespace pliant {

/// A program of its own that runs one network and talks over a socket.  What goes wrong inside (an abort, a loop
/// without end, all memory used up) ends that program and is an Error here; libraries, threads and OpenMP settings of
/// the network stay out of this one.  It ends when this object goes, or when this program ends in whatever way.
class WorkerProcess {
 public:
  /// `program` is one of the workers built beside pliant.  Throws Error{kInput} when it cannot be started.
  explicit WorkerProcess(const std::filesystem::path& program);
  ~WorkerProcess();
  WorkerProcess(const WorkerProcess&) = delete;

  /// Sends `request` and waits for the answer; throws std::runtime_error with one sentence when there is none within
  /// `seconds`, or one of more than `most` bytes.
  Message ask(const Message& request, double seconds, uint64_t most);

 private:
  std::string ending();

  std::unique_ptr<Channel> channel_;
  int process_ = -1;
};

/// The folder of the running program, where the workers are.
std::filesystem::path program_folder();

}  // namespace pliant
