#include "fitting/observe/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <vector>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr int kPollMilliseconds = 100;
constexpr size_t kLongestLine = 1 << 20, kLastWords = 400;

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

}  // namespace

ChildProcess::ChildProcess(ChildOptions options) : options_(std::move(options)) {
  // A program that ends must show as a failed write, not as a signal that ends this one.
  signal(SIGPIPE, SIG_IGN);
  const auto failed = [&](const char* what) {
    return input_error(options_.command, "", what, "check the command and the free memory");
  };
  const int log = open(options_.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (log < 0) throw input_error(options_.log.string(), "", "cannot be written", "check the folder");
  int to[2] = {-1, -1}, from[2] = {-1, -1};
  if (options_.talks && (pipe2(to, O_CLOEXEC) != 0 || pipe2(from, O_CLOEXEC) != 0))
    throw failed("cannot be given pipes");
  const std::string script = options_.command + " \"$1\"";
  std::vector<const char*> words = {"/bin/sh", "-c", script.c_str(), "sh", options_.argument.c_str(), nullptr};
  process_ = fork();
  if (process_ == 0) {
    setpgid(0, 0);
    const int nothing = open("/dev/null", O_RDONLY);
    dup2(options_.talks ? to[0] : nothing, STDIN_FILENO);
    dup2(options_.talks ? from[1] : log, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    execv(words[0], const_cast<char* const*>(words.data()));
    _exit(127);
  }
  close(log);
  if (options_.talks) {
    close(to[0]);
    close(from[1]);
    input_ = to[1];
    output_ = from[0];
    fcntl(input_, F_SETFL, O_NONBLOCK);
  }
  if (process_ < 0) throw failed("cannot be started");
  setpgid(process_, process_);
}

ChildProcess::~ChildProcess() {
  kill();
  close_input();
  if (output_ >= 0) close(output_);
}

void ChildProcess::look_for_interrupt() const {
  if (options_.interrupted && options_.interrupted())
    throw Error(Failure::kInterrupted, options_.command, "", "was interrupted", "run the command again to continue");
}

bool ChildProcess::write_line(const std::string& line, double seconds) {
  const std::string text = line + "\n";
  const double end = now() + seconds;
  for (size_t sent = 0; sent < text.size();) {
    if (input_ < 0) return false;
    const ssize_t count = ::write(input_, text.data() + sent, text.size() - sent);
    if (count > 0) {
      sent += static_cast<size_t>(count);
    } else if (count < 0 && errno == EAGAIN) {
      if (now() > end) return false;
      pollfd ready{input_, POLLOUT, 0};
      poll(&ready, 1, kPollMilliseconds);
      look_for_interrupt();
    } else if (count == 0 || errno != EINTR) {
      return false;
    }
  }
  return true;
}

ChildProcess::Read ChildProcess::read_line(std::string& line, double seconds) {
  const double end = now() + seconds;
  while (true) {
    const size_t at = read_.find('\n');
    if (at != std::string::npos) {
      line = read_.substr(0, at);
      read_.erase(0, at + 1);
      return Read::kLine;
    }
    if (output_ < 0 || read_.size() > kLongestLine) return Read::kEnd;
    if (now() > end) return Read::kTooLate;
    pollfd ready{output_, POLLIN, 0};
    if (poll(&ready, 1, kPollMilliseconds) > 0) {
      char buffer[4096];
      const ssize_t count = ::read(output_, buffer, sizeof buffer);
      if (count > 0) read_.append(buffer, static_cast<size_t>(count));
      if (count == 0) return Read::kEnd;
    }
    look_for_interrupt();
  }
}

void ChildProcess::close_input() {
  if (input_ >= 0) {
    close(input_);
    input_ = -1;
  }
}

std::optional<int> ChildProcess::wait(double seconds) {
  const double end = now() + seconds;
  while (!code_) {
    int status = 0;
    if (waitpid(process_, &status, WNOHANG) == process_) {
      code_ = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
      break;
    }
    if (now() > end) return std::nullopt;
    usleep(5000);
    look_for_interrupt();
  }
  return code_;
}

void ChildProcess::kill() {
  // The group may outlive its first process.
  if (process_ > 0) ::kill(-process_, SIGKILL);
  if (process_ > 0 && !code_) {
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    code_ = 128 + SIGKILL;
  }
}

std::string ChildProcess::last_words() const {
  std::ifstream in(options_.log, std::ios::binary | std::ios::ate);
  if (!in) return "";
  const auto size = static_cast<size_t>(std::max<std::streamoff>(0, in.tellg()));
  std::string text(std::min(size, kLastWords), '\0');
  in.seekg(static_cast<std::streamoff>(size - text.size()));
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.empty() ? "" : "; its last output: " + text;
}

}  // namespace pliant
