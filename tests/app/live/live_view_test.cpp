// A client of `pliant view` and what stays of what it did.

#include "app/live/live_view.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <thread>

#include "app/commands/command.h"
#include "app/live/live_client.h"
#include "app/page/clip_html.h"
#include "app/simulate/driver_level.h"
#include "app/store/particles.h"
#include "app/store/trajectory.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/live/inbox.h"
#include "tests/app/live/view_until.h"
#include "tests/app/moving_run.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

/// A number of the head of a frame.
uint32_t word(const std::string& bytes, size_t at) {
  uint32_t value = 0;
  if (bytes.size() >= at + 4) std::memcpy(&value, bytes.data() + at, 4);
  return value;
}

json meta_of(const std::string& bytes) {
  if (bytes.substr(0, 4) != "PLNT") return json();
  uint32_t length;
  std::memcpy(&length, bytes.data() + 24, 4);
  return json::parse(bytes.substr(32, length));
}

class View : public MovingRun {
 protected:
  void SetUp() override {
    run_ = std::make_unique<RunDirectory>(RunDirectory::open(folder / "run"));
    live_ = std::make_shared<const LiveScene>(load_live_scene(*run_, load_run_scene(*run_), "view"));
    fs::remove_all(recordings());
  }
  static fs::path recordings() { return folder / "run/recordings"; }
  /// A recording in which nothing is done.
  json still_recording(int frames) const {
    return {{"format", "pliant-recording"},
            {"version", 2},
            {"drivers", live_->drivers()},
            {"clustered_to", 0},
            {"start_frame", 0},
            {"solver_fps", 60},
            {"frames", frames},
            {"commands", json::array()}};
  }

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
  const std::string last = inbox_->next();
  EXPECT_EQ(meta_of(last)["id"], 5);
  EXPECT_EQ(word(last, 8), 3u) << "the frame after the two";
  EXPECT_FALSE(fs::exists(recordings())) << "nothing was done";
}

TEST_F(View, ALevelIsBegunWithTheDriversThatItHas) {
  size_t drivers = 0;
  {
    LiveClient client(live_, recordings(), inbox_);
    client.receive(R"({"id": 1, "start": {"clustered_to": 150}})");
    client.receive(R"({"id": 2, "commands": [["set", 2, 0.2, 0, 0, -5]], "frames": 1})");
    EXPECT_EQ(json::parse(inbox_->next()), json({{"id", 1}}));
    drivers = word(inbox_->next(), 12);
    EXPECT_GT(drivers, 0u);
    EXPECT_LT(drivers, live_->drivers());
  }
  const json kept = json::parse(read_text(recordings() / "live_0001.json"));
  EXPECT_EQ(kept["drivers"], drivers);
  EXPECT_EQ(kept["clustered_to"], 150);
}

TEST_F(View, RunsByItselfUntilItIsTold) {
  LiveClient client(live_, recordings(), inbox_);
  client.receive(R"({"run": true})");
  for (int k = 0; k < 5; ++k) {
    const json meta = meta_of(inbox_->next());
    ASSERT_TRUE(meta.is_object());
    EXPECT_EQ(meta["within"], false) << "no frame takes long";
  }
  client.receive(R"({"id": 9, "run": false})");
  for (int k = 0; k < 1000; ++k)
    if (const std::string message = inbox_->next(); message.substr(0, 4) != "PLNT") {
      EXPECT_EQ(json::parse(message)["id"], 9);
      return;
    }
  FAIL() << "it did not stop";
}

// A frame that takes long is shown as far as it has come, between the frame before and itself; the frames that are
// asked for by number are not.
TEST_F(View, AFrameThatTakesLongIsShownAsFarAsItHasCome) {
  LiveClient client(live_, recordings(), inbox_, {}, std::chrono::milliseconds(0));
  client.receive(R"({"id": 1, "frames": 3})");
  const std::string asked = inbox_->next();
  EXPECT_EQ(meta_of(asked)["id"], 1);
  EXPECT_EQ(meta_of(asked)["within"], false);
  client.receive(R"({"run": true})");
  int within = 0;
  for (uint32_t frames = word(asked, 8); frames < 6;) {
    const std::string message = inbox_->next();
    const json meta = meta_of(message);
    ASSERT_TRUE(meta.is_object()) << message.substr(0, 100);
    EXPECT_EQ(word(message, 12), word(asked, 12)) << "particles";
    const bool whole = !meta["within"].get<bool>();
    EXPECT_EQ(word(message, 8), frames + (whole ? 1 : 0));
    frames = word(message, 8);
    if (whole) {
      EXPECT_EQ(within, meta["substeps"].get<int>()) << "one of each time step";
      within = 0;
    } else {
      ++within;
    }
  }
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
    client.receive(R"({"id": 4, "commands": [["set", 3, 0.2, 0, 0, -5], ["drag", 50, -0.02, 0, 0.01],
                       ["begin", 0, {"type": "wind", "wind": [3, 0, 0]}]], "frames": 4})");
    client.receive(R"({"id": 5, "commands": [["end", 50]], "frames": 6})");
    EXPECT_EQ(json::parse(inbox_->next())["id"], 1);
    for (int k = 0; k < 4; ++k) {
      last = inbox_->next();
      EXPECT_TRUE(meta_of(last)["failed"].is_null()) << meta_of(last);
      EXPECT_EQ(meta_of(last)["refused"].size(), k == 2 ? 1u : 0u) << "0 is the number of a pin";
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
  // Beside the particles of another level it shows nothing.
  write_particles(motion.parent_path() / "recording_particles.h5",
                  with_drivers(live_->moving.particles, live_->scene, 150), "{}");
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(run_quietly({"render", run, "--recorded"}), 1);
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find(motion.string() + ": position"), std::string::npos) << said;
  EXPECT_EQ(said.find("internal error"), std::string::npos) << said;
  // Where a replay cannot be written, the motion of an earlier one is gone.
  const fs::path blocked = temporary_name(motion);
  write_text(blocked / "of_somebody", "");
  EXPECT_EQ(run_quietly({"simulate", run, "--recording", file.string()}), 1);
  EXPECT_FALSE(fs::exists(motion));
  EXPECT_EQ(run_quietly({"render", run, "--recorded"}), 2);
  fs::remove_all(blocked);
  json damaged = json::parse(read_text(file));
  damaged["held"] = damaged["held"].get<int>() + 1;  // another script than then
  write_text(folder / "damaged.json", damaged.dump());
  EXPECT_EQ(run_quietly({"simulate", run, "--recording", (folder / "damaged.json").string()}), 1);
  damaged.erase("held");
  damaged["commands"][0][1][1] = 0;  // "begin" with the number of a pin
  write_text(folder / "damaged.json", damaged.dump());
  EXPECT_EQ(run_quietly({"simulate", run, "--recording", (folder / "damaged.json").string()}), 1);
  const json recorded = json::parse(read_text(file));
  const auto replay = [&](const json& recording, int code) {
    write_text(folder / "damaged.json", recording.dump());
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(run_quietly({"simulate", run, "--recording", (folder / "damaged.json").string()}), code);
    return ::testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(replay(recorded, 0).find("another motion"), std::string::npos);
  damaged = recorded;
  damaged["simulated"]["options"]["young"] = 1e4;
  EXPECT_NE(replay(damaged, 0).find("another motion: option 'young' was 10000.0, now 20000.0"), std::string::npos);
  damaged["simulated"]["inputs"]["object"] = "other splats";
  damaged["object"] = "elephant";
  EXPECT_NE(replay(damaged, 1).find("elephant"), std::string::npos);
  // Where splats did not count for the motion, the particles tell one that was renamed from another.
  const fs::path manifest = folder / "run/run.json";
  const std::string whole = read_text(manifest);
  json record = json::parse(whole);
  record["stages"]["simulate"]["inputs"].erase("object");
  write_text(manifest, record.dump());
  damaged["simulated"]["inputs"].erase("object");
  EXPECT_EQ(replay(damaged, 0).find("elephant"), std::string::npos);
  damaged["simulated"]["inputs"]["particles"] = "other particles";
  EXPECT_NE(replay(damaged, 1).find("elephant"), std::string::npos);
  write_text(manifest, whole);
  damaged.erase("simulated");
  damaged.erase("object");
  EXPECT_EQ(replay(damaged, 0).find("another motion"), std::string::npos) << "as earlier ones are";
  damaged = recorded;
  damaged["commands"][0][0] = 400;
  write_text(folder / "damaged.json", damaged.dump());
  EXPECT_NE(run_quietly({"simulate", (folder / "run").string(), "--recording", (folder / "damaged.json").string()}), 0);
}

// `extract` writes another object of the same name into the same folder.
TEST_F(View, AClipOfARecordingIsOfTheObjectThatWasMoved) {
  write_text(folder / "still.json", still_recording(2).dump());
  const std::string run = (folder / "run").string();
  const auto said = [](std::vector<std::string> words, int code) {
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(run_quietly(std::move(words)), code);
    return ::testing::internal::GetCapturedStderr();
  };
  const std::vector<std::string> replay = {"simulate", run, "--recording", (folder / "still.json").string()},
                                 film = {"render", run, "--recorded", "--no-orbit", "--size", "64x48"};
  said(replay, 0);
  said(film, 0);
  const fs::path object = *run_ / object_folder(*run_), splats = object / "object.ply";
  const std::string whole = read_text(splats);
  GaussianCloud other = read_ply(splats);
  for (Vec3f& x : other.position) x.x() += 0.01f;
  write_ply(splats, other);
  for (const auto& command : {film, replay}) {
    const std::string refused = said(command, 2);
    for (const char* word : {"moved another object", "pliant seed"})
      EXPECT_NE(refused.find(word), std::string::npos) << refused;
  }
  write_text(splats, whole);
  said(film, 0);
  // Seeded and simulated again, and not replayed.
  const auto made_from = [&](const std::string& provenance) {
    write_trajectory(object / "recording.h5", read_trajectory(object / "recording.h5"), provenance);
    return said(film, 2);
  };
  const std::string earlier = made_from(R"({"object": "of then"})");
  for (const char* word :
       {"--recorded", "recording.h5", "replaced by `extract`", "pliant simulate DIR --recording FILE"})
    EXPECT_NE(earlier.find(word), std::string::npos) << earlier;
  // One that does not say what it is of, as those of earlier versions.
  EXPECT_NE(made_from(R"({"recording": "of then"})").find("does not say which object"), std::string::npos);
}

// As a clip.html saves it.
TEST_F(View, ARecordingOfAPageIsOfItsObjectAndMotionAsOneOfView) {
  json page = still_recording(2);
  page.erase("commands");
  page["version"] = 1;
  const std::string file = (folder / "page.json").string();
  const auto replay = [&](const json& recording, int code) {
    write_text(file, recording.dump());
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(run_quietly({"simulate", (folder / "run").string(), "--recording", file}), code) << recording;
    return ::testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(replay(page, 0).find("another motion"), std::string::npos) << "as earlier ones are";
  const int held = static_cast<int>(live_->setup.held.size());
  json released = page;
  released["unpinned"] = {{{"frame", 0}, {"held", held}}};
  EXPECT_NE(replay(released, 1).find("unpinned"), std::string::npos);
  page.update({{"held", held}, {"object", live_->object}, {"simulated", live_->simulated}});
  EXPECT_EQ(replay(page, 0).find("another motion"), std::string::npos);
  json other = page;
  other["held"] = held + 1;
  EXPECT_NE(replay(other, 1).find("held"), std::string::npos);
  other = page;
  other["simulated"]["options"]["young"] = 1e4;
  EXPECT_NE(replay(other, 0).find("another motion"), std::string::npos);
  other["simulated"]["inputs"]["object"] = "other splats";
  other["object"] = "elephant";
  EXPECT_NE(replay(other, 1).find("elephant"), std::string::npos);
}

TEST_F(View, ADurationShortensAReplay) {
  const std::string run = (folder / "run").string(), file = (folder / "idle.json").string();
  write_text(file, still_recording(1'000'000).dump());
  EXPECT_EQ(run_quietly({"simulate", run, "--recording", file, "--duration", "0.05"}), 0);
  const fs::path motion = *run_ / object_folder(*run_) / "recording.h5";
  EXPECT_EQ(read_trajectory(motion).frames.size(), 4u);
  write_text(file, still_recording(2).dump());
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(run_quietly({"simulate", run, "--recording", file, "--duration", "3"}), 0);
  EXPECT_NE(::testing::internal::GetCapturedStderr().find("before --duration 3"), std::string::npos);
  EXPECT_EQ(read_trajectory(motion).frames.size(), 3u);
  EXPECT_EQ(run_quietly({"simulate", run, "--recording", file, "--fps", "20"}), 2);
}

TEST_F(View, ARecordingThatWouldNotFitIntoMemoryIsRefused) {
  ASSERT_GT(live_->drivers(), 200u);
  write_text(folder / "long.json", still_recording(1'000'000).dump());
  const std::string run = (folder / "run").string();
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(run_quietly({"simulate", run, "--recording", (folder / "long.json").string()}), 1);
  const std::string said = ::testing::internal::GetCapturedStderr();
  for (const char* word : {"long.json: frames", "GB of memory", "shorten", "--duration"})
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
  const std::string run = (folder / "run").string();
  fs::remove(prepared);
  fixture::view_until({run}, [] { return true; });
  EXPECT_FALSE(fs::exists(prepared));
  fixture::view_until({run, "--choose"}, [&] { return fs::exists(prepared); });
  EXPECT_TRUE(fs::exists(prepared));
}

// As after a motion of new particles was cancelled.
TEST_F(View, WhereTheMotionIsOfOtherParticlesTheChoiceIsShown) {
  fs::copy(folder / "run", folder / "reseeded", fs::copy_options::recursive);
  const std::string run = (folder / "reseeded").string();
  ASSERT_EQ(run_quietly({"seed", run, "--particles", "500"}), 0);
  const fs::path prepared = folder / "reseeded/prepared_scene.bin";
  fs::remove(prepared);
  fixture::view_until({run}, [&] { return fs::exists(prepared); });
  EXPECT_TRUE(fs::exists(prepared));
}

TEST_F(View, AnAddressThatCannotBeUsedIsRefusedBeforeAnythingIsDone) {
  const fs::path out = folder / "early";
  EXPECT_EQ(run_quietly({"view", (folder / "scene").string(), "--out", out.string(), "--host", "192.0.2.1"}), 2);
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(View, WhoAllowsOthersButListensToItselfIsToldSo) {
  std::string warned;
  fixture::view_until(
      {(folder / "run").string(), "--allow-remote"}, [] { return true; }, &warned);
  EXPECT_NE(warned.find("add --host"), std::string::npos) << warned;
  EXPECT_EQ(warned.find("anyone"), std::string::npos) << warned;
}

TEST_F(View, ClientsThatBeginTogetherKeepFilesOfTheirOwn) {
  for (int round = 0; round < 5; ++round) {
    std::vector<std::unique_ptr<LiveClient>> clients;
    for (int k = 0; k < 4; ++k) clients.push_back(std::make_unique<LiveClient>(live_, recordings(), inbox_));
    for (const auto& client : clients) client->receive(R"({"commands": [["set", 2, 0.2, 0, 0, -5]], "frames": 1})");
    for (int k = 0; k < 4; ++k) inbox_->next();
  }
  size_t files = 0;
  for (const auto& file : fs::directory_iterator(recordings())) {
    EXPECT_NO_THROW(parse_recording(read_text(file.path()), live_->scene, file.path().string()));
    ++files;
  }
  EXPECT_EQ(files, 20u);
}

TEST_F(View, WhatIsDoneIsKeptAlthoughNothingFollows) {
  LiveClient client(live_, recordings(), inbox_);
  const char* const kSet = R"({"commands": [["set", 2, 0.2, 0, 0, -5]], "frames": 1})";
  client.receive(kSet);
  client.receive(R"({"start": {}})");
  client.receive(kSet);
  const auto second = recordings() / "live_0002.json";
  for (int k = 0; k < 40 && !fs::exists(second); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_TRUE(fs::exists(second));
  client.receive(R"({"frames": 20})");
  const auto kept = [&] { return json::parse(read_text(second), nullptr, false); };
  for (int k = 0; k < 40 && kept().value("frames", 0) != 21; ++k)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(kept()["frames"], 21) << "although nothing more was commanded";
}

// As many frames as there is time for, however often it is told to run.
TEST_F(View, ToldAgainToRunItRunsNoFaster) {
  LiveClient client(live_, recordings(), inbox_);
  const auto begin = std::chrono::steady_clock::now();
  for (int k = 0; k < 100; ++k) {
    client.receive(R"({"run": true})");
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  client.receive(R"({"id": 9, "run": false})");
  int frames = 0;
  for (std::string message = inbox_->next(); message.substr(0, 4) == "PLNT"; message = inbox_->next()) ++frames;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_LE(frames, live_->setup.options.fps * seconds + 2);
  EXPECT_GT(frames, 0);
}

TEST_F(View, ARecordingThatCannotBeKeptIsToldOnceAndElsewhereToo) {
  write_text(folder / "blocked", "a file");
  int warned = 0;
  {
    LiveClient client(live_, folder / "blocked/recordings", inbox_, [&](const std::string& text) {
      EXPECT_NE(text.find("cannot be kept"), std::string::npos);
      ++warned;
    });
    client.receive(R"({"id": 1, "commands": [["set", 2, 0.2, 0, 0, -5]], "frames": 1})");
    EXPECT_EQ(meta_of(inbox_->next())["id"], 1);
    const json said = json::parse(inbox_->next());
    EXPECT_FALSE(said.contains("id"));
    EXPECT_NE(said["error"].get<std::string>().find("cannot be kept"), std::string::npos);
  }
  EXPECT_EQ(warned, 1);
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
