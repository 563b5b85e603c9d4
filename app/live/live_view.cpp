#include "app/live/live_view.h"

#include <fmt/format.h>
#include <malloc.h>
#include <spawn.h>
#include <sys/wait.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/live/live_client.h"
#include "app/page/page_stage.h"
#include "app/report/html.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

extern char** environ;

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr size_t kPageSize = 32'000'000;  // bytes, if that is enough

/// Starts the default browser, where there is a desktop; false where that fails within a second.  Without a known
/// desktop the program that starts it lives as long as the browser, which has a session of its own: what ends this
/// program does not end it.
bool open_browser(const std::string& url) {
  if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY")) return false;
  std::string program = "xdg-open", argument = url;
  char* const arguments[] = {program.data(), argument.data(), nullptr};
  pid_t process = 0;
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  const int failed = posix_spawnp(&process, program.c_str(), nullptr, &attributes, arguments, environ);
  posix_spawnattr_destroy(&attributes);
  if (failed) return false;
  constexpr int kAsks = 20;
  for (int k = 0; k < kAsks; ++k) {
    int status = 0;
    if (waitpid(process, &status, WNOHANG) != 0) return WIFEXITED(status) && WEXITSTATUS(status) == 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return true;
}

}  // namespace

LocalServer::Page live_page(std::string html) {
  const std::string policy = "default-src 'none'; ",
                    mark = "http-equiv=\"Content-Security-Policy\" content=\"" + policy;
  const std::string connects = "connect-src 'self'; ";
  fill_mark(html, mark, mark + connects);
  fill_mark(html, "<title>", "<meta name=\"pliant-live\" content=\"live\">\n<title>");
  const size_t begin = html.find(mark) + mark.size() - policy.size(), end = html.find('"', begin);
  return {"text/html; charset=utf-8", html, html.substr(begin, end - begin) + "; frame-ancestors 'none'"};
}

LiveScreen live_screen(const Context& context, const RunDirectory& run, const Scene& scene, Progress& console) {
  const auto live = std::make_shared<const LiveScene>(load_live_scene(run, scene, "view"));
  // A page of its own, as clip.html may be smaller than this machine needs, in a file of this process that goes again.
  const fs::path file = temporary_name(run / "view.html");
  const std::shared_ptr<const void> removed(nullptr, [&](const void*) {
    std::error_code none;
    fs::remove(file, none);
  });
  PageStage stage;
  stage.size = kPageSize;
  stage.grows = true;
  export_page(context, run, scene, stage, file);
  LiveScreen screen{live_page(read_text(file)), {}};
  const auto warn = [&console, said = std::make_shared<std::atomic<bool>>(false)](const std::string& text) {
    if (!said->exchange(true)) console.warn("view: " + text);
  };
  screen.connect = [live, recordings = run / "recordings", warn](std::shared_ptr<Connection> connection) {
    return std::make_unique<LiveClient>(live, recordings, std::move(connection), warn);
  };
  return screen;
}

json serve(const Context& context, const ViewOptions& options, LocalServer& server, LiveSite& site) {
  mallopt(M_MMAP_THRESHOLD, 128 << 10);  // a fixed one: what bodies of many sessions took goes back to the system
  const std::string url = server.url();
  if (options.server.allow_remote && !server.is_remote())
    context.progress.warn("view: --allow-remote lets no other machine in while the address is " + options.server.host +
                          "; add --host 0.0.0.0");
  else if (server.is_remote())
    context.progress.warn("view: anyone with the address below can move the object; the connection is not encrypted");
  const bool opened = options.browser && open_browser(url);
  context.progress.say(fmt::format("view: {} {} (Ctrl-C to stop)", opened ? "opened" : "open", url));
  server.run([&] { return context.interrupted(); });
  site.end();
  return {{"url", url}};
}

OptionTable options_of(ViewOptions& options) {
  return {"view",
          {{.name = "port",
            .field = &options.server.port,
            .help = "Port to listen on; 0 = any free port",
            .value = "N",
            .low = 0,
            .high = 65535},
           {.name = "host", .field = &options.server.host, .help = "Address to listen on", .value = "IP"},
           {.name = "allow-remote",
            .field = &options.server.allow_remote,
            .help = "Allow other machines to connect (with --host); not encrypted"},
           {.name = "choose",
            .field = &options.choose,
            .help = "Start with choosing an object, even if one has already been simulated"},
           {.name = "no-browser",
            .field = &options.browser,
            .help = "Do not open the page in the default browser",
            .off = true}}};
}

}  // namespace pliant
