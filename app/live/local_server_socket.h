// Internal to local_server.cpp: what its connections share, and its WebSockets.
#pragma once

#include <fcntl.h>
#include <fmt/format.h>

#include <atomic>
#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>
#include <optional>
#include <random>
#include <set>

#include "app/live/local_server.h"

namespace pliant::serving {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using Clock = std::chrono::steady_clock;

inline std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<int64_t>(1000 * seconds));
}

/// 128 random bits as hexadecimal digits.
inline std::string random_token() {
  std::random_device device;  // the system's
  std::string out;
  for (int k = 0; k < 4; ++k) out += fmt::format("{:08x}", static_cast<uint32_t>(device()));
  return out;
}

/// Keeps a socket from programs that this one starts.
template <class AnySocket>
void close_on_exec(AnySocket& socket) {
  fcntl(socket.native_handle(), F_SETFD, FD_CLOEXEC);
}

inline std::string_view text_of(boost::string_view s) { return {s.data(), s.size()}; }

class Socket;

}  // namespace pliant::serving

struct pliant::LocalServer::State {
  // Outlive what refers to them.
  int connections = 0, clients = 0;
  std::set<serving::Socket*> sockets;
  LocalServerOptions options;
  Handler handler;
  serving::asio::io_context context{1};
  serving::tcp::acceptor acceptor{context};
  std::string token = serving::random_token();
  std::set<std::string> hosts;  // that requests may name
  bool uploading = false;

  /// As an address names it; other machines reach all addresses of this one by its name.
  std::string host() const {
    if (serving::asio::ip::make_address(options.host).is_unspecified()) return serving::asio::ip::host_name();
    return options.host.find(':') == std::string::npos ? options.host : "[" + options.host + "]";
  }
  bool knows_host(std::string_view host) const { return options.allow_remote || hosts.count(std::string(host)); }
  bool knows_origin(std::string_view origin) const {
    constexpr std::string_view kScheme = "http://";
    return origin.substr(0, kScheme.size()) == kScheme && knows_host(origin.substr(kScheme.size()));
  }
  void accept();
};

namespace pliant::serving {

using State = LocalServer::State;

/// Counts something as long as it lives.
class Counted {
 public:
  explicit Counted(int& count) : count_(count) { ++count_; }
  ~Counted() { --count_; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

 private:
  int& count_;
};

/// A WebSocket.  Everything but the functions of Connection runs on the server's thread.
class Socket : public Connection, public std::enable_shared_from_this<Socket> {
 public:
  Socket(State& state, beast::tcp_stream stream)
      : state_(state), counted_(std::in_place, state.clients), socket_(std::move(stream)), timer_(state.context) {
    state_.sockets.insert(this);
  }
  ~Socket() override {
    if (!dropped_) state_.sockets.erase(this);
  }

  void start(const http::request<http::empty_body>& request) {
    websocket::stream_base::timeout timeout;
    timeout.handshake_timeout = milliseconds(state_.options.read_timeout);
    timeout.idle_timeout = milliseconds(state_.options.idle_timeout);
    timeout.keep_alive_pings = true;
    socket_.set_option(timeout);
    socket_.read_message_max(state_.options.most_message);
    socket_.async_accept(request, [self = shared_from_this()](beast::error_code error) {
      if (error) return;
      self->client_ = self->state_.handler.connect(self);
      self->read();
    });
  }

  void send_text(std::string text) override { send(std::move(text), false); }
  void send_bytes(std::string bytes) override { send(std::move(bytes), true); }
  bool idle() const override { return unread_ == 0; }
  void close() override {
    asio::post(state_.context, [self = shared_from_this()] { self->drop(); });
  }

  /// Ends the connection, and the client.  The last reference may be released by another thread, after this alone.
  void drop() {
    if (dropped_) return;
    dropped_ = true;
    state_.sockets.erase(this);
    counted_.reset();
    timer_.cancel();
    beast::get_lowest_layer(socket_).close();
    client_.reset();
  }

 private:
  struct Message {
    std::string data;
    bool binary;
  };

  void send(std::string data, bool binary) {
    unread_ += data.size();
    asio::post(state_.context, [self = shared_from_this(), m = Message{std::move(data), binary}]() mutable {
      if (self->dropped_) return;
      if (self->unread_ > self->state_.options.most_unread) return self->drop();
      self->queue_.push_back(std::move(m));
      if (self->queue_.size() == 1) self->write();
    });
  }

  void write() {
    socket_.binary(queue_.front().binary);
    socket_.async_write(asio::buffer(queue_.front().data),
                        [self = shared_from_this()](beast::error_code error, size_t) {
                          if (error) return self->drop();
                          self->unread_ -= self->queue_.front().data.size();
                          self->queue_.pop_front();
                          if (!self->queue_.empty()) self->write();
                        });
  }

  void read() {
    socket_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, size_t) {
      if (error || !self->client_ || !self->socket_.got_text()) return self->drop();
      self->client_->receive(beast::buffers_to_string(self->buffer_.data()));
      self->buffer_.consume(self->buffer_.size());
      self->wait_and_read();
    });
  }

  /// Who sends too fast is read more slowly.  Of one who has to wait for its client a message is read now and then all
  /// the same: a connection of which nothing is read would count as dead.
  void wait_and_read() {
    if (!client_->takes_more() && Clock::now() - last_ < milliseconds(state_.options.idle_timeout / 4))
      return wait(kAskAgain, [this] { wait_and_read(); });
    const double rate = state_.options.messages_per_second;
    const auto now = Clock::now();
    allowance_ = std::min(2 * rate, allowance_ + rate * std::chrono::duration<double>(now - last_).count()) - 1;
    last_ = now;
    if (allowance_ >= 0) return read();
    wait(milliseconds(-allowance_ / rate) + std::chrono::milliseconds(1), [this] { read(); });
  }

  template <class Next>
  void wait(std::chrono::milliseconds time, Next next) {
    timer_.expires_after(time);
    timer_.async_wait([self = shared_from_this(), next](beast::error_code error) {
      if (!error && !self->dropped_) next();
    });
  }

  static constexpr std::chrono::milliseconds kAskAgain{10};

  State& state_;
  std::optional<Counted> counted_;
  websocket::stream<beast::tcp_stream> socket_;
  asio::steady_timer timer_;
  beast::flat_buffer buffer_;
  std::unique_ptr<Client> client_;
  std::deque<Message> queue_;
  std::atomic<size_t> unread_ = 0;
  double allowance_ = 0;
  Clock::time_point last_ = Clock::now();
  bool dropped_ = false;
};

}  // namespace pliant::serving
