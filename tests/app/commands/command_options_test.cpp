// Options that belong to commands, not to stages: each changes what the command prints, writes or returns, or is
// refused by its name.  Which options there are is asked from the parser itself.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "app/store/segmentation.h"
#include "app/store/trajectory.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/commands/all_tables.h"
#include "tests/app/run_pliant.h"
#include "tests/segmentation/made_scene.h"
#include "tests/temporary_folder.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

using Words = std::vector<std::string>;

/// A command with an option more, and whether that is refused.
struct Case {
  std::string command, option, value;  ///< value empty = a flag
  Words base;
  bool refused = false;
};

/// Exit code, output and files of a command; OUT stands for a new folder.  Times, and where it is, do not count.
std::string trace_of(Words words, const fs::path& out) {
  fs::remove_all(out);
  for (std::string& word : words)
    for (size_t at; (at = word.find("OUT")) != std::string::npos;) word.replace(at, 3, out.string());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int code = run_pliant(words);
  std::string trace = fmt::format("exit {}\n{}", code, testing::internal::GetCapturedStdout());
  const std::string said = testing::internal::GetCapturedStderr();
  if (code != 0) trace += said;
  trace += said.empty() ? "silent\n" : "";
  std::set<fs::path> files;
  if (fs::is_directory(out))
    for (const auto& entry : fs::recursive_directory_iterator(out))
      if (entry.is_regular_file()) files.insert(entry.path());
  for (const fs::path& file : files) {
    std::string content = sha256_of_file(file);
    if (file.filename() == "run.json") {
      json record = json::parse(read_text(file));
      for (json& stage : record["stages"])
        for (const char* time : {"wall_s", "peak_memory_mb", "threads"}) stage.erase(time);
      content = record.dump();
    }
    trace += fs::relative(file, out).string() + " " + content + "\n";
  }
  return trace;
}

class CommandOptions : public testing::Test {
 protected:
  void SetUp() override {
    const MadeScene made =
        made_scene({{Vec3f(0, 0, 0.15f), 0.3f, 300, Vec3f(0.8f, 0.1f, 0.1f)}}, 4, 60, 45, 0.08f, 0.08f);
    GaussianCloud cloud = made.cloud;
    fs::create_directories(folder_ / "scene/masks");
    write_ply(folder_ / "scene/splats.ply", cloud);
    write_ply(folder_ / "bare/splats.ply", cloud);
    cloud = with_sh_degree(cloud, 1);
    for (float& value : cloud.sh) value += 0.01f;
    write_ply(folder_ / "colored.ply", cloud);
    write_cameras(folder_ / "scene/transforms.json", made.cameras);
    for (const Camera& camera : made.cameras) {
      const IdImage ids = cast_ids(made, camera);
      IdImage shifted = ids;
      for (int y = 0; y < ids.height; ++y)
        for (int x = 1; x < ids.width; ++x) shifted(x, y) = ids(x - 1, y) + 1;
      write_ids(folder_ / "scene/masks" / (camera.name + ".png"), ids);
      if (camera.name != "view3") write_ids(folder_ / "predicted" / (camera.name + ".png"), shifted);
    }
    write_text(folder_ / "scene/scene.json",
               R"({"splats": "splats.ply", "cameras": "transforms.json", "masks": "masks"})");
    write_labels(folder_ / "labels.h5", {made.truth, {}}, "{}");
    write_text(folder_ / "degree.json", R"({"sh-degree": 0})");
    for (int f = 0; f < 12; ++f) {
      ImageF frame(32, 24, 3);
      for (int y = 8; y < 12; ++y)
        for (int c = 0; c < 3; ++c) frame(8 + f, y, c) = 1;
      fs::create_directories(folder_ / "clip");
      write_image(folder_ / "clip" / fmt::format("{:02d}.png", f), frame);
    }
    TrajectoryFile swing;
    swing.object = "ball";
    swing.fps = 20;
    for (int f = 0; f < 40; ++f) {
      TrajectoryFile::Frame frame;
      frame.time = f / 20.0;
      for (int p = 0; p < 10; ++p) {
        const double push = f < 10 ? f / 10.0 : std::exp(-0.2 * (f - 10)) * std::cos(0.8 * (f - 10));
        frame.position.push_back(Vec3f(static_cast<float>(0.1 * p * push), 0, static_cast<float>(0.1 * p)));
        frame.velocity.push_back(Vec3f::Zero());
        frame.F.push_back(Mat3f::Identity());
      }
      swing.frames.push_back(frame);
    }
    write_trajectory(folder_ / "swing.h5", swing, "{}");
    std::string bands = "estimate,low,high,truth\n";
    for (int i = 0; i < 16; ++i) {
      const std::string result = fmt::format(R"({{"psnr": {}, "ssim": 0.{}}})", 20 + i % 5, 7 + i % 3);
      write_text(folder_ / fmt::format("results/{}/{}.json", i % 2, i / 2), result);
      bands += fmt::format("1,0.5,1.5,{}\n", 0.3 + 0.1 * i);
    }
    write_text(folder_ / "bands.csv", bands);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  std::vector<Case> cases() const {
    const Words demo = {"demo",     "--out", "OUT",     "--gaussians", "2000",     "--training", "0",
                        "--photos", "2",     "--width", "48",          "--height", "32",         "--no-video"};
    const Words info = {"info", path("colored.ply")}, convert = {"convert", path("colored.ply"), "OUT/out.ply"},
                cameras = {"convert", path("scene/transforms.json"), "OUT/cameras.json"},
                images = {"render", path("scene"), "--out", "OUT/images"},
                orbit = {"render", path("scene"), "--out", "OUT/images", "--cameras", "orbit", "--orbit-views", "4"},
                video = {"render", path("scene"), "--out", "OUT/clip.mp4"},
                segment = {"segment", path("scene"), "--out", "OUT/run", "--iterations", "2"},
                bare = {"segment", path("bare"), "--out", "OUT/run", "--sphere", "0,0,0.2,0.3"},
                psnr = {"evaluate", "images", path("scene/masks"), path("scene/masks")},
                miou = {"evaluate", "segmentation", path("predicted"), path("scene/masks")},
                labels = {"evaluate", "segmentation", path("labels.h5"), path("labels.h5")},
                motion = {"evaluate", "motion", path("swing.h5"), path("swing.h5")},
                compare = {"evaluate", "compare", "ours=" + path("results/0"), "theirs=" + path("results/1")},
                bands = {"evaluate", "calibration", path("bands.csv")},
                slices = {"evaluate", "slices", path("clip"), path("clip"), "--fps", "10", "--out", "OUT/slices.png"};
    return {
        {"demo", "kind", "jelly", demo},
        {"demo", "gaussians", "2500", demo},
        {"demo", "training", "2", demo},
        {"demo", "photos", "3", demo},
        {"demo", "width", "64", demo},
        {"demo", "height", "48", demo},
        {"demo", "seed", "2", demo},
        {"info", "level", "1", info, true},
        {"info", "json", "", info},
        {"convert", "sh-degree", "0", convert},
        {"convert", "config", path("degree.json"), convert},
        {"convert", "scale", "2", convert},
        {"convert", "scale", "2", cameras},
        {"convert", "sh-degree", "0", cameras, true},
        {"convert", "level", "1", convert, true},
        {"convert", "antialiased", "", convert},
        {"convert", "antialiased", "", cameras, true},
        {"render", "cameras", "orbit", images},
        {"render", "background", "1,1,1", images},
        {"render", "depth", "", images},
        {"render", "depth", "", video, true},
        {"render", "antialiased", "", images},
        {"render", "up", "0,1,0", orbit},
        {"render", "up", "0,1,0", images, true},
        {"render", "orbit-views", "6", orbit},
        {"render", "orbit-views", "6", images, true},
        {"render", "metres-per-unit", "2", images, true},
        {"render", "object-height", "2", images, true},
        {"render", "level", "1", images, true},
        {"render", "camera", "view1", images},
        {"render", "camera", "view1", video, true},
        {"render", "camera", "absent", images, true},
        {"render", "clip-fps", "60", video},
        {"render", "clip-fps", "60", images, true},
        {"render", "no-orbit", "", images, true},
        {"render", "frames", "", images, true},
        {"render", "quiet", "", {"render", path("bare"), "--out", "OUT/images"}},  // a scene of which nothing is warned
        {"segment", "up", "0,1,1", segment},
        {"segment", "metres-per-unit", "2", segment},
        {"segment", "object-height", "2", segment},
        {"segment", "orbit-views", "6", segment, true},
        {"segment", "orbit-views", "6", bare},
        {"segment", "level", "1", segment, true},
        {"segment", "antialiased", "", segment},
        {"segment", "seed", "2", segment},
        {"segment", "reconstruct.exposure", "", segment, true},
        {"evaluate images", "assert", "ssim>=2", psnr},
        {"evaluate images", "out", "OUT/scores.json", psnr},
        {"evaluate segmentation", "band", "7", miou},
        {"evaluate segmentation", "match", "overlap", miou},
        {"evaluate segmentation", "common", "", miou},
        {"evaluate segmentation", "band", "7", labels, true},
        {"evaluate segmentation", "common", "", labels, true},
        {"evaluate motion", "free-from", "1", motion},
        {"evaluate motion", "fps", "24", motion, true},
        {"evaluate motion", "from", "1", motion, true},
        {"evaluate motion", "until", "1", motion, true},
        {"evaluate compare", "metric", "ssim", compare},
        {"evaluate compare", "level", "0.6", compare},
        {"evaluate compare", "resamples", "200", compare},
        {"evaluate compare", "out", "OUT", compare},
        {"evaluate calibration", "band", "0.9", bands},
        {"evaluate calibration", "seed", "4", bands},
        {"evaluate slices", "fps", "20", slices},
        {"evaluate slices", "from", "0.4", slices},
        {"evaluate slices", "until", "0.6", slices},
        {"evaluate slices", "row", "1", slices},
        {"evaluate slices", "column", "1", slices},
    };
  }

  TemporaryFolder folder_;
};

/// Options that other tests of this program run: "command option" -> their suite.
const std::map<std::string, std::string> kElsewhere = {
    {"demo no-video", "Demo"},
    {"demo out", "Demo"},
    {"demo overwrite", "Demo"},
    {"run physgaussian", "PhysGaussianConfig"},
    {"run no-video", "FitCommand"},
    {"run overwrite", "FitCommand"},
    {"convert overwrite", "Convert"},
    {"segment overwrite", "SegmentEdit"},
    {"edit merge", "SegmentEdit"},
    {"edit split", "SegmentEdit"},
    {"edit drop", "SegmentEdit"},
    {"edit name", "SegmentEdit"},
    {"fit overwrite", "FitVideo"},
    {"export overwrite", "ExportTest"},
    {"export recorded", "ExportTest"},
    {"export html", "PageExport"},
    {"export html-size", "PageExport"},
    {"export html-license", "PageExport"},
    {"simulate recording", "PageExport"},
    {"view port", "LocalServer"},
    {"view host", "LocalServer"},
    {"view allow-remote", "LocalServer"},
    {"view no-browser", "View"},
    {"view choose", "Choice"},
    {"predict list", "Predict"},
    {"predict preview", "Predict"},
    {"export material", "Predict"},
    {"train-predictor count", "TrainPredictor"},
    {"train-predictor members", "TrainPredictor"},
    {"train-predictor epochs", "TrainPredictor"},
    {"train-predictor add-run", "TrainPredictor"},
    {"train-predictor objects", "TrainPredictor"},
    {"reconstruct overwrite", "Reconstruct"},
    {"motion fps", "EvaluateMotion"},
    {"suite kind", "SuiteSettings"},
    {"suite seeds", "SuiteSettings"},
    {"suite quick", "SuiteSettings"},
    {"suite settings", "SuiteSettings"},
    {"suite workers", "Suite"},
    {"suite cluster", "Suite"},
    {"study answers", "Study"},
    {"study level", "Study"},
    {"study resamples", "Study"},
};

/// Options of every command: of the whole program, and --overwrite and --out, whose ways are those of RunDirectory.
const std::set<std::string> kCommon = {"help", "quiet", "json", "seed", "threads", "config", "out", "overwrite"};

}  // namespace

TEST_F(CommandOptions, EachChangesSomethingOrIsRefused) {
  std::map<Words, std::string> usual;
  for (const Case& c : cases()) {
    if (!usual.count(c.base)) {
      usual[c.base] = trace_of(c.base, folder_ / "out");
      EXPECT_EQ(usual[c.base].substr(0, 7), "exit 0\n") << usual[c.base];
      EXPECT_EQ(trace_of(c.base, folder_ / "out"), usual[c.base]) << "is not the same again";
    }
    Words words = c.base;
    const std::string name = "--" + c.option;
    if (const auto at = std::find(words.begin(), words.end(), name); at != words.end() && !c.value.empty()) {
      at[1] = c.value;
    } else {
      words.push_back(name);
      if (!c.value.empty()) words.push_back(c.value);
    }
    const std::string trace = trace_of(words, folder_ / "out");
    EXPECT_NE(trace, usual[c.base]) << fmt::format("{}", fmt::join(words, " "));
    EXPECT_EQ(trace.starts_with("exit 2\n"), c.refused) << fmt::format("{}", fmt::join(words, " ")) << "\n" << trace;
    EXPECT_TRUE(!c.refused || trace.find(name) != std::string::npos) << trace;
  }
}

TEST_F(CommandOptions, AllOfTheParserAreTried) {
  std::set<std::string> tried, of_stages;
  for (const Case& c : cases()) tried.insert(c.command.substr(c.command.find(' ') + 1) + " " + c.option);
  for (const auto& [option, suite] : kElsewhere) {
    tried.insert(option);
    bool there = false;
    const testing::UnitTest& all = *testing::UnitTest::GetInstance();
    for (int i = 0; i < all.total_test_suite_count(); ++i) there = there || suite == all.GetTestSuite(i)->name();
    EXPECT_TRUE(there) << "there are no tests " << suite;
  }
  for (const OptionTable& table : all_tables())
    for (const Option& option : table.options) of_stages.insert(table.stage + "." + option.name);
  CLI::App app;
  Program program;
  add_commands(app, program);
  int count = 0;
  const std::function<void(const CLI::App&)> walk = [&](const CLI::App& command) {
    for (const CLI::App* sub : command.get_subcommands([](const CLI::App*) { return true; })) walk(*sub);
    if (&command == &app) return;
    for (const CLI::Option* option : command.get_options()) {
      if (option->get_lnames().empty() || kCommon.count(option->get_lnames()[0])) continue;
      ++count;
      bool known = false;
      for (const std::string& name : option->get_lnames()) {
        known = known || of_stages.count(name) || tried.count(command.get_name() + " " + name);
        // Loading a scene is the same everywhere.
        if (name.starts_with("scene.")) known = known || tried.count("segment " + name.substr(6));
        if (command.get_name() != "evaluate") known = known || (name == "assert" && tried.count("images assert"));
      }
      EXPECT_TRUE(known) << "nothing tries " << command.get_name() << " --" << option->get_lnames()[0];
    }
  };
  walk(app);
  RecordProperty("options", count);
  EXPECT_GT(count, 250);
}

}  // namespace pliant
