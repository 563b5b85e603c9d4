#include "segmentation/models/worker_process.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

std::string seconds_text(double seconds) {
  std::string text = std::to_string(seconds);
  text.resize(text.find('.') + 2);
  return text + " s";
}

}  // namespace

std::filesystem::path program_folder() { return std::filesystem::read_symlink("/proc/self/exe").parent_path(); }

WorkerProcess::WorkerProcess(const std::filesystem::path& program) {
  int ends[2];
  CHECK(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) == 0);
  channel_ = std::make_unique<Channel>(ends[0]);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], 3);  // where the worker looks for it
  for (const int stream : {0, 1, 2}) posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_RDWR, 0);
  std::string path = program.string();
  char* arguments[] = {path.data(), nullptr};
  const int failed = posix_spawn(&process_, path.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  if (failed) {
    process_ = -1;
    throw input_error(path, "", std::string("cannot be started: ") + std::strerror(failed),
                      "it is built next to pliant and must stay in the same folder");
  }
}

WorkerProcess::~WorkerProcess() {
  if (process_ < 0) return;
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
}

Message WorkerProcess::ask(const Message& request, double seconds, uint64_t most) {
  if (process_ < 0) throw std::runtime_error("the process that ran it has ended");
  Message answer;
  if (!channel_->send(request, seconds)) throw std::runtime_error(ending());
  switch (channel_->receive(answer, seconds, most)) {
    case Channel::Received::kMessage:
      return answer;
    case Channel::Received::kTooLate:
      ending();
      throw std::runtime_error("gave no answer within " + seconds_text(seconds));
    case Channel::Received::kTooBig:
      ending();
      throw std::runtime_error("answers with more than " + std::to_string(most >> 20) + " MB");
    case Channel::Received::kClosed:
      break;
  }
  throw std::runtime_error(ending());
}

/// Ends the process and tells how it went by itself, if it did.
std::string WorkerProcess::ending() {
  int status = 0;
  bool ended = false;
  for (int tenths = 0; !ended && tenths < 5; ++tenths) {  // a closed socket comes a little before the end
    ended = waitpid(process_, &status, WNOHANG) == process_;
    if (!ended) usleep(20000);
  }
  if (!ended) {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  process_ = -1;
  if (ended && WIFSIGNALED(status))
    return "ended the process that ran it by signal " + std::to_string(WTERMSIG(status)) + " (" +
           strsignal(WTERMSIG(status)) + ")";
  return ended ? "ended the process that ran it with exit code " + std::to_string(WEXITSTATUS(status))
               : std::string("no longer communicates with the program");
}

}  // namespace pliant
