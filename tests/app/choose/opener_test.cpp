// A site that begins without a scene and opens the file that is dropped on it.

#include "app/choose/opener.h"

#include <gtest/gtest.h>

#include "gaussians/base/error.h"
#include "gaussians/base/orbit.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/base64.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/scene/scene.h"
#include "gaussians/io/splats/splats.h"
#include "tests/app/live/inbox.h"
#include "tests/app/live/site_in_browser.h"
#include "tests/temporary_folder.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

class Open : public ::testing::Test {
 protected:
  void SetUp() override {
    GaussianCloud cloud;
    cloud.resize(5);
    for (Vec4f& rotation : cloud.rotation) rotation = Vec4f(1, 0, 0, 0);
    write_splats(folder_ / "made.ply", cloud);
    fs::create_directories(folder_ / "kept");
    const auto run_of = [this](const fs::path& scene) { return folder_ / "kept" / (scene.stem().string() + "_run"); };
    opener_ = std::make_unique<Opener>(context_, site_, folder_ / "kept", run_of,
                                       [this](const Context&, const fs::path& scene) {
                                         if (scene.filename() == "broken.ply")
                                           throw input_error(scene.string(), "vertex", "is broken", "give another");
                                         opened_ = read_splats(scene).size();
                                         site_.show({{"text/html", "<p>the scene", "default-src 'none'"}, {}});
                                       });
    site_.take_files([this](const std::string& name, const fs::path& file) { return opener_->take(name, file); });
    opener_->show();
  }
  /// What the opener says of a file of this content.
  std::string drop(const std::string& name, const std::string& bytes) {
    write_text(folder_ / "partial", bytes);
    return opener_->take(name, folder_ / "partial");
  }
  std::string made() const { return read_text(folder_ / "made.ply"); }

  const TemporaryFolder folder_;
  Progress progress_{true};
  const Context context_{progress_, [] { return false; }};
  LiveSite site_;
  std::atomic<size_t> opened_ = 0;
  std::unique_ptr<Opener> opener_;
};

TEST_F(Open, TakesSplatsAndSaysWhatElseIsRefused) {
  const auto inbox = std::make_shared<Inbox>();
  const auto client = site_.handler().connect(inbox);
  EXPECT_NE(drop("notes.txt", "hello").find("not a splat file"), std::string::npos);
  EXPECT_TRUE(fs::is_empty(folder_ / "kept"));
  EXPECT_EQ(drop("broken.ply", made()), "");
  EXPECT_NE(inbox->next().find("is broken"), std::string::npos);
  EXPECT_EQ(drop("a.ply", made()), "") << "another may follow one that could not be opened";
  EXPECT_NE(inbox->next().find("reload"), std::string::npos);
  EXPECT_EQ(opened_, 5u);
  EXPECT_NE(site_.handler().page("")->body.find("the scene"), std::string::npos);
  EXPECT_NE(drop("b.ply", made()).find("open already"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "kept/dropped_b"));
  EXPECT_FALSE(fs::exists(folder_ / "partial"));
}

TEST_F(Open, OverwritesNothing) {
  write_text(folder_ / "kept/dropped_a/a.ply", "precious");
  write_text(folder_ / "kept/dropped_a-2/other.ply", "too");
  EXPECT_EQ(drop("a.ply", made()), "");
  EXPECT_EQ(read_text(folder_ / "kept/dropped_a/a.ply"), "precious");
  EXPECT_FALSE(fs::exists(folder_ / "kept/dropped_a-2/a-2.ply"));
  EXPECT_EQ(read_text(folder_ / "kept/dropped_a-3/a-3.ply"), made());
}

TEST_F(Open, TheRunOfAnotherFileTakesAName) {
  fs::create_directories(folder_ / "kept/a_run");
  fs::create_directories(folder_ / "kept/a-2_run");
  EXPECT_EQ(drop("a.ply", made()), "");
  EXPECT_FALSE(fs::exists(folder_ / "kept/dropped_a"));
  EXPECT_EQ(read_text(folder_ / "kept/dropped_a-3/a-3.ply"), made());
}

// Nor of the folder above, where a trained model has those of its iterations.
TEST_F(Open, TakesNoCamerasOfTheFolder) {
  std::vector<Camera> cameras(3, look_at({2, 0, 0}, {0, 0, 0}, {0, 0, 1}, 64, 48, 60));
  for (size_t i = 0; i < cameras.size(); ++i) cameras[i].name = std::to_string(i);
  for (const fs::path& place : {folder_ / "transforms.json", folder_ / "kept/transforms.json"})
    write_transforms(place, cameras);
  EXPECT_FALSE(cameras_of_splats(folder_ / "kept/iteration_7.ply").empty()) << "there are some to take";
  EXPECT_EQ(drop("iteration_7.ply", made()), "");
  const fs::path scene = folder_ / "kept/dropped_iteration_7/iteration_7.ply";
  ASSERT_TRUE(fs::exists(scene));
  EXPECT_EQ(cameras_of_splats(scene), "");
}

TEST_F(Open, ThePageSendsAFileAndShowsWhatIsOpened) {
  if (const std::string missing = browser_missing(); !missing.empty()) GTEST_SKIP() << missing;
  LocalServerOptions options;
  options.drop_folder = folder_ / "kept";
  const json answer = evaluate_in_site(R"((async () => {
    while (socket.readyState === WebSocket.CONNECTING) await new Promise((done) => setTimeout(done, 20));
    const said = [];
    const shown = () => new Promise((done) => {
      const look = () => element('failed').hidden ? setTimeout(look, 20) : done(element('failed').textContent);
      look();
    });
    send(new File(['hello'], 'notes (1).txt'));
    said.push(await shown());
    socket.onmessage = ({data}) => said.push(data);
    send(new File([Uint8Array.from(atob(')" +
                                           base64(made()) + R"('), (c) => c.charCodeAt(0))], 'my scene.ply'));
    while (said.length < 2) await new Promise((done) => setTimeout(done, 20));
    return said;
  })())",
                                       site_, folder_.path(), options);
  ASSERT_TRUE(answer.contains("value")) << answer.dump().substr(0, 2000);
  EXPECT_NE(answer["value"][0].get<std::string>().find("notes__1_.txt is not a splat file"), std::string::npos);
  EXPECT_EQ(json::parse(answer["value"][1].get<std::string>())["reload"], true);
  EXPECT_EQ(opened_, 5u);
  EXPECT_TRUE(fs::exists(folder_ / "kept/dropped_my_scene/my_scene.ply"));
}

}  // namespace
}  // namespace pliant
