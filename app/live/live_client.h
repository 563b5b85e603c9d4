#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <mutex>
#include <thread>

#include "app/live/live_messages.h"
#include "app/live/local_server.h"
#include "app/live/recording.h"

namespace pliant {

/// The simulation of one client of `pliant view`, in a thread of its own: it never waits for the network.  What was
/// done is kept in files live_0001.json, ... of a folder, when it ends and about every second, more rarely where that
/// takes long (see RecordingText).
class LiveClient : public Client {
 public:
  /// `warn` is told what else only the client would hear, in the thread; null = nobody is.  After `glance_every` of a
  /// frame that takes longer, a client whose frames run is sent how far it has come, see message_within.
  LiveClient(std::shared_ptr<const LiveScene> scene, std::filesystem::path recordings,
             std::shared_ptr<Connection> connection, std::function<void(const std::string&)> warn = {},
             std::chrono::milliseconds glance_every = std::chrono::milliseconds(200));
  ~LiveClient() override;

  void receive(std::string text) override;
  bool takes_more() const override;

 private:
  using Clock = std::chrono::steady_clock;

  void work();
  void handle(const std::string& text);
  void begin(const LiveStart& start);
  void advance();
  void show_within();
  void send_state(std::optional<int> id);
  std::optional<Clock::time_point> next_due() const;
  bool is_unsaved() const;
  void save(bool ended);
  nlohmann::json description() const;

  const std::shared_ptr<const LiveScene> scene_;
  const std::filesystem::path recordings_;
  const std::shared_ptr<Connection> connection_;
  const std::function<void(const std::string&)> warn_;
  const std::chrono::milliseconds glance_every_;

  mutable std::mutex mutex_;
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
  Clock::time_point due_, save_due_;
  Clock::time_point shown_;                 // when the frame began, or was shown as far as it had come
  std::optional<RecordingText> recording_;  // of this session
  std::filesystem::path file_;
  size_t saved_commands_ = 0;
  int saved_frames_ = 0;
  bool unkept_ = false;  // the last time it could not be saved
  std::thread thread_;
};

}  // namespace pliant
