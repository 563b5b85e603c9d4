#pragma once

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>

#include "fitting/predict/llm_client.h"

namespace pliant {

/// Listens on a free port of this machine and gives every connection to `talk`, one after the other.
class MockServer {
 public:
  explicit MockServer(std::function<void(int connection, const std::string& request)> talk) : talk_(std::move(talk)) {
    ::setenv("no_proxy", "127.0.0.1", 1);
    socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (::bind(socket_, reinterpret_cast<sockaddr*>(&address), size) != 0 || ::listen(socket_, 4) != 0 ||
        ::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
      throw std::runtime_error("no port");
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~MockServer() {
    ::shutdown(socket_, SHUT_RDWR);
    thread_.join();
    ::close(socket_);
  }
  MockServer(const MockServer&) = delete;

  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_) + "/v1"; }
  std::atomic<int> requests = 0;

 private:
  void serve() {
    for (int connection; (connection = ::accept(socket_, nullptr, nullptr)) >= 0; ::close(connection)) {
      ++requests;
      talk_(connection, read_request(connection));
    }
  }
  static std::string read_request(int connection) {
    std::string bytes;
    char buffer[65536];
    for (;;) {
      const size_t head = bytes.find("\r\n\r\n");
      if (head != std::string::npos) {
        const size_t at = bytes.find("Content-Length: ");
        if (bytes.size() >= head + 4 + std::stoul(bytes.substr(at + 16))) return bytes;
      }
      const ssize_t n = ::read(connection, buffer, sizeof buffer);
      if (n <= 0) return bytes;
      bytes.append(buffer, static_cast<size_t>(n));
    }
  }

  std::function<void(int, const std::string&)> talk_;
  int socket_ = -1, port_ = 0;
  std::thread thread_;
};

inline void send_all(int connection, const std::string& bytes) {
  for (size_t sent = 0; sent < bytes.size();) {
    const ssize_t n = ::send(connection, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (n <= 0) return;
    sent += static_cast<size_t>(n);
  }
}
inline void reply(int connection, const std::string& body, const std::string& status = "200 OK") {
  send_all(connection, "HTTP/1.1 " + status + "\r\nContent-Length: " + std::to_string(body.size()) +
                           "\r\nConnection: close\r\n\r\n" + body);
}
inline std::string envelope(const std::string& content) {
  return nlohmann::json({{"choices", {{{"message", {{"content", content}}}}}}}).dump();
}

/// An answer about a rose.
inline const char kGood[] =
    R"({"E": {"low": 1e6, "typical": 3e6, "high": 1e7}, "nu": {"low": 0.3, "typical": 0.4, "high": 0.45},
        "rho": {"low": 700, "typical": 800, "high": 900}, "what": "a rose"})";

inline LlmOptions options_for(const std::string& url) {
  LlmOptions options;
  options.url = url;
  options.model = "mock";
  options.timeout = 5;
  return options;
}

}  // namespace pliant
