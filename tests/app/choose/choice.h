#pragma once

#include <gtest/gtest.h>

#include <condition_variable>
#include <mutex>

#include "app/choose/chooser.h"
#include "app/segment/segment_stage.h"
#include "tests/app/fit_video_scene.h"
#include "tests/app/live/inbox.h"

namespace pliant {

/// Stops a program where it says a sentence that begins with some words, until it is opened.
class Gate {
 public:
  void close_at(const std::string& words) {
    const std::lock_guard lock(mutex_);
    words_ = words;
    stopped_ = false;
  }
  void open() {
    const std::lock_guard lock(mutex_);
    words_.clear();
    wake_.notify_all();
  }
  void pass(const std::string& sentence) {
    std::unique_lock lock(mutex_);
    if (words_.empty() || !sentence.starts_with(words_)) return;
    stopped_ = true;
    wake_.notify_all();
    wake_.wait(lock, [&] { return words_.empty(); });
  }
  /// Waits until the program stands there.
  void await_stop() {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(wake_.wait_for(lock, std::chrono::seconds(20), [&] { return stopped_; })) << words_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable wake_;
  std::string words_;
  bool stopped_ = false;
};

/// The choice of an object of a small scene, with a client.
class Choice : public FitVideo {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(folder / "choice");
    std::filesystem::copy(folder / "run", folder / "choice", std::filesystem::copy_options::recursive);
    run_ = std::make_unique<RunDirectory>(RunDirectory::open(folder / "choice"));
    scene_ = load_run_scene(*run_);
    progress_.listen([this](const ProgressEvent& event) { gate_.pass(event.text); });
    start();
  }
  void start() {
    ObjectStages stages;
    stages.seed.fill.particles = 600;
    chooser_ = std::make_unique<Chooser>(context_, *run_, scene_, site_, stages);
    chooser_->show();
    inbox_ = std::make_shared<Inbox>();
    client_ = site_.handler().connect(inbox_);
  }
  void stop() {
    client_.reset();
    chooser_.reset();
  }
  void TearDown() override {
    gate_.open();
    stop();
  }

  /// The id of the object that the scene names.
  uint32_t plant() const {
    const nlohmann::json shown = data();
    for (const nlohmann::json& thing : shown["things"])
      if (thing["name"] == scene_.settings.object) return thing["id"];
    ADD_FAILURE() << "no object " << scene_.settings.object;
    return 0;
  }
  /// A click into the longest row of pixels of an object in the first view that shows it, and where in its picture.
  struct Place {
    std::string click;
    int camera = 0;
    size_t pixel = 0;
  };
  Place middle_of(uint32_t id) const {
    const nlohmann::json shown = data();
    for (const nlohmann::json& view : shown["views"]) {
      Place place;
      size_t best = 0, at = 0;
      for (size_t k = 0; k < view["ids"].size(); at += view["ids"][k + 1].get<size_t>(), k += 2)
        if (view["ids"][k] == id && view["ids"][k + 1].get<size_t>() > best) {
          best = view["ids"][k + 1];
          place.pixel = at + best / 2;
        }
      if (best < 6) continue;
      const size_t width = view["width"];
      const double across = view["scale"][0], down = view["scale"][1];
      place.camera = view["camera"];
      place.click = std::to_string(place.camera) + "," + std::to_string(across * (place.pixel % width + 0.5)) + "," +
                    std::to_string(down * (place.pixel / width + 0.5));
      return place;
    }
    return {};
  }
  nlohmann::json data() const { return choose_data(*run_, scene_, {}); }
  std::string page() { return site_.handler().page("")->body; }
  /// The first message with this field; `said_` gathers the sentences up to it.
  nlohmann::json await(const std::string& field) {
    for (int k = 0; k < 10000; ++k) {
      const std::string text = inbox_->next();
      if (text.empty()) break;
      nlohmann::json message = nlohmann::json::parse(text);
      said_ += message.value("said", "") + "\n";
      if (message.contains(field)) return message[field];
      if (message.contains("failed") || message.contains("error")) ADD_FAILURE() << text;
    }
    return nullptr;
  }

  Gate gate_;
  Progress progress_{true};
  const Context context_{progress_, [] { return false; }};
  std::unique_ptr<RunDirectory> run_;
  Scene scene_;
  LiveSite site_;
  std::unique_ptr<Chooser> chooser_;
  std::shared_ptr<Inbox> inbox_;
  std::unique_ptr<Client> client_;
  std::string said_;
};

}  // namespace pliant
