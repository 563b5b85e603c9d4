#pragma once

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <thread>

#include "app/choose/choose_page.h"
#include "app/live/live_site.h"
#include "app/run/progress.h"

namespace pliant {

/// Tells `tell` what a page is to show of the work under `progress`: {"progress": {"text", "fraction"}} and {"said",
/// "warning"}.  Sentences are said by `outer` too.
void tell_progress(Progress& progress, const Context& outer, std::function<void(const nlohmann::json&)> tell);

/// The page on which a file of splats can be dropped.
LocalServer::Page open_page();

/// A site that begins without a scene: it opens the first file of splats that is dropped on its page.
class Opener {
 public:
  /// `open` makes the site show the scene in a file, in a thread of the opener; what it throws is told to the page, and
  /// another file may follow.  Each file is kept in a folder of its own below `folder`, away from the cameras of other
  /// scenes; file and folder have a number where their name is taken, or where there is the run directory that `run_of`
  /// the scene names.
  Opener(const Context& context, LiveSite& site, std::filesystem::path folder,
         std::function<std::filesystem::path(const std::filesystem::path& scene)> run_of,
         std::function<void(const Context&, const std::filesystem::path& scene)> open);
  ~Opener();

  void show();
  /// Takes a file from the server: why it is refused, or nothing.
  std::string take(const std::string& name, const std::filesystem::path& file);

 private:
  std::filesystem::path free_place(const std::filesystem::path& name) const;
  void stop();
  void work();
  void tell(const nlohmann::json& message);

  const Context& context_;
  LiveSite& site_;
  const std::filesystem::path folder_;
  const std::function<std::filesystem::path(const std::filesystem::path&)> run_of_;
  const std::function<void(const Context&, const std::filesystem::path&)> open_;

  std::mutex mutex_;
  std::condition_variable wake_;
  std::filesystem::path scene_;  // to be opened; empty = none
  bool taken_ = false;           // one is open or being opened
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

}  // namespace pliant
