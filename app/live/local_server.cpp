#include "app/live/local_server.h"

#include <fmt/format.h>

#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>
#include <random>
#include <set>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using Clock = std::chrono::steady_clock;

constexpr char kLive[] = "live";
constexpr auto kAsk = std::chrono::milliseconds(200);  // how often `stop` is asked

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<int64_t>(1000 * seconds));
}

/// 128 random bits as hexadecimal digits.
std::string random_token() {
  std::random_device device;  // the system's
  std::string out;
  for (int k = 0; k < 4; ++k) out += fmt::format("{:08x}", static_cast<uint32_t>(device()));
  return out;
}

/// Whether two texts are equal, in a time that does not tell where they differ.
bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (size_t k = 0; k < a.size(); ++k) difference |= static_cast<unsigned char>(a[k] ^ b[k]);
  return difference == 0;
}

std::string_view text_of(boost::string_view s) { return {s.data(), s.size()}; }

}  // namespace

namespace {
class Socket;
}

struct LocalServer::State {
  // Outlive what refers to them.
  int connections = 0, clients = 0;
  std::set<Socket*> sockets;
  LocalServerOptions options;
  Handler handler;
  asio::io_context context{1};
  tcp::acceptor acceptor{context};
  std::string token = random_token();
  std::set<std::string> hosts;  // that requests may name

  bool knows_host(std::string_view host) const { return options.allow_remote || hosts.count(std::string(host)); }
  bool knows_origin(std::string_view origin) const {
    constexpr std::string_view kScheme = "http://";
    return origin.substr(0, kScheme.size()) == kScheme && knows_host(origin.substr(kScheme.size()));
  }
  void accept();
};

namespace {

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
      : state_(state), counted_(state.clients), socket_(std::move(stream)), timer_(state.context) {
    state_.sockets.insert(this);
  }
  ~Socket() override { state_.sockets.erase(this); }

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

  /// Ends the connection, and the client.
  void drop() {
    if (dropped_) return;
    dropped_ = true;
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

  /// Who sends too fast is read more slowly.
  void wait_and_read() {
    const double rate = state_.options.messages_per_second;
    const auto now = Clock::now();
    allowance_ = std::min(2 * rate, allowance_ + rate * std::chrono::duration<double>(now - last_).count()) - 1;
    last_ = now;
    if (allowance_ >= 0) return read();
    timer_.expires_after(milliseconds(-allowance_ / rate) + std::chrono::milliseconds(1));
    timer_.async_wait([self = shared_from_this()](beast::error_code error) {
      if (!error) self->read();
    });
  }

  State& state_;
  Counted counted_;
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

/// A connection that asks for pages, or becomes a WebSocket.
class Visit : public std::enable_shared_from_this<Visit> {
 public:
  Visit(State& state, tcp::socket socket) : state_(state), counted_(state.connections), stream_(std::move(socket)) {}

  void read() {
    parser_.emplace();
    parser_->header_limit(static_cast<uint32_t>(state_.options.most_header));
    parser_->body_limit(0);
    stream_.expires_after(milliseconds(state_.options.read_timeout));
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](beast::error_code error, size_t) {
      if (!error) return self->answer();
      if (error == http::error::header_limit) self->refuse(http::status::request_header_fields_too_large);
    });
  }

  void refuse(http::status status) {
    auto response = std::make_shared<http::response<http::string_body>>(status, 11);
    response->set(http::field::content_type, "text/plain");
    response->body() = std::string(text_of(http::obsolete_reason(status))) + "\n";
    response->keep_alive(false);
    write(response);
  }

 private:
  void answer() {
    const auto& request = parser_->get();
    if (!state_.knows_host(text_of(request[http::field::host]))) return refuse(http::status::forbidden);
    const bool get = request.method() == http::verb::get;
    if (!get && request.method() != http::verb::head) return refuse(http::status::method_not_allowed);
    // /TOKEN/path, and nothing else: no file of the machine is ever looked up.
    const std::string_view target = text_of(request.target());
    const size_t slash = target.find('/', 1);
    if (target.empty() || target[0] != '/' || slash == std::string_view::npos ||
        !same_secret(target.substr(1, slash - 1), state_.token))
      return refuse(http::status::forbidden);
    const std::string_view path = target.substr(slash + 1);
    if (websocket::is_upgrade(request)) return upgrade(path);
    const LocalServer::Page* const page = state_.handler.page(path);
    if (!page) return refuse(http::status::not_found);
    auto response = std::make_shared<http::response<http::string_body>>(http::status::ok, request.version());
    response->set(http::field::content_type, page->type);
    response->set("Content-Security-Policy", page->security_policy);
    if (get)
      response->body() = page->body;
    else
      response->content_length(page->body.size());
    response->keep_alive(get && request.keep_alive());
    write(response);
  }

  void upgrade(std::string_view path) {
    const auto& request = parser_->get();
    const auto origin = request.find(http::field::origin);  // programs send none
    if (path != kLive) return refuse(http::status::not_found);
    if (origin != request.end() && !state_.knows_origin(text_of(origin->value())))
      return refuse(http::status::forbidden);
    if (state_.clients >= state_.options.most_clients) return refuse(http::status::service_unavailable);
    stream_.expires_never();  // the WebSocket has limits of its own
    std::make_shared<Socket>(state_, std::move(stream_))->start(request);
  }

  void write(const std::shared_ptr<http::response<http::string_body>>& response) {
    response->set(http::field::server, "pliant");
    response->set(http::field::cache_control, "no-store");
    response->set("X-Content-Type-Options", "nosniff");
    response->set("X-Frame-Options", "DENY");
    response->set("Referrer-Policy", "no-referrer");
    response->set("Cross-Origin-Opener-Policy", "same-origin");
    response->set("Cross-Origin-Resource-Policy", "same-origin");
    if (!response->has_content_length()) response->prepare_payload();
    stream_.expires_after(milliseconds(state_.options.idle_timeout));
    http::async_write(stream_, *response, [self = shared_from_this(), response](beast::error_code error, size_t) {
      if (error) return;
      if (response->keep_alive()) return self->read();
      beast::error_code ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    });
  }

  State& state_;
  Counted counted_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::empty_body>> parser_;
};

}  // namespace

void LocalServer::State::accept() {
  acceptor.async_accept([this](beast::error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error) {
      auto visit = std::make_shared<Visit>(*this, std::move(socket));
      if (connections > options.most_connections)
        visit->refuse(http::status::service_unavailable);
      else
        visit->read();
    }
    accept();
  });
}

LocalServer::LocalServer(const LocalServerOptions& options, Handler handler) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.options = options;
  s.handler = std::move(handler);
  beast::error_code error;
  const asio::ip::address address = asio::ip::make_address(options.host, error);
  if (error) throw usage_error("--host", options.host, "is no IP address", "give one such as 127.0.0.1");
  if (!address.is_loopback() && !options.allow_remote)
    throw usage_error("--host", options.host, "lets others on the network in", "add --allow-remote if that is meant");
  const tcp::endpoint endpoint(address, static_cast<uint16_t>(options.port));
  s.acceptor.open(endpoint.protocol(), error);
  if (!error) s.acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) s.acceptor.bind(endpoint, error);
  if (!error) s.acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error)
    throw usage_error("--port", std::to_string(options.port), "cannot be used: " + error.message(),
                      "give another one, or 0 for any");
  for (const char* name : {"127.0.0.1", "localhost", "[::1]"}) s.hosts.insert(fmt::format("{}:{}", name, port()));
  s.accept();
}

LocalServer::~LocalServer() {
  for (Socket* const socket : std::set<Socket*>(state_->sockets)) socket->drop();
}

int LocalServer::port() const { return state_->acceptor.local_endpoint().port(); }

std::string LocalServer::url() const {
  const std::string& host = state_->options.host;
  const bool v6 = host.find(':') != std::string::npos;
  return fmt::format("http://{}:{}/{}/", v6 ? "[" + host + "]" : host, port(), state_->token);
}

void LocalServer::run(const std::function<bool()>& stop) {
  while (!stop()) state_->context.run_for(kAsk);
}

}  // namespace pliant
