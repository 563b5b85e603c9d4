#pragma once

#include <mutex>
#include <vector>

#include "app/live/local_server.h"

namespace pliant {

/// What a browser is sent, and who answers the WebSocket that it opens.
struct LiveScreen {
  LocalServer::Page page;
  std::function<std::unique_ptr<Client>(std::shared_ptr<Connection>)> connect;
};

/// Shows one screen after another at one address.  What it is shown lives as long as the site: clients of an earlier
/// screen may still be there.
class LiveSite {
 public:
  /// From any thread.  Browsers see it when they load the page anew.
  void show(LiveScreen screen) {
    const std::lock_guard lock(mutex_);
    screens_.push_back(std::make_unique<const LiveScreen>(std::move(screen)));
  }
  LocalServer::Handler handler() const {
    return {[this](std::string_view path) { return path.empty() && latest() ? &latest()->page : nullptr; },
            [this](std::shared_ptr<Connection> connection) { return latest()->connect(std::move(connection)); }};
  }

 private:
  const LiveScreen* latest() const {
    const std::lock_guard lock(mutex_);
    return screens_.empty() ? nullptr : screens_.back().get();
  }

  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<const LiveScreen>> screens_;
};

}  // namespace pliant
