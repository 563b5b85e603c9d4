#pragma once

#include <atomic>
#include <thread>

#include "app/live/live_site.h"
#include "tests/app/page/browser.h"

namespace pliant {

/// What the expression gives in the page that a site shows, served for as long; see evaluate_in_page.
inline nlohmann::json evaluate_in_site(const std::string& expression, LiveSite& site,
                                       const std::filesystem::path& folder, const LocalServerOptions& options = {}) {
  std::atomic<bool> stop = false;
  LocalServer server(options, site.handler());
  std::thread thread([&] { server.run([&] { return stop.load(); }); });
  const nlohmann::json answer = evaluate_in_page(expression, server.url(), folder);
  stop = true;
  thread.join();
  return answer;
}

}  // namespace pliant
