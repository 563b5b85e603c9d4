// Internal to local_server.cpp: a file that a page sends.
#pragma once

#include <filesystem>

#include "app/live/local_server_socket.h"

namespace pliant::serving {

/// Reads the body of a request whose header has been read into a file.  Nothing is left of one that ends early.
class Upload : public std::enable_shared_from_this<Upload> {
 public:
  /// `done` is told how it went, ok or a refusal; stream and buffer must live until then.
  Upload(State& state, beast::tcp_stream& stream, beast::flat_buffer& buffer,
         http::request_parser<http::empty_body>&& header, std::filesystem::path file,
         std::function<void(http::status)> done)
      : state_(state),
        stream_(stream),
        buffer_(buffer),
        parser_(std::move(header)),
        file_(std::move(file)),
        done_(std::move(done)) {
    state_.uploading = true;
  }
  ~Upload() {
    if (opened_) close(false);
    state_.uploading = false;
  }

  void start() {
    beast::error_code error;
    const size_t most = state_.options.most_dropped;
    parser_.body_limit(most);  // which is asked for bodies in chunks alone
    if (const auto length = parser_.content_length(); length && *length > most)
      return done_(http::status::payload_too_large);
    parser_.get().body().open(file_.c_str(), beast::file_mode::write, error);
    opened_ = !error;
    if (error) return finish(http::status::insufficient_storage);
    read();
  }

 private:
  void read() {
    if (parser_.is_done()) return finish(http::status::ok);
    stream_.expires_after(milliseconds(state_.options.idle_timeout));
    http::async_read_some(stream_, buffer_, parser_, [self = shared_from_this()](beast::error_code error, size_t) {
      if (!error) return self->read();
      if (error == http::error::body_limit) return self->finish(http::status::payload_too_large);
      // A disk that is full, or a page that has gone and hears nothing any more.
      self->finish(http::status::insufficient_storage);
    });
  }

  void close(bool keep) {
    parser_.get().body().close();
    std::error_code none;
    if (!keep) std::filesystem::remove(file_, none);
    opened_ = false;
  }

  void finish(http::status status) {
    close(status == http::status::ok);
    state_.uploading = false;
    done_(status);
  }

  State& state_;
  beast::tcp_stream& stream_;
  beast::flat_buffer& buffer_;
  http::request_parser<http::file_body> parser_;
  const std::filesystem::path file_;
  bool opened_ = false;
  const std::function<void(http::status)> done_;
};

}  // namespace pliant::serving
