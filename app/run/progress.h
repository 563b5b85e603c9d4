#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>

namespace pliant {

/// What a command says of itself while it works.
struct ProgressEvent {
  std::string text;  ///< a sentence, or the name of the work that is under way
  bool warning = false;
  double fraction = -1;  ///< of that work, 0 to 1; below 0 = `text` is a sentence
};

/// Messages and progress of a command on standard error: a bar with the remaining time on a terminal, plain lines
/// elsewhere, nothing when quiet.
class Progress {
 public:
  explicit Progress(bool quiet);
  /// `listener` is told as well, whether quiet or not, on the thread that works.
  void listen(std::function<void(const ProgressEvent&)> listener) { listener_ = std::move(listener); }

  void say(const std::string& sentence);
  void warn(const std::string& sentence);
  /// Starts a named piece of work of `total` steps; `done(k)` redraws the bar, `end` closes its line.  `detail` stands
  /// behind the bar; `seconds_left` replaces the estimate from the steps so far.
  void begin(const std::string& name, int total);
  void done(int steps, const std::string& detail = "", std::optional<double> seconds_left = {});
  void end();

 private:
  void tell(const ProgressEvent& event) const {
    if (listener_) listener_(event);
  }

  std::function<void(const ProgressEvent&)> listener_;
  bool quiet_, terminal_;
  std::string name_;
  int total_ = 0, last_percent_ = -1, last_told_ = -1;
  std::chrono::steady_clock::time_point start_, last_draw_;
};

/// What every stage is given by the program.
struct Context {
  Progress& progress;
  std::function<bool()> interrupted;  ///< true after SIGINT, SIGTERM or SIGHUP
  uint64_t seed = 1;
  int threads = 0;
  bool overwrite = false;
};

}  // namespace pliant
