#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <mutex>
#include <thread>

#include "app/live/live_messages.h"
#include "app/live/local_server.h"

namespace pliant {

/// The simulation of one client of `pliant view`, in a thread of its own: it never waits for the network.  What was
/// done is kept in files live_0001.json, ... of a folder, about every second and when it ends (see recording_json).
class LiveClient : public Client {
 public:
  LiveClient(std::shared_ptr<const LiveScene> scene, std::filesystem::path recordings,
             std::shared_ptr<Connection> connection);
  ~LiveClient() override;

  void receive(std::string text) override;

 private:
  using Clock = std::chrono::steady_clock;

  void work();
  void handle(const std::string& text);
  void begin(const LiveStart& start);
  void advance();
  void send_state(std::optional<int> id);
  void save(bool ended);
  nlohmann::json description() const;

  const std::shared_ptr<const LiveScene> scene_;
  const std::filesystem::path recordings_;
  const std::shared_ptr<Connection> connection_;

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::string> inbox_;
  std::atomic<bool> ended_ = false;  // the client has left: what it asked for is not simulated any more

  // Of the thread.
  LiveStart start_;
  std::unique_ptr<LiveBody> body_;
  std::unique_ptr<LiveSession> session_;
  std::vector<LiveCommand> pending_;  // for the next frame
  LiveAnswer answer_;                 // of the last frame, with holds and failures that were not sent yet
  bool running_ = false;
  Clock::time_point due_, saved_;
  std::filesystem::path file_;  // of this session
  size_t saved_commands_ = 0;
  std::thread thread_;
};

}  // namespace pliant
