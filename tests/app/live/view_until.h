#pragma once

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "app/commands/command.h"
#include "app/run/progress.h"

namespace pliant::fixture {

/// `view` with these arguments until it serves and `enough`, or for 20 s; what it warned of goes to `warned`.
inline void view_until(std::vector<std::string> arguments, const std::function<bool()>& enough,
                       std::string* warned = nullptr) {
  CLI::App app;
  Program program;
  add_view(app, program);
  arguments.insert(arguments.begin(), {"view", "--no-browser"});
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
  std::atomic<bool> serves = false;
  Progress progress(true);
  progress.listen([&](const ProgressEvent& event) {
    if (event.warning && warned) *warned += event.text + "\n";
    if (event.text.starts_with("view: open")) serves = true;
  });
  const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  Context context{progress, [&] { return (serves && enough()) || std::chrono::steady_clock::now() > latest; }};
  program.action(context);
  EXPECT_TRUE(serves);
}

}  // namespace pliant::fixture
