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

/// What a person presses in the page: `press(key, repeat)`, and `until(condition)`.
inline const std::string kPress = R"(
    const press = (key, repeat = false) => document.body.dispatchEvent(new KeyboardEvent('keydown', {key, repeat,
      bubbles: true, cancelable: true}));
    const until = async (done) => {
      for (let k = 0; k < 400 && !done(); ++k) await new Promise((next) => setTimeout(next, 50));
    };
    const hold = () => until(() => pliant.live() || (press('g'), pliant.live()));
    const frame = () => Number(document.getElementById('scrub').value);
    await pliant.ready;
    await pliant.solver.ready;
    pliant.setLevel(pliant.solver.levels.length - 1);
    press('Home');
)";

/// And with fingers: `touch(type, id, x, y)`, and `find()`, which lays the first on the object and gives its place.
inline const std::string kTouch = R"(
    const canvas = document.getElementById('canvas'), {left, top, width, height} = canvas.getBoundingClientRect();
    canvas.setPointerCapture = () => {};
    const touch = (type, id, x, y) => canvas.dispatchEvent(new PointerEvent(type, {pointerId: id, pointerType: 'touch',
      isPrimary: id === 1, button: 0, clientX: x, clientY: y, bubbles: true}));
    const find = async () => {
      let place = null;
      await until(() => {
        for (let k = 0; k < 400 && !pliant.live(); ++k) {
          place = [left + (k % 20 + 0.5) * width / 20, top + (Math.floor(k / 20) + 0.5) * height / 20];
          touch('pointerdown', 1, ...place);
          if (!pliant.live()) touch('pointerup', 1, ...place);
        }
        return pliant.live();
      });
      return place;
    };
)";

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

  /// The top pulled sideways by .3 of the height in 20 of 30 frames and let go for another 20, in the page and
  /// natively.
  struct Drag {
    nlohmann::json recording;
    std::string said;                          ///< in the line of the page's status
    double newtons = 0;                        ///< largest mean force of a frame
    double worst = 0, farthest = 0, left = 0;  ///< scene units: largest difference and motion; motion at the end
  };
  /// `before`: JavaScript that runs when the page is ready.
  Drag drag(const std::filesystem::path& file, const std::filesystem::path& run, const std::string& before = "") const {
    Drag out;
    const nlohmann::json answer = evaluate("(async () => {" + names_of_top(0.3f) + R"(
      await pliant.ready;
      await pliant.solver.ready;
    )" + before + R"(
      const frames = [];
      await pliant.advance(0);
      const keep = () => frames.push(Array.from(pliant.drivers()));
      keep();
      const grab = pliant.grab(place, radius);
      const said = document.getElementById('status').textContent;
      let newtons = 0;
      for (let k = 1; k <= 50; ++k) {
        if (k <= 30) pliant.drag(grab, hand.map((x) => x * Math.min(1, k / 20)));
        if (k === 31) pliant.release(grab);
        const {forces} = await pliant.advance(1);
        newtons = Math.max(newtons, ...Object.values(forces).map((f) => Math.hypot(...f)));
        keep();
      }
      return {frames, newtons, said, recording: pliant.recording(), violations: pliant.violations,
        errors: pliant.errors};
    })())",
                                           file);
    EXPECT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
    if (!answer.contains("value")) return out;
    const nlohmann::json& value = answer["value"];
    EXPECT_EQ(value["violations"], nlohmann::json::array());
    EXPECT_EQ(value["errors"], nlohmann::json::array());
    out.recording = value["recording"];
    out.said = value["said"];
    out.newtons = value["newtons"];
    const std::string recording = (folder / "recording.json").string();
    write_text(recording, out.recording.dump());
    EXPECT_EQ(run_quietly({"simulate", run.string(), "--recording", recording}), 0);
    const TrajectoryFile native = read_trajectory(run / object_folder(*run_) / "recording.h5");
    EXPECT_EQ(native.frames.size(), value["frames"].size());
    for (size_t f = 0; f < native.frames.size(); ++f) {
      const std::vector<float> page = value["frames"][f];
      const std::vector<Vec3f>& expected = native.frames[f].position;
      EXPECT_EQ(page.size(), 3 * expected.size());
      out.left = 0;
      for (size_t i = 0; i < expected.size(); ++i) {
        const Vec3f x(page[3 * i], page[3 * i + 1], page[3 * i + 2]);
        out.worst = std::max<double>(out.worst, (x - expected[i]).norm());
        out.left = std::max<double>(out.left, (x - native.frames[0].position[i]).norm());
      }
      out.farthest = std::max(out.farthest, out.left);
    }
    std::printf("[ drag ] largest motion %.3g of the height, %.3g at the end, largest difference %.2g, force %.3g N\n",
                out.farthest / height(), out.left / height(), out.worst / height(), out.newtons);
    return out;
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
