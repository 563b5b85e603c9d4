#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <vector>

#include "app/live/local_server.h"

namespace pliant {

/// Keeps what is sent.
class Inbox : public Connection {
 public:
  void send_text(std::string text) override { put(std::move(text)); }
  void send_bytes(std::string bytes) override { put(std::move(bytes)); }
  bool idle() const override { return true; }
  void close() override {}
  /// The next message, waiting for it.
  std::string next() {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(wake_.wait_for(lock, std::chrono::seconds(20), [&] { return at_ < messages_.size(); }));
    return at_ < messages_.size() ? messages_[at_++] : std::string();
  }

 private:
  void put(std::string message) {
    const std::lock_guard lock(mutex_);
    messages_.push_back(std::move(message));
    wake_.notify_one();
  }
  std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<std::string> messages_;
  size_t at_ = 0;
};

}  // namespace pliant
