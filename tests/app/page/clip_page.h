#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

#include "app/live/live_client.h"
#include "app/live/live_view.h"
#include "app/simulate/moving_scene.h"
#include "tests/app/fit_video_scene.h"
#include "tests/app/page/browser.h"

namespace pliant {

/// clip.html of a run of a small scene.
class ClipPage : public FitVideo {
 protected:
  static void SetUpTestSuite() {
    FitVideo::SetUpTestSuite();
    ASSERT_EQ(run_quietly({"simulate", (folder / "run").string(), "--young", "2e4", "--poisson", "0.3", "--density",
                           "400", "--duration", "0.7"}),
              0);
    ASSERT_EQ(run_quietly({"export", (folder / "run").string(), "--html", page().string()}), 0);
  }
  static std::filesystem::path page() { return folder / "clip.html"; }

  void SetUp() override {
    if (const std::string missing = browser_missing(); !missing.empty()) GTEST_SKIP() << missing;
    run_ = std::make_unique<RunDirectory>(RunDirectory::open(folder / "run"));
    scene_ = load_run_scene(*run_);
    moving_ = load_moving_scene(moving_scene_files(*run_), scene_);
  }

  /// What the expression gives in the page.
  nlohmann::json evaluate(const std::string& expression, const std::filesystem::path& file = page()) const {
    return evaluate_in_page(expression, file.string(), folder);
  }
  /// The same in the page of `pliant view`, which this program leaves where the page fetches "leave".
  nlohmann::json evaluate_served(const std::string& expression, const LiveScene& live,
                                 const std::filesystem::path& recordings) const {
    const LocalServer::Page served = live_page(read_text(page()));
    std::weak_ptr<Connection> last;
    std::atomic<bool> stop = false;
    LocalServer server({}, {[&](std::string_view path) {
                              const std::shared_ptr<Connection> connection = last.lock();
                              if (connection && path == "leave") connection->close();
                              return path.empty() ? &served : nullptr;
                            },
                            [&](std::shared_ptr<Connection> connection) {
                              last = connection;
                              return std::make_unique<LiveClient>(live, recordings, std::move(connection));
                            }});
    std::thread thread([&] { server.run([&] { return stop.load(); }); });
    nlohmann::json answer = evaluate_in_page(expression, server.url(), folder);
    stop = true;
    thread.join();
    return answer;
  }

  std::unique_ptr<RunDirectory> run_;
  Scene scene_;
  MovingScene moving_;
};

}  // namespace pliant
