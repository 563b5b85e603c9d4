#include "app/live/live_view.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

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

constexpr size_t kPageSize = 32'000'000;  // bytes

/// Starts the default browser, where there is a desktop; true when it was started.
bool open_browser(const std::string& url) {
  if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY")) return false;
  std::string program = "xdg-open", argument = url;
  char* const arguments[] = {program.data(), argument.data(), nullptr};
  pid_t process = 0;
  if (posix_spawnp(&process, program.c_str(), nullptr, nullptr, arguments, environ) != 0) return false;
  int status = 0;
  return waitpid(process, &status, 0) == process && WIFEXITED(status) && WEXITSTATUS(status) == 0;
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

LiveScreen live_screen(const Context& context, const RunDirectory& run, const Scene& scene) {
  const auto live = std::make_shared<const LiveScene>(load_live_scene(run, scene, "view"));
  // A page of its own, as clip.html may be smaller than this machine needs.
  const fs::path file = run / "view.html";
  PageStage stage;
  stage.size = kPageSize;
  export_page(context, run, scene, stage, file);
  LiveScreen screen{live_page(read_text(file)), {}};
  fs::remove(file);
  screen.connect = [live, recordings = run / "recordings"](std::shared_ptr<Connection> connection) {
    return std::make_unique<LiveClient>(*live, recordings, std::move(connection));
  };
  return screen;
}

json serve(const Context& context, const ViewOptions& options, LiveSite& site) {
  LocalServer server(options.server, site.handler());
  const std::string url = server.url();
  if (options.server.allow_remote)
    context.progress.warn("view: whoever has the address below can move the object, and nothing is encrypted");
  const bool opened = options.browser && open_browser(url);
  context.progress.say(fmt::format("view: {} {}; Ctrl-C ends", opened ? "opened" : "open", url));
  server.run([&] { return context.interrupted(); });
  return {{"url", url}};
}

OptionTable options_of(ViewOptions& options) {
  return {"view",
          {{.name = "port",
            .field = &options.server.port,
            .help = "Port to listen at; 0 = any that is free",
            .value = "N",
            .low = 0,
            .high = 65535},
           {.name = "host", .field = &options.server.host, .help = "Address to listen at", .value = "IP"},
           {.name = "allow-remote",
            .field = &options.server.allow_remote,
            .help = "Let other machines in, with --host; nothing is encrypted"},
           {.name = "choose",
            .field = &options.choose,
            .help = "Begin with the choice of an object, although one has been made to move"},
           {.name = "no-browser",
            .field = &options.browser,
            .help = "Do not open the page in the default browser",
            .off = true}}};
}

}  // namespace pliant
