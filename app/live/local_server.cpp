#include "app/live/local_server.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>

#include "app/live/local_server_socket.h"
#include "app/live/local_server_upload.h"
#include "gaussians/base/error.h"

namespace pliant {

using namespace serving;

namespace {

constexpr char kLive[] = "live", kDrop[] = "drop/";
constexpr int kUnnamedPort = 80;                       // which browsers leave out
constexpr auto kAsk = std::chrono::milliseconds(200);  // how often `stop` is asked

/// Whether two texts are equal, in a time that does not tell where they differ.
bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (size_t k = 0; k < a.size(); ++k) difference |= static_cast<unsigned char>(a[k] ^ b[k]);
  return difference == 0;
}

/// Letters, digits, dot, minus and underscore; no dot in front.
bool is_file_name(std::string_view name) {
  constexpr size_t kLongest = 100;
  return !name.empty() && name.size() <= kLongest && name[0] != '.' &&
         std::all_of(name.begin(), name.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' || c == '-' ||
                  c == '_';
         });
}

/// A connection that asks for pages, or becomes a WebSocket.
class Visit : public std::enable_shared_from_this<Visit> {
 public:
  Visit(State& state, tcp::socket socket) : state_(state), counted_(state.connections), stream_(std::move(socket)) {}

  void read() {
    parser_.emplace();
    parser_->header_limit(static_cast<uint32_t>(state_.options.most_header));
    parser_->body_limit(std::numeric_limits<uint64_t>::max());  // a file has a limit of its own, others are not read
    stream_.expires_after(milliseconds(state_.options.read_timeout));
    http::async_read_header(stream_, buffer_, *parser_, [self = shared_from_this()](beast::error_code error, size_t) {
      if (!error) return self->answer();
      if (error == http::error::header_limit) self->refuse(http::status::request_header_fields_too_large);
    });
  }

  void refuse(http::status status) { reply(status, std::string(text_of(http::obsolete_reason(status)))); }

 private:
  void reply(http::status status, const std::string& text) {
    auto response = std::make_shared<http::response<http::string_body>>(status, 11);
    response->set(http::field::content_type, "text/plain; charset=utf-8");
    response->body() = text + "\n";
    response->keep_alive(false);
    write(response);
  }

  void answer() {
    const auto& request = parser_->get();
    if (!state_.knows_host(text_of(request[http::field::host]))) return refuse(http::status::forbidden);
    const bool get = request.method() == http::verb::get, post = request.method() == http::verb::post;
    if (!get && request.method() != http::verb::head && !(post && state_.handler.drop))
      return refuse(http::status::method_not_allowed);
    // /TOKEN/path, and nothing else: no file of the machine is ever looked up.
    const std::string_view target = text_of(request.target());
    const size_t slash = target.find('/', 1);
    if (target.empty() || target[0] != '/' || slash == std::string_view::npos ||
        !same_secret(target.substr(1, slash - 1), state_.token))
      return refuse(http::status::forbidden);
    const std::string_view path = target.substr(slash + 1);
    if (post) return take(path);
    if (!parser_->is_done()) return refuse(http::status::bad_request);
    if (websocket::is_upgrade(request)) return upgrade(path);
    const std::shared_ptr<const LocalServer::Page> page = state_.handler.page(path);
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

  bool of_known_origin() const {
    const auto& request = parser_->get();
    const auto origin = request.find(http::field::origin);  // programs send none
    return origin == request.end() || state_.knows_origin(text_of(origin->value()));
  }

  /// A file, whose name is that of the path; no other one of the machine is written.
  void take(std::string_view path) {
    const std::string name(path.substr(std::min(path.size(), std::strlen(kDrop))));
    if (path.substr(0, std::strlen(kDrop)) != kDrop) return refuse(http::status::not_found);
    if (!of_known_origin()) return refuse(http::status::forbidden);
    if (!is_file_name(name)) return refuse(http::status::bad_request);
    if (state_.uploading) return refuse(http::status::service_unavailable);
    const std::filesystem::path file = state_.options.drop_folder / (".dropped-" + random_token());
    std::make_shared<Upload>(state_, stream_, buffer_, std::move(*parser_), file,
                             [self = shared_from_this(), name, file](http::status status) {
                               if (status != http::status::ok) return self->refuse(status);
                               const std::string refusal = self->state_.handler.drop(name, file);
                               self->reply(refusal.empty() ? status : http::status::unprocessable_entity, refusal);
                             })
        ->start();
  }

  void upgrade(std::string_view path) {
    const auto& request = parser_->get();
    if (path != kLive) return refuse(http::status::not_found);
    if (!of_known_origin()) return refuse(http::status::forbidden);
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
    write_some(response, std::make_shared<http::response_serializer<http::string_body>>(*response));
  }

  /// Piece by piece, each with its own time: who reads slowly but steadily gets the whole.
  void write_some(const std::shared_ptr<http::response<http::string_body>>& response,
                  const std::shared_ptr<http::response_serializer<http::string_body>>& serializer) {
    stream_.expires_after(milliseconds(state_.options.idle_timeout));
    http::async_write_some(stream_, *serializer,
                           [self = shared_from_this(), response, serializer](beast::error_code error, size_t) {
                             if (error) return;
                             if (!serializer->is_done()) return self->write_some(response, serializer);
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
      close_on_exec(socket);
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
  if (error) throw usage_error("--host", options.host, "is not an IP address", "give one such as 127.0.0.1");
  if (!address.is_loopback() && !options.allow_remote)
    throw usage_error("--host", options.host, "is reachable from other machines", "add --allow-remote to allow this");
  const tcp::endpoint endpoint(address, static_cast<uint16_t>(options.port));
  s.acceptor.open(endpoint.protocol(), error);
  if (!error) close_on_exec(s.acceptor);
  if (!error) s.acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) s.acceptor.bind(endpoint, error);
  if (!error) s.acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error == boost::system::errc::address_not_available || error == boost::system::errc::address_family_not_supported)
    throw usage_error("--host", options.host, "is not an address of this machine",
                      "give one that is, or 0.0.0.0 for all");
  if (error)
    throw usage_error("--port", std::to_string(options.port), "cannot be used: " + error.message(),
                      "give another one, or 0 for any");
  for (const std::string& name : {std::string("127.0.0.1"), std::string("localhost"), std::string("[::1]"), s.host()}) {
    s.hosts.insert(fmt::format("{}:{}", name, port()));
    if (port() == kUnnamedPort) s.hosts.insert(name);
  }
  s.accept();
}

LocalServer::~LocalServer() {
  for (Socket* const socket : std::set<Socket*>(state_->sockets)) socket->drop();
}

int LocalServer::port() const { return state_->acceptor.local_endpoint().port(); }

bool LocalServer::is_remote() const { return !state_->acceptor.local_endpoint().address().is_loopback(); }

std::string LocalServer::url() const { return fmt::format("http://{}:{}/{}/", state_->host(), port(), state_->token); }

void LocalServer::run(const std::function<bool()>& stop) {
  while (!stop()) state_->context.run_for(kAsk);
}

}  // namespace pliant
