// A client of `pliant view` and what stays of what it did.

#include "app/live/live_view.h"

#include <gtest/gtest.h>

#include <cstring>

#include "app/live/live_client.h"
#include "app/page/clip_html.h"
#include "app/store/trajectory.h"
#include "gaussians/io/files/files.h"
#include "tests/app/fit_video_scene.h"
#include "tests/app/live/inbox.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

json meta_of(const std::string& bytes) {
  if (bytes.substr(0, 4) != "PLNT") return json();
  uint32_t length;
  std::memcpy(&length, bytes.data() + 24, 4);
  return json::parse(bytes.substr(32, length));
}

class View : public FitVideo {
 protected:
  static void SetUpTestSuite() {
    FitVideo::SetUpTestSuite();
    ASSERT_EQ(run_quietly({"simulate", (folder / "run").string(), "--young", "2e4", "--poisson", "0.3", "--density",
                           "400", "--duration", "0.5"}),
              0);
  }
  void SetUp() override {
    run_ = std::make_unique<RunDirectory>(RunDirectory::open(folder / "run"));
    live_ = std::make_shared<const LiveScene>(load_live_scene(*run_, load_run_scene(*run_), "view"));
    fs::remove_all(recordings());
  }
  static fs::path recordings() { return folder / "run/recordings"; }

  std::unique_ptr<RunDirectory> run_;
  std::shared_ptr<const LiveScene> live_;
  std::shared_ptr<Inbox> inbox_ = std::make_shared<Inbox>();
};

TEST_F(View, AnswersInOrderAndGoesOnAfterWhatItRefuses) {
  LiveClient client(live_, recordings(), inbox_);
  client.receive(R"({"id": 1, "describe": true})");
  client.receive(R"({"id": 2, "frames": 2})");
  client.receive("nonsense");
  client.receive(R"({"id": 3, "start": {"frame": 100000}})");
  client.receive(R"({"id": 4, "start": {"drivers": 7}})");
  client.receive(R"({"id": 5, "frames": 1})");
  EXPECT_EQ(json::parse(inbox_->next())["drivers"], live_->drivers());
  EXPECT_EQ(meta_of(inbox_->next())["id"], 2);
  EXPECT_TRUE(json::parse(inbox_->next()).contains("error"));
  for (const int id : {3, 4}) {
    const json refused = json::parse(inbox_->next());
    EXPECT_EQ(refused["id"], id);
    EXPECT_TRUE(refused.contains("error"));
  }
  EXPECT_EQ(meta_of(inbox_->next())["id"], 5);
  EXPECT_FALSE(fs::exists(recordings())) << "nothing was done";
}

TEST_F(View, RunsByItselfUntilItIsTold) {
  LiveClient client(live_, recordings(), inbox_);
  client.receive(R"({"run": true})");
  for (int k = 0; k < 5; ++k) EXPECT_TRUE(meta_of(inbox_->next()).is_object());
  client.receive(R"({"id": 9, "run": false})");
  for (int k = 0; k < 1000; ++k)
    if (const std::string message = inbox_->next(); message.substr(0, 4) != "PLNT") {
      EXPECT_EQ(json::parse(message)["id"], 9);
      return;
    }
  FAIL() << "it did not stop";
}

TEST_F(View, WhatSomeoneAskedForWhoHasLeftIsNotSimulated) {
  {
    LiveClient client(live_, recordings(), inbox_);
    client.receive(R"({"id": 1, "commands": [["set", 2, 0.2, 0, 0, -5]], "frames": 1})");
    EXPECT_EQ(meta_of(inbox_->next())["id"], 1);
    for (int k = 0; k < 20; ++k) client.receive(R"({"frames": 600})");
  }
  const json kept = json::parse(read_text(recordings() / "live_0001.json"));
  EXPECT_LT(kept["frames"].get<int>(), 20 * 600);
}

// Replay: `simulate --recording` of what a client did gives its last state, bit for bit, twice.
TEST_F(View, WhatWasDoneIsKeptAndGivesTheSameMotion) {
  std::string last;
  size_t drivers = 0;
  {
    LiveClient client(live_, recordings(), inbox_);
    Box box;
    for (const Vec3f& x : live_->moving.particles.driving_position) box.add(x);
    const Vec3f top(box.centre().x(), box.centre().y(), box.high.z());
    const json grab = {{"type", "grab"},
                       {"region", {{"sphere", {top.x(), top.y(), top.z(), 0.3 * box.size().norm()}}}}};
    client.receive(json({{"id", 1}, {"start", {{"frame", 4}}}}).dump());
    client.receive(json({{"id", 2}, {"commands", {{"begin", 50, grab}}}, {"frames", 3}}).dump());
    client.receive(R"({"id": 3, "commands": [["drag", 50, 0.02, 0.01, 0]], "frames": 5})");
    client.receive(R"({"id": 4, "commands": [["set", 3, 0.2, 0, 0, -5], ["drag", 50, -0.02, 0, 0.01]], "frames": 4})");
    client.receive(R"({"id": 5, "commands": [["end", 50]], "frames": 6})");
    EXPECT_EQ(json::parse(inbox_->next())["id"], 1);
    for (int k = 0; k < 4; ++k) {
      last = inbox_->next();
      EXPECT_TRUE(meta_of(last)["failed"].is_null()) << meta_of(last);
    }
    drivers = live_->drivers();
  }
  const fs::path file = recordings() / "live_0001.json";
  ASSERT_TRUE(fs::exists(file));
  const fs::path motion = *run_ / (object_folder(*run_) + "/recording.h5");
  std::string bytes[2];
  for (std::string& of_run : bytes) {
    ASSERT_EQ(run_quietly({"simulate", (folder / "run").string(), "--recording", file.string()}), 0);
    const TrajectoryFile again = read_trajectory(motion);
    ASSERT_EQ(again.frames.size(), 19u);
    // As the client was sent it: the message of the same state says the same.
    const TrajectoryFile::Frame& end = again.frames.back();
    ASSERT_EQ(end.position.size(), drivers);
    of_run.assign(reinterpret_cast<const char*>(end.F.data()), drivers * sizeof(Mat3f));
    const json meta = meta_of(last);
    Vec3f low = end.position[0], high = low;
    float speed = 0;
    for (size_t i = 0; i < drivers; ++i) {
      low = low.cwiseMin(end.position[i]);
      high = high.cwiseMax(end.position[i]);
      speed = std::max(speed, end.velocity[i].cwiseAbs().maxCoeff());
    }
    for (int a = 0; a < 3; ++a) {
      EXPECT_EQ(meta["low"][a].get<float>(), low[a]);
      EXPECT_EQ(meta["size"][a].get<float>(), high[a] - low[a]);
    }
    EXPECT_EQ(meta["speed"].get<float>(), speed);
  }
  EXPECT_EQ(bytes[0], bytes[1]);
  // A clip of it: as many frames as were recorded.
  const std::string run = (folder / "run").string();
  ASSERT_EQ(run_quietly({"render", run, "--recorded", "--no-orbit", "--size", "64x48"}), 0);
  size_t filmed = 0;
  for (const auto clip = open_frames(folder / "run/clip.mp4", 0); clip->next();) ++filmed;
  EXPECT_EQ(filmed, 19u);
  fs::remove(motion);
  EXPECT_EQ(run_quietly({"render", run, "--recorded"}), 2);
  json damaged = json::parse(read_text(file));
  damaged["held"] = damaged["held"].get<int>() + 1;  // another script than then
  write_text(folder / "damaged.json", damaged.dump());
  EXPECT_EQ(run_quietly({"simulate", run, "--recording", (folder / "damaged.json").string()}), 1);
  damaged.erase("held");
  damaged["commands"][0][1][1] = 0;  // "begin" with the number of a pin
  write_text(folder / "damaged.json", damaged.dump());
  EXPECT_EQ(run_quietly({"simulate", run, "--recording", (folder / "damaged.json").string()}), 1);
  damaged = json::parse(read_text(file));
  damaged["commands"][0][0] = 400;
  write_text(folder / "damaged.json", damaged.dump());
  EXPECT_NE(run_quietly({"simulate", (folder / "run").string(), "--recording", (folder / "damaged.json").string()}), 0);
}

TEST_F(View, ARecordingThatWouldNotFitIntoMemoryIsRefused) {
  ASSERT_GT(live_->drivers(), 200u);
  const json recording = {{"format", "pliant-recording"},
                          {"version", 2},
                          {"drivers", live_->drivers()},
                          {"clustered_to", 0},
                          {"start_frame", 0},
                          {"solver_fps", 60},
                          {"frames", 1'000'000},
                          {"commands", json::array()}};
  write_text(folder / "long.json", recording.dump());
  const std::string run = (folder / "run").string();
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(run_quietly({"simulate", run, "--recording", (folder / "long.json").string()}), 1);
  const std::string said = ::testing::internal::GetCapturedStderr();
  for (const char* word : {"long.json: frames", "GB of memory", "shorten"})
    EXPECT_NE(said.find(word), std::string::npos) << said;
}

TEST_F(View, AScreenGoesWhenAnotherIsShownButNotWhatItsClientsUse) {
  LiveSite site;
  const std::weak_ptr<const LiveScene> kept = live_;
  site.show({{"text/html", "first", ""}, [live = std::move(live_)](std::shared_ptr<Connection> connection) {
               return std::make_unique<LiveClient>(live, recordings(), std::move(connection));
             }});
  auto client = site.handler().connect(inbox_);
  {
    const auto page = site.handler().page("");
    site.show({{"text/html", "second", ""}, {}});
    EXPECT_EQ(page->body, "first") << "it may still be on its way";
  }
  client->receive(R"({"id": 1, "frames": 1})");
  EXPECT_EQ(meta_of(inbox_->next())["id"], 1);
  client.reset();
  EXPECT_TRUE(kept.expired());
}

TEST_F(View, NoSelectionIsPreparedUnlessAnObjectIsToBeChosen) {
  const fs::path prepared = folder / "run/prepared_scene.bin";
  // An address that is refused once there is something to show.
  std::vector<std::string> view = {"view", (folder / "run").string(), "--no-browser", "--host", "192.0.2.1"};
  fs::remove(prepared);
  EXPECT_EQ(run_quietly(view), 2);
  EXPECT_FALSE(fs::exists(prepared));
  view.push_back("--choose");
  EXPECT_EQ(run_quietly(view), 2);
  EXPECT_TRUE(fs::exists(prepared));
}

TEST_F(View, ThePageMayConnectToItsServerAndNothingElse) {
  ASSERT_EQ(run_quietly({"export", (folder / "run").string(), "--html", (folder / "live.html").string()}), 0);
  const std::string html = read_text(folder / "live.html");
  const LocalServer::Page page = live_page(html);
  EXPECT_EQ(html.find("connect-src"), std::string::npos);
  EXPECT_NE(page.body.find("connect-src 'self'"), std::string::npos);
  EXPECT_NE(page.body.find("<meta name=\"pliant-live\" content=\"live\">"), std::string::npos);
  EXPECT_EQ(page.security_policy.find("default-src 'none'; connect-src 'self'; "), 0u);
  EXPECT_NE(page.security_policy.find("frame-ancestors 'none'"), std::string::npos);
}

}  // namespace
}  // namespace pliant
