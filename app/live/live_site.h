#pragma once

#include <functional>
#include <mutex>
#include <vector>

#include "app/live/local_server.h"

namespace pliant {

/// What a browser is sent, and who answers the WebSocket that it opens.
struct LiveScreen {
  LocalServer::Page page;
  std::function<std::unique_ptr<Client>(std::shared_ptr<Connection>)> connect;
};

/// Shows one screen after another at one address.  A screen is forgotten when another is shown: its clients, which may
/// still be there, own what they use.
class LiveSite {
 public:
  /// From any thread.  Browsers see it when they load the page anew.
  void show(LiveScreen screen) {
    auto next = std::make_shared<const LiveScreen>(std::move(screen));
    const std::lock_guard lock(mutex_);
    screen_.swap(next);
  }
  /// Sends a text to all clients, of earlier screens too.  From any thread.
  void tell(const std::string& text) {
    const std::lock_guard lock(mutex_);
    for (const std::weak_ptr<Connection>& client : clients_)
      if (const auto connection = client.lock()) connection->send_text(text);
  }
  /// `drop` takes files that pages send, see LocalServer.  Before the site is served.
  void take_files(std::function<std::string(const std::string&, const std::filesystem::path&)> drop) {
    drop_ = std::move(drop);
  }
  /// `stop` ends a thread that tells or shows things, when the site is served no more and its server is still there.
  /// From any thread.
  void at_end(std::function<void()> stop) {
    const std::lock_guard lock(mutex_);
    stops_.push_back(std::move(stop));
  }
  /// Ends them in the order in which they came.
  void end() {
    for (size_t k = 0;; ++k) {
      std::function<void()> stop;
      {
        const std::lock_guard lock(mutex_);
        if (k == stops_.size()) return stops_.clear();
        stop = stops_[k];
      }
      stop();
    }
  }
  LocalServer::Handler handler() {
    return {[this](std::string_view path) -> std::shared_ptr<const LocalServer::Page> {
              const std::shared_ptr<const LiveScreen> screen = path.empty() ? latest() : nullptr;
              if (!screen) return nullptr;
              return {screen, &screen->page};
            },
            [this](std::shared_ptr<Connection> connection) {
              remember(connection);
              return latest()->connect(std::move(connection));
            },
            drop_};
  }

 private:
  std::shared_ptr<const LiveScreen> latest() const {
    const std::lock_guard lock(mutex_);
    return screen_;
  }

  void remember(const std::shared_ptr<Connection>& connection) {
    const std::lock_guard lock(mutex_);
    std::erase_if(clients_, [](const auto& client) { return client.expired(); });
    clients_.push_back(connection);
  }

  mutable std::mutex mutex_;
  std::shared_ptr<const LiveScreen> screen_;  // null before the first
  std::vector<std::weak_ptr<Connection>> clients_;
  std::vector<std::function<void()>> stops_;
  std::function<std::string(const std::string&, const std::filesystem::path&)> drop_;
};

}  // namespace pliant
