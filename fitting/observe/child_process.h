#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace pliant {

struct ChildOptions {
  std::string command;  ///< for the shell; gets `argument` as one more word at its end
  std::string argument;
  std::filesystem::path log;  ///< takes standard error, and standard output unless `talks`
  bool talks = false;         ///< standard input and output are lines to and from this program
  std::function<bool()>
      interrupted;  ///< asked ten times a second while waiting; true ends the wait with Error{kInterrupted}
};

/// Another program, in a process group of its own.  What is left of the group is killed with the object.
class ChildProcess {
 public:
  enum class Read { kLine, kEnd, kTooLate };

  explicit ChildProcess(ChildOptions options);  ///< throws Error{kInput} when no process can be made
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;

  bool write_line(const std::string& line, double seconds);  ///< false when the program does not read it
  Read read_line(std::string& line, double seconds);
  void close_input();
  /// Exit code, 128 + n after signal n; empty when it still runs after `seconds`.
  std::optional<int> wait(double seconds);
  void kill();

  /// The end of the log, for messages.
  std::string last_words() const;

 private:
  void look_for_interrupt() const;

  ChildOptions options_;
  int process_ = -1, input_ = -1, output_ = -1;
  std::optional<int> code_;
  std::string read_;
};

}  // namespace pliant
