// What keeps other pages and users away from `pliant view` (research: DNS rebinding, cross-site WebSockets, slow
// reads).

#include "app/live/local_server.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <map>
#include <thread>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

/// A connection as bytes.
class Wire {
 public:
  explicit Wire(int port, const char* host = "127.0.0.1") : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    inet_pton(AF_INET, host, &address.sin_addr);
    EXPECT_EQ(connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  }
  ~Wire() { close(socket_); }
  Wire(Wire&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}

  void send(const std::string& bytes) const {
    for (size_t at = 0; at < bytes.size();) {
      const ssize_t sent = ::send(socket_, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
      if (sent <= 0) return;
      at += static_cast<size_t>(sent);
    }
  }
  /// What comes until `enough`, the end of the connection or a time [s].
  std::string receive(double seconds, const std::function<bool(const std::string&)>& enough) {
    std::string out;
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!enough(out)) {
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
      pollfd waiting{socket_, POLLIN, 0};
      if (left.count() <= 0 || poll(&waiting, 1, static_cast<int>(left.count())) <= 0) break;
      char buffer[4096];
      const ssize_t got = recv(socket_, buffer, sizeof(buffer), 0);
      ended = got <= 0;
      if (ended) break;
      out.append(buffer, static_cast<size_t>(got));
    }
    return out;
  }
  std::string head() {
    return receive(3, [](const std::string& s) { return s.find("\r\n\r\n") != std::string::npos; });
  }
  bool ends(double seconds) {
    receive(seconds, [](const std::string&) { return false; });
    return ended;
  }
  bool ended = false;

 private:
  int socket_;
};

/// Says every message back, and counts its clients.
struct EchoClient : Client {
  EchoClient(std::shared_ptr<Connection> c, std::atomic<int>& n) : connection(std::move(c)), count(n) { ++count; }
  ~EchoClient() override { --count; }
  void receive(std::string text) override { connection->send_text("echo " + text); }
  bool takes_more() const override { return !busy; }
  std::shared_ptr<Connection> connection;
  std::atomic<int>& count;
  static inline std::atomic<bool> busy = false;
};

class LocalServerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    options_.read_timeout = 0.4;
    options_.most_connections = 20;
    options_.most_message = 64 << 10;
    start();
  }
  void TearDown() override { stop(); }
  void start() {
    page_ = std::make_shared<const LocalServer::Page>(LocalServer::Page{"text/html", body_, "default-src 'none'"});
    server_ = std::make_unique<LocalServer>(
        options_,
        LocalServer::Handler{
            [this](std::string_view path) { return path.empty() ? page_ : nullptr; },
            [this](std::shared_ptr<Connection> c) { return std::make_unique<EchoClient>(c, clients_); }, drop_});
    port_ = server_->port();
    url_ = server_->url();
    path_ = url_.substr(url_.find('/', 7));
    thread_ = std::thread([this] { server_->run([this] { return stop_.load(); }); });
  }
  void stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    server_.reset();
    EXPECT_EQ(clients_, 0) << "clients end with the server";
    stop_ = false;
  }

  std::string host() const { return "127.0.0.1:" + std::to_string(port_); }
  std::string request(const std::string& target, const std::string& host, const std::string& more = "",
                      const std::string& method = "GET") const {
    return method + " " + target + " HTTP/1.1\r\nHost: " + host + "\r\n" + more + "\r\n";
  }
  std::string upgrade(const std::string& target, const std::string& more = "", std::string host_name = "") const {
    if (host_name.empty()) host_name = host();
    return request(target, host_name,
                   "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                   "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
                       more);
  }
  /// Status of the answer to these bytes; 0 = none.
  int status(const std::string& bytes) const {
    Wire wire(port_);
    wire.send(bytes);
    const std::string head = wire.head();
    return head.size() > 12 ? std::atoi(head.c_str() + 9) : 0;
  }
  Wire opened() const {
    Wire wire(port_);
    wire.send(upgrade(path_ + "live"));
    EXPECT_EQ(wire.head().substr(9, 3), "101");
    return wire;
  }
  /// A masked frame, as clients have to send them.
  static std::string frame(const std::string& text, bool masked = true) {
    std::string out = "\x81";
    const size_t n = text.size();
    const int mark = masked ? 0x80 : 0;
    if (n < 126) {
      out += static_cast<char>(mark | static_cast<int>(n));
    } else {
      out += static_cast<char>(mark | 127);
      for (int k = 7; k >= 0; --k) out += static_cast<char>(n >> (8 * k) & 255);
    }
    const char key[] = {1, 2, 3, 4};
    if (masked) out.append(key, 4);
    for (size_t i = 0; i < n; ++i) out += static_cast<char>(text[i] ^ (masked ? key[i % 4] : 0));
    return out;
  }

  LocalServerOptions options_;
  std::string body_ = "<p>the page";
  std::function<std::string(const std::string&, const std::filesystem::path&)> drop_;
  std::shared_ptr<const LocalServer::Page> page_;
  std::unique_ptr<LocalServer> server_;
  std::string url_, path_;
  int port_ = 0;
  std::atomic<bool> stop_ = false;
  std::atomic<int> clients_ = 0;
  std::thread thread_;
};

TEST_F(LocalServerTest, ServesThePageBelowItsTokenAlone) {
  Wire wire(port_);
  wire.send(request(path_, host()));
  const std::string head = wire.head();
  EXPECT_NE(head.find("200 OK"), std::string::npos);
  for (const char* field : {"Content-Security-Policy: default-src 'none'", "X-Content-Type-Options: nosniff",
                            "Referrer-Policy: no-referrer", "X-Frame-Options: DENY", "Cache-Control: no-store"})
    EXPECT_NE(head.find(field), std::string::npos) << field;
  EXPECT_EQ(head.find("Access-Control"), std::string::npos);
  EXPECT_EQ(path_.size(), 34u) << "128 bits";
  std::string wrong = path_;
  wrong[5] = wrong[5] == 'a' ? 'b' : 'a';
  EXPECT_EQ(status(request("/", host())), 403);
  EXPECT_EQ(status(request(wrong, host())), 403);
  EXPECT_EQ(status(request(path_.substr(0, path_.size() - 1), host())), 403);
  EXPECT_EQ(status(request("*", host())), 403);
  for (const char* target : {"../", "..%2f..%2fetc/passwd", "/etc/passwd", "live", "?x"})
    EXPECT_EQ(status(request(path_ + target, host())), 404) << target;
  EXPECT_EQ(status(request(path_, host(), "Content-Length: 0\r\n", "POST")), 405);
  EXPECT_EQ(status(request(path_, host(), "", "DELETE")), 405);
  EXPECT_EQ(status(request(path_, host(), "", "HEAD")), 200);
}

TEST_F(LocalServerTest, TakesFilesWhereItIsMeantTo) {
  stop();
  const TemporaryFolder folder;
  options_.drop_folder = folder.path();
  options_.most_dropped = 1000;
  std::map<std::string, std::string> taken;
  drop_ = [&](const std::string& name, const std::filesystem::path& file) {
    taken[name] = read_text(file);
    std::filesystem::remove(file);
    return name == "bad.ply" ? "not this one" : "";
  };
  start();
  const auto post = [&](const std::string& target, const std::string& body, const std::string& more = "") {
    return request(target, host(), more + "Content-Length: " + std::to_string(body.size()) + "\r\n", "POST") + body;
  };
  const std::string drop = path_ + "drop/";
  EXPECT_EQ(status(post(drop + "a-1.ply", "hello", "Origin: http://" + host() + "\r\n")), 200);
  const std::string large(1000, 'x');
  EXPECT_EQ(status(post(drop + "b.ply", large)), 200);
  EXPECT_EQ(taken, (std::map<std::string, std::string>{{"a-1.ply", "hello"}, {"b.ply", large}}));
  EXPECT_EQ(status(post(drop + "bad.ply", "x")), 422);
  EXPECT_EQ(status(post(drop + "c.ply", large + "x")), 413);
  const auto in_chunks = [&](const std::string& name, const std::string& length, const std::string& body) {
    return request(drop + name, host(), "Transfer-Encoding: chunked\r\n", "POST") + length + "\r\n" + body +
           "\r\n0\r\n\r\n";
  };
  EXPECT_EQ(status(in_chunks("chunks.ply", "5", "hello")), 200);
  EXPECT_EQ(taken["chunks.ply"], "hello");
  EXPECT_EQ(status(in_chunks("c.ply", "3e9", large + "x")), 413);
  for (const char* name : {"", ".hidden", "../c.ply", "..%2fc.ply", "a/b.ply", "a%20b.ply", "c.ply?x"})
    EXPECT_EQ(status(post(drop + name, "x")), 400) << name;
  EXPECT_EQ(status(post(drop + std::string(101, 'a'), "x")), 400);
  EXPECT_EQ(status(post(path_, "x")), 404);
  EXPECT_EQ(status(post("/drop/c.ply", "x")), 403);
  EXPECT_EQ(status(post(drop + "c.ply", "x", "Origin: http://evil.com\r\n")), 403);
  EXPECT_EQ(status(request(path_, host(), "Content-Length: 1\r\n") + "x"), 400) << "a page needs no body";
  {
    // One at a time, and nothing is left of one that ends early.
    Wire slow(port_);
    const std::string whole = post(drop + "slow.ply", large);
    slow.send(whole.substr(0, whole.size() - 10));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    EXPECT_EQ(status(post(drop + "c.ply", "x")), 503);
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(status(post(drop + "d.ply", "x")), 200);
  EXPECT_EQ(taken.count("slow.ply") + taken.count("c.ply"), 0u);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST_F(LocalServerTest, RefusesOtherHostsAndOrigins) {
  const std::string port = std::to_string(port_);
  for (const std::string& good : {"127.0.0.1:" + port, "localhost:" + port, "[::1]:" + port})
    EXPECT_EQ(status(request(path_, good)), 200) << good;
  for (const std::string& evil : {"evil.com:" + port, std::string("127.0.0.1"), "127.0.0.1:" + port + ".evil.com",
                                  "127.0.0.1.evil.com:" + port, std::string()})
    EXPECT_EQ(status(request(path_, evil)), 403) << evil;
  const std::string live = path_ + "live";
  EXPECT_EQ(status(upgrade(live)), 101);
  EXPECT_EQ(status(upgrade(live, "Origin: http://localhost:" + port + "\r\n")), 101);
  for (const std::string& evil : {std::string("null"), std::string("http://evil.com"), "https://127.0.0.1:" + port,
                                  "http://127.0.0.1:" + port + ".evil.com", "http://127.0.0.1:" + port + "/"})
    EXPECT_EQ(status(upgrade(live, "Origin: " + evil + "\r\n")), 403) << evil;
  EXPECT_EQ(status(upgrade("/live")), 403);
  EXPECT_EQ(status(upgrade(path_ + "other")), 404);
  EXPECT_EQ(status(upgrade(live, "", "evil.com")), 403);
}

TEST_F(LocalServerTest, MessagesGoBothWays) {
  Wire wire = opened();
  wire.send(frame("one") + frame("two"));
  const std::string back = wire.receive(3, [](const std::string& s) { return s.size() >= 20; });
  EXPECT_EQ(back,
            "\x81\x08"
            "echo one"
            "\x81\x08"
            "echo two");
}

TEST_F(LocalServerTest, EndsConnectionsThatMisbehave) {
  Wire unmasked = opened();
  unmasked.send(frame("x", false));
  EXPECT_TRUE(unmasked.ends(3));
  Wire huge = opened();
  huge.send(frame(std::string(1 << 20, 'x')));
  EXPECT_TRUE(huge.ends(3));
  Wire binary = opened();
  std::string bytes = frame("abc");
  bytes[0] = '\x82';
  binary.send(bytes);
  EXPECT_TRUE(binary.ends(3));
  Wire long_head(port_);
  long_head.send("GET " + path_ + " HTTP/1.1\r\nX: " + std::string(20'000, 'a') + "\r\n\r\n");
  EXPECT_TRUE(long_head.ends(3));
  Wire noise(port_);
  noise.send(std::string(1000, '\xff') + "\r\n\r\n");
  EXPECT_TRUE(noise.ends(3));
  Wire silent(port_), slow(port_);
  slow.send("GET / HT");
  EXPECT_TRUE(silent.ends(3));
  EXPECT_TRUE(slow.ends(3));
}

TEST_F(LocalServerTest, TakesSoManyClientsAndNoMore) {
  std::vector<Wire> open;
  for (int k = 0; k < options_.most_clients; ++k) open.push_back(opened());
  EXPECT_EQ(status(upgrade(path_ + "live")), 503);
  open.pop_back();
  for (int k = 0; k < 50 && clients_ == options_.most_clients; ++k)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(status(upgrade(path_ + "live")), 101);
}

// 24 MB, of which the system buffers some megabytes, at 8 MB/s.
TEST_F(LocalServerTest, APageIsReadAsSlowlyAsItMayButSteadily) {
  stop();
  options_.idle_timeout = 1;
  body_.assign(24 << 20, 'x');
  start();
  Wire steady(port_), stopped(port_);
  for (const Wire* wire : {&steady, &stopped}) wire->send(request(path_, host()));
  size_t read = 0;
  while (!steady.ended && read < body_.size()) {
    const size_t piece = std::min<size_t>(80 << 10, body_.size() - read);
    const size_t got = steady.receive(0.5, [&](const std::string& s) { return s.size() >= piece; }).size();
    if (got == 0) break;
    read += got;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_GE(read, body_.size());
  size_t left = 0;
  stopped.receive(3, [&](const std::string& s) {
    left = s.size();
    return left >= body_.size();
  });
  EXPECT_TRUE(stopped.ended);
  EXPECT_LT(left, body_.size()) << "it was dropped after a second";
}

TEST_F(LocalServerTest, AHundredConnectionsDoNoHarm) {
  std::vector<Wire> open;
  for (int k = 0; k < 100; ++k) open.emplace_back(port_);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  open.clear();
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  EXPECT_EQ(status(request(path_, host())), 200);
}

TEST_F(LocalServerTest, WhoSendsTooFastWaits) {
  stop();
  options_.messages_per_second = 50;
  start();
  Wire wire = opened();
  std::string all;
  for (int k = 0; k < 160; ++k) all += frame("m");
  const auto begin = std::chrono::steady_clock::now();
  wire.send(all);
  const std::string back = wire.receive(10, [](const std::string& s) { return s.size() >= 160 * 8; });
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_EQ(back.size(), 160u * 8);
  EXPECT_GT(seconds, 1) << "a burst of 100 is allowed, the rest takes 1.2 s";
}

// However long its client has no time: nothing is lost, and who answers pings is not taken for dead.
TEST_F(LocalServerTest, WhoHasToWaitIsReadLaterAndNotCutOff) {
  stop();
  options_.idle_timeout = 0.8;
  start();
  Wire wire = opened();
  EchoClient::busy = true;
  std::string all;
  for (int k = 0; k < 100; ++k) all += frame("m");
  wire.send(all);
  const auto echoes = [](const std::string& s) {
    size_t count = 0;
    for (size_t at = s.find("echo m"); at != std::string::npos; at = s.find("echo m", at + 1)) ++count;
    return count;
  };
  std::string back = wire.receive(1.5, [](const std::string&) { return false; });
  EXPECT_FALSE(wire.ended);
  EXPECT_LT(echoes(back), 20u) << "one now and then";
  EchoClient::busy = false;
  back += wire.receive(3, [&](const std::string& s) { return echoes(s) + echoes(back) >= 100; });
  EXPECT_EQ(echoes(back), 100u);
}

TEST_F(LocalServerTest, NoProgramThatIsStartedInheritsASocket) {
  const auto inherited = [] {
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
      std::error_code error;
      const int file = std::stoi(entry.path().filename().string());
      if (std::filesystem::read_symlink(entry.path(), error).string().starts_with("socket:"))
        count += (fcntl(file, F_GETFD) & FD_CLOEXEC) == 0;
    }
    return count;
  };
  const int before = inherited();
  stop();
  EXPECT_EQ(inherited(), before) << "not the one that listens";
  start();
  const Wire wire = opened();
  EXPECT_EQ(inherited(), before + 1) << "that of the test";
}

TEST(LocalServer, OtherMachinesAreLetInOnRequestOnly) {
  const LocalServer::Handler none{[](std::string_view) { return nullptr; },
                                  [](std::shared_ptr<Connection>) { return std::unique_ptr<Client>(); }};
  LocalServerOptions options;
  for (const char* host : {"0.0.0.0", "::", "10.0.0.1", "not an address"}) {
    options.host = host;
    EXPECT_THROW(LocalServer(options, none), Error) << host;
  }
  options.host = "0.0.0.0";
  options.allow_remote = true;
  EXPECT_TRUE(LocalServer(options, none).is_remote());
  options.host = "127.0.0.1";
  EXPECT_FALSE(LocalServer(options, none).is_remote()) << "whoever is allowed";
}

TEST(LocalServer, TheOptionThatCannotBeUsedIsTheOneThatIsNamed) {
  LocalServerOptions options;
  options.allow_remote = true;
  const LocalServer first(options, {});
  options.port = first.port();
  expect_error(Failure::kUsage, {"--port", std::to_string(first.port())}, [&] { LocalServer(options, {}); });
  options.host = "192.0.2.1";  // of documentation alone (RFC 5737)
  expect_error(Failure::kUsage, {"--host", "192.0.2.1"}, [&] { LocalServer(options, {}); });
}

TEST_F(LocalServerTest, ListeningEverywhereItTellsTheNameOfTheMachine) {
  stop();
  options_.host = "0.0.0.0";
  options_.allow_remote = true;
  start();
  char name[256] = {};
  ASSERT_EQ(gethostname(name, sizeof(name) - 1), 0);
  const std::string told = std::string(name) + ":" + std::to_string(port_);
  EXPECT_EQ(url_.find("http://" + told + "/"), 0u) << url_;
  EXPECT_EQ(status(request(path_, told)), 200);
  EXPECT_EQ(status(upgrade(path_ + "live", "Origin: http://" + told + "\r\n", told)), 101);
}

TEST_F(LocalServerTest, TheAddressThatItTellsIsItsOwn) {
  stop();
  options_.host = "127.0.0.2";
  start();
  EXPECT_EQ(url_.find("http://127.0.0.2:"), 0u) << url_;
  const std::string answer = [&] {
    Wire wire(port_, "127.0.0.2");
    wire.send(request(path_, "127.0.0.2:" + std::to_string(port_)));
    return wire.head();
  }();
  EXPECT_EQ(answer.find("HTTP/1.1 200"), 0u) << answer;
}

TEST_F(LocalServerTest, NothingIsLeftOfAFileThatItsEndCutsOff) {
  stop();
  const TemporaryFolder folder;
  options_.drop_folder = folder.path();
  drop_ = [](const std::string&, const std::filesystem::path&) { return ""; };
  start();
  Wire wire(port_);
  wire.send(request(path_ + "drop/a.ply", host(), "Content-Length: 1000\r\n", "POST") + "begin");
  for (int k = 0; k < 500 && std::filesystem::is_empty(folder.path()); ++k)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_FALSE(std::filesystem::is_empty(folder.path()));
  stop();
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace pliant
