#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>

namespace pliant {

/// Messages and progress of a command on standard error: a bar with the remaining time on a terminal, plain lines
/// elsewhere, nothing when quiet.
class Progress {
 public:
  explicit Progress(bool quiet);

  void say(const std::string& sentence);
  void warn(const std::string& sentence);
  /// Starts a named piece of work of `total` steps; `done(k)` redraws the bar, `end` closes its line.  `detail` stands
  /// behind the bar; `seconds_left` replaces the estimate from the steps so far.
  void begin(const std::string& name, int total);
  void done(int steps, const std::string& detail = "", std::optional<double> seconds_left = {});
  void end();

 private:
  bool quiet_, terminal_;
  std::string name_;
  int total_ = 0, last_percent_ = -1;
  std::chrono::steady_clock::time_point start_, last_draw_;
};

/// What every stage is given by the program.
struct Context {
  Progress& progress;
  std::function<bool()> interrupted;  ///< true after SIGINT or SIGTERM
  uint64_t seed = 1;
  int threads = 0;
  bool overwrite = false;
};

}  // namespace pliant
