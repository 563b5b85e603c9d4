#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "app/live/live_client.h"
#include "app/live/live_view.h"
#include "app/simulate/moving_scene.h"
#include "tests/app/moving_run.h"
#include "tests/app/page/browser.h"

namespace pliant {

/// clip.html of a run of a small scene.
class ClipPageTest : public MovingRun {
 protected:
  void SetUp() override {
    if (const std::string missing = browser_missing(); !missing.empty()) GTEST_SKIP() << missing;
    run_ = std::make_unique<RunDirectory>(RunDirectory::open(folder / "run"));
    scene_ = load_run_scene(*run_);
    moving_ = load_moving_scene(moving_scene_files(*run_), scene_);
  }

  /// Of the object [scene units].
  float height() const {
    const auto [low, high] = lowest_and_highest();
    return (high - low).dot(scene_.up.cast<float>());
  }
  /// JavaScript that names its highest `place`, a `radius` around that, and where a `hand` moves it, sideways by a
  /// share of the height.
  std::string names_of_top(float share) const {
    const Vec3f place = lowest_and_highest().second, hand = share * height() * scene_.up.cast<float>().unitOrthogonal();
    const auto numbers = [](const Vec3f& x) { return nlohmann::json({x.x(), x.y(), x.z()}).dump(); };
    return "const place = " + numbers(place) + ", hand = " + numbers(hand) +
           ", radius = " + std::to_string(0.16 * height()) + ";";
  }
  std::pair<Vec3f, Vec3f> lowest_and_highest() const {
    const std::vector<Vec3f>& rest = moving_.particles.driving_position;
    const Vec3f up = scene_.up.cast<float>();
    const auto by_height = [&](const Vec3f& a, const Vec3f& b) { return a.dot(up) < b.dot(up); };
    const auto [low, high] = std::minmax_element(rest.begin(), rest.end(), by_height);
    return {*low, *high};
  }

  /// What the expression gives in the page.
  nlohmann::json evaluate(const std::string& expression, const std::filesystem::path& file = page()) const {
    return evaluate_in_page(expression, file.string(), folder);
  }
  /// The same in the page of `pliant view`, which this program leaves where the page fetches "leave".
  nlohmann::json evaluate_served(const std::string& expression, const std::shared_ptr<const LiveScene>& live,
                                 const std::filesystem::path& recordings) const {
    const auto served = std::make_shared<const LocalServer::Page>(live_page(read_text(page())));
    std::weak_ptr<Connection> last;
    std::atomic<bool> stop = false;
    LocalServer server({}, {[&](std::string_view path) {
                              const std::shared_ptr<Connection> connection = last.lock();
                              if (connection && path == "leave") connection->close();
                              return path.empty() ? served : nullptr;
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
