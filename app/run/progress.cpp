#include "app/run/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace pliant {

Progress::Progress(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO)) {}

void Progress::say(const std::string& sentence) {
  tell({sentence});
  if (!quiet_) std::fprintf(stderr, "%s\n", sentence.c_str());
}

void Progress::warn(const std::string& sentence) {
  tell({sentence, true});
  std::fprintf(stderr, "warning: %s\n", sentence.c_str());
}

void Progress::begin(const std::string& name, int total) {
  name_ = name;
  total_ = std::max(total, 1);
  last_percent_ = last_told_ = -1;
  tell({name, false, 0});
  start_ = last_draw_ = std::chrono::steady_clock::now();
}

void Progress::done(int steps, const std::string& detail, std::optional<double> seconds_left) {
  const double fraction = std::clamp(static_cast<double>(steps) / total_, 0.0, 1.0);
  const int percent = static_cast<int>(100 * fraction);
  if (percent != last_told_) tell({name_, false, fraction});
  last_told_ = percent;
  if (quiet_) return;
  const auto now = std::chrono::steady_clock::now();
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double left = seconds_left ? *seconds_left : fraction > 0 ? elapsed * (1 - fraction) / fraction : 0;
  const double since_draw = std::chrono::duration<double>(now - last_draw_).count();
  if (terminal_) {
    if (percent == last_percent_ && (detail.empty() || since_draw < 0.5)) return;
    const int filled = percent / 4;
    std::fprintf(stderr, "\r  %-22s [%s%s] %3d %%  %4.0f s left  %s\x1b[K", name_.c_str(),
                 std::string(filled, '#').c_str(), std::string(25 - filled, '.').c_str(), percent, left,
                 detail.c_str());
    std::fflush(stderr);
    last_draw_ = now;
  } else if (since_draw > 10) {
    std::fprintf(stderr, "  %s: %d %%, %.0f s left%s%s\n", name_.c_str(), percent, left, detail.empty() ? "" : "; ",
                 detail.c_str());
    last_draw_ = now;
  }
  last_percent_ = percent;
}

void Progress::end() {
  if (!quiet_ && terminal_ && last_percent_ >= 0) std::fprintf(stderr, "\n");
  last_percent_ = -1;
}

}  // namespace pliant
