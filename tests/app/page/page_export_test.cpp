// `export --html`: the file keeps to its size, says what it gave up, and is refused where it cannot be; recordings that
// are none are refused by field.

#include <gtest/gtest.h>

#include "app/live/recording.h"
#include "app/page/clip_html.h"
#include "app/page/page_assets.h"
#include "app/page/page_stage.h"
#include "gaussians/base/error.h"
#include "tests/app/finished_stage.h"
#include "tests/app/moving_run.h"
#include "tests/temporary_folder.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

/// The header in a page.
json header_in(const std::string& html) {
  const std::string begin = "id=\"clip-header\">";
  const size_t at = html.find(begin) + begin.size();
  return json::parse(html.substr(at, html.find("</script>", at) - at));
}

TEST(ClipHtml, WhatAnObjectIsCalledIsNeitherMarkupNorAMark) {
  const TemporaryFolder folder;
  for (const char* name : {"<!--<script", "</script>", "/*SCRIPT*/", "<!--SECTIONS-->"}) {
    ClipPage page;
    page.file.header["title"] = name;
    SectionPacker packer;
    write_page(folder / "clip.html", page, packer);
    const std::string html = read_text(folder / "clip.html");
    EXPECT_EQ(header_in(html)["title"], name);
    EXPECT_EQ(html.find("<!--<script"), std::string::npos) << name;
    const size_t title = html.find("<title>");
    EXPECT_LT(html.find("</title>", title) - title, 100u) << name << ": no script in the title";
  }
}

class PageExport : public MovingRun {
 protected:
  static std::string run() { return (folder / "run").string(); }
  static std::string page(const std::string& name) { return (folder / name).string(); }
  static json header(const std::string& file) { return header_in(read_text(file)); }
  /// Bytes of a section of a page.
  static size_t section(const std::string& file, const std::string& name) {
    const std::string html = read_text(file), begin = "id=\"clip-" + name + "\">";
    const size_t at = html.find(begin) + begin.size();
    return html.find("</script>", at) - at;
  }
  /// Of a page of that size, with more options: 0, or the minimum that the refusal names.
  static size_t try_size(size_t size, const std::vector<std::string>& more = {}) {
    fs::remove(page("small.html"));
    std::vector<std::string> words = {"export",           run(),         "--html",
                                      page("small.html"), "--html-size", std::to_string(size)};
    words.insert(words.end(), more.begin(), more.end());
    ::testing::internal::CaptureStderr();
    const int code = run_quietly(words);
    const std::string said = ::testing::internal::GetCapturedStderr(), before = "minimum is ";
    EXPECT_EQ(code == 0, fs::exists(page("small.html"))) << said;
    EXPECT_TRUE(code == 0 || said.find(": " + std::to_string(size) + ": ") != std::string::npos) << said;
    return code == 0 ? 0 : std::stoul(said.substr(said.find(before) + before.size()));
  }
  /// What a page would be made from after this change of run.json.
  static StageInputs<PageStage> inputs_after(const std::function<void(json&)>& change) {
    const fs::path file = folder / "run/run.json";
    const std::string before = read_text(file);
    json record = json::parse(before);
    change(record);
    write_text(file, record.dump());
    const RunDirectory directory = RunDirectory::open(folder / "run");
    StageInputs<PageStage> inputs = inputs_of(directory, load_run_scene(directory), PageStage());
    write_text(file, before);
    return inputs;
  }
};

TEST_F(PageExport, IsBeforeTheBackgroundOfItsScene) {
  const std::string file = read_text(folder / "scene/scene.json");
  json scene = json::parse(file);
  scene["background"] = {1, 0.5, 1};
  write_text(folder / "scene/scene.json", scene.dump());
  EXPECT_EQ(run_quietly({"export", run(), "--html", page("before.html")}), 0);
  EXPECT_EQ(header(page("before.html"))["render"]["background"], json({1, 0.5, 1}));
  write_text(folder / "scene/scene.json", file);
  ASSERT_EQ(run_quietly({"export", run(), "--html", page("before.html"), "--overwrite"}), 0);
  EXPECT_EQ(header(page("before.html"))["render"]["background"], json({0, 0, 0}));
}

TEST_F(PageExport, KeepsToItsSizeAndSaysWhatItGaveUp) {
  ASSERT_EQ(run_quietly({"export", run(), "--html", page("whole.html"), "--html-size", "1000M"}), 0);
  const size_t whole = fs::file_size(page("whole.html"));
  EXPECT_EQ(header(page("whole.html"))["about"]["given_up"], "");
  const size_t most = whole - whole / 8;
  ASSERT_EQ(run_quietly({"export", run(), "--html", page("less.html"), "--html-size", std::to_string(most)}), 0);
  EXPECT_LE(fs::file_size(page("less.html")), most);
  EXPECT_NE(header(page("less.html"))["about"]["given_up"], "");
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(run_quietly({"export", run(), "--html", page("none.html"), "--html-size", "100k"}), 2);
  EXPECT_NE(::testing::internal::GetCapturedStderr().find("--html-size"), std::string::npos);
  EXPECT_FALSE(fs::exists(page("none.html")));
}

TEST_F(PageExport, TheMinimumThatIsNamedIsEnoughAndNoByteLess) {
  // A page holds a video of less than a tenth of its size.
  for (const size_t video : {0, 12'000}) {
    fs::remove(folder / "run/clip.mp4");
    if (video > 0) write_text(folder / "run/clip.mp4", std::string(video, 'x'));
    const size_t least = try_size(100'000);
    EXPECT_EQ(try_size(least - 1), least) << video;
    EXPECT_EQ(try_size(least), 0u) << video;
    EXPECT_LE(fs::file_size(page("small.html")), least) << video;
  }
  fs::remove(folder / "run/clip.mp4");
}

TEST_F(PageExport, ALongLicenseCountsInTheSize) {
  const std::vector<std::string> license = {"--html-license", std::string(5'000, '<')};  // 6 bytes each
  const size_t least = try_size(100'000, license);
  EXPECT_EQ(try_size(least, license), 0u);
  EXPECT_LE(fs::file_size(page("small.html")), least);
}

TEST_F(PageExport, TheSolverIsGivenUpLastAndThatIsSaid) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  fs::remove(folder / "run/clip.mp4");
  fs::remove(page("whole.html"));
  ASSERT_EQ(run_quietly({"export", run(), "--html", page("whole.html"), "--html-size", "1000M"}), 0);
  const size_t least = try_size(100'000);
  ASSERT_EQ(try_size(least), 0u);
  const json plays = header(page("small.html"));
  EXPECT_TRUE(plays["solver"].is_null());
  EXPECT_NE(plays["plays_only"], "");
  EXPECT_NE(plays["about"]["given_up"].get<std::string>().find("playback only"), std::string::npos);
  const size_t enough = least + section(page("whole.html"), "solver") + section(page("whole.html"), "levels");
  ASSERT_EQ(try_size(enough), 0u);
  EXPECT_LE(fs::file_size(page("small.html")), enough);
  EXPECT_TRUE(header(page("small.html"))["solver"].is_object());
  EXPECT_EQ(header(page("small.html"))["plays_only"], "");
}

// As `view` wants it, whose page comes from the same machine.
TEST_F(PageExport, APageThatMayGrowHasASolverWhateverItsSize) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  Progress progress(true);
  const Context context{progress, [] { return false; }};
  const RunDirectory directory = RunDirectory::open(folder / "run");
  PageStage stage;
  stage.size = 1;
  stage.grows = true;
  export_page(context, directory, load_run_scene(directory), stage, page("grown.html"));
  EXPECT_TRUE(header(page("grown.html"))["solver"].is_object());
}

TEST_F(PageExport, AGivenEIsNoPrediction) {
  const auto found = [&](const json& given) {
    return inputs_after([&](json& record) {
             json& stages = record["stages"];
             stages["simulate"]["found"]["predicted"] = "palm";
             const json band = {{"low", 1}, {"typical", 2}, {"high", 3}};
             stages["predict"] = finished_stage({{"understood", "palm"},
                                                 {"guessed", false},
                                                 {"softness", 0.5},
                                                 {"given", given},
                                                 {"young", 2},
                                                 {"young_band", band}});
           })
        .found;
  };
  EXPECT_EQ(found(json::array({"density"}))["prediction"]["young_band"]["high"], 3);
  EXPECT_FALSE(found(json::array({"density", "young"})).contains("prediction"));
}

TEST_F(PageExport, AClipOfAnEarlierMotionIsNotInThePage) {
  write_text(folder / "run/clip.mp4", "x");
  json render = finished_stage(json::object(), json::array({"clip.mp4"}));
  const auto has_clip = [&](const std::string& group, const std::string& trajectory) {
    render["inputs"]["trajectory"] = trajectory;
    return inputs_after([&](json& record) { record[group]["render"] = render; }).files.count("clip") > 0;
  };
  const std::string now = hash_of_input(inputs_after([](json&) {}).files.at("trajectory"));
  EXPECT_TRUE(has_clip("stages", now));
  EXPECT_FALSE(has_clip("stages", "of another motion"));
  EXPECT_FALSE(has_clip("begun", now)) << "it may be the one that was there before";
  fs::remove(folder / "run/clip.mp4");
}

TEST_F(PageExport, NothingIsFetchedAndTheLicenseIsShown) {
  ASSERT_EQ(run_quietly({"export", run(), "--html", page("page.html"), "--html-license", "CC BY 4.0 </script>"}), 0);
  const std::string html = read_text(page("page.html"));
  EXPECT_NE(html.find("default-src 'none'"), std::string::npos);
  for (size_t k = 0; (k = html.find("http://", k)) != std::string::npos; ++k)
    EXPECT_EQ(html.find("http://www.w3.org/", k), k) << "no name of a format: " << html.substr(k, 80);
  for (const char* address : {"https://", "ws://", "wss://", "src=\"//", "href=\"//", "url(//"})
    EXPECT_EQ(html.find(address), std::string::npos) << address;
  EXPECT_EQ(header(page("page.html"))["about"]["licence"], "CC BY 4.0 </script>");
  EXPECT_EQ(run_quietly({"export", run(), "--html", page("page.html")}), 2) << "it is there already";
  EXPECT_EQ(run_quietly({"export", run(), "--html-license", "X", "--ply-sequence", page("ply")}), 2);
}

TEST_F(PageExport, ARecordingThatIsNoneIsRefusedByItsField) {
  const Scene scene = load_run_scene(RunDirectory::open(folder / "run"));
  const json good = {
      {"format", "pliant-recording"},
      {"version", 1},
      {"drivers", 10},
      {"clustered_to", 0},
      {"start_frame", 0},
      {"frames", 5},
      {"solver_fps", 60},
      {"settings", {{{"frame", 0}, {"young_scale", 2}, {"damping_time", 1}, {"gravity", {0, 0, -9.81}}}}},
      {"interactions", json::array()},
      {"unpinned", json::array()}};
  const Recording parsed = parse_recording(good.dump(), scene, "recording.json");
  EXPECT_EQ(parsed.frames, 5);
  EXPECT_EQ(parsed.settings.at(0).settings.young_scale, 2);
  const std::vector<std::pair<std::string, json>> changes = {
      {"format", "another"}, {"version", 3},      {"drivers", "many"},
      {"frames", -1},        {"solver_fps", 0},   {"settings", {{{"frame", 0}, {"young_scale", 0}}}},
      {"unpinned", 3},       {"clustered_to", -1}};
  for (const auto& [field, value] : changes) {
    json bad = good;
    bad[field] = value;
    try {
      parse_recording(bad.dump(), scene, "recording.json");
      ADD_FAILURE() << field;
    } catch (const Error& error) {
      const std::string said = error.what();
      EXPECT_NE(said.find("recording.json"), std::string::npos) << said;
      EXPECT_NE(said.find(field == "settings" ? "young_scale" : field), std::string::npos) << said;
    }
  }
  EXPECT_THROW(parse_recording("{", scene, "recording.json"), Error);
  write_text(folder / "recording.json", good.dump());
  EXPECT_NE(run_quietly({"simulate", run(), "--recording", (folder / "recording.json").string()}), 0)
      << "no level has ten particles";
}

// As the page of `view` has it, so that what is done in either is known to be of this object and motion.
TEST_F(PageExport, ThePageSaysWhichMotionItsSolverBeginsWith) {
  if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
  const RunDirectory directory = RunDirectory::open(folder / "run");
  const LiveScene live = load_live_scene(directory, load_run_scene(directory), "view");
  ASSERT_EQ(run_quietly({"export", run(), "--html", page("said.html")}), 0);
  const json solver = header(page("said.html"))["solver"];
  EXPECT_EQ(solver["object"], live.object);
  EXPECT_EQ(solver["simulated"], live.simulated);
}

TEST_F(PageExport, ASizeThatIsTooSmallSaysWhatTheMinimumGives) {
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(run_quietly({"export", run(), "--html", page("none.html"), "--html-size", "100k"}), 2);
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("only plays, with almost no background"), std::string::npos) << said;
  EXPECT_EQ(said.find("--no-html"), std::string::npos) << "is no option of export: " << said;
}

}  // namespace
}  // namespace pliant
