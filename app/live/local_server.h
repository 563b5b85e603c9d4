#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace pliant {

/// What a handler may do with a client's WebSocket, from any thread.
class Connection {
 public:
  virtual ~Connection() = default;
  virtual void send_text(std::string text) = 0;
  virtual void send_bytes(std::string bytes) = 0;
  /// Nothing waits to be written: a client that reads slowly is sent fewer frames.
  virtual bool idle() const = 0;
  virtual void close() = 0;
};

/// A client whose WebSocket is open; destroyed when it has gone.
class Client {
 public:
  virtual ~Client() = default;
  /// A text message.  Returns at once.
  virtual void receive(std::string text) = 0;
  /// Whether another one may come; where not, hardly anything is read from this client for a while.
  virtual bool takes_more() const { return true; }
};

struct LocalServerOptions {
  std::string host = "127.0.0.1";     ///< address to listen at
  int port = 0;                       ///< 0 = any that is free
  bool allow_remote = false;          ///< addresses other than loopback, and any Host header
  std::filesystem::path drop_folder;  ///< where files that a page sends are written
  // What clients may cost.
  int most_connections = 32, most_clients = 4;
  size_t most_header = 8 << 10;                ///< bytes
  size_t most_message = 16 << 20;              ///< bytes, with room for all marks of a choice
  size_t most_unread = 64 << 20;               ///< bytes that wait for a client before it is dropped
  double messages_per_second = 240;            ///< after a burst of twice as many; then they wait
  size_t most_dropped = size_t{4} << 30;       ///< bytes of a file that a page sends
  double read_timeout = 5, idle_timeout = 60;  ///< s, of a request; without progress of an answer or WebSocket
};

/// HTTP and WebSocket for one person on one machine (Boost.Beast).  Everything lies below a random token, so that no
/// other page or user can reach it: http://HOST:PORT/TOKEN/.  Requests with another Host, WebSockets with another
/// Origin, methods other than GET and HEAD, and whatever lies outside are refused.  Where files are taken, a POST to
/// TOKEN/drop/NAME is one, one at a time.
class LocalServer {
 public:
  struct Page {
    std::string type, body;
    std::string security_policy;  ///< Content-Security-Policy
  };
  struct Handler {
    /// Below the token, such as ""; null = there is none.
    std::function<std::shared_ptr<const Page>(std::string_view path)> page;
    /// At TOKEN/live.
    std::function<std::unique_ptr<Client>(std::shared_ptr<Connection>)> connect;
    /// A file NAME has been written to `file`, which is the handler's now.  Returns at once why it is not taken, or
    /// nothing.  Null = none are taken.
    std::function<std::string(const std::string& name, const std::filesystem::path& file)> drop = {};
  };

  /// Throws Error{kUsage} where the address is not loopback and not allowed, or cannot be used.
  LocalServer(const LocalServerOptions& options, Handler handler);
  ~LocalServer();

  int port() const;
  bool is_remote() const;   ///< listens at an address that other machines reach
  std::string url() const;  ///< with the token
  /// Serves until `stop` is true, which is asked several times a second.
  void run(const std::function<bool()>& stop);

  struct State;  ///< of its implementation

 private:
  std::unique_ptr<State> state_;
};

}  // namespace pliant
