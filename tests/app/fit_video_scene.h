#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/fit/fit_video.h"
#include "app/run/attach_scene.h"
#include "fitting/observe/frame_source.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/video.h"
#include "tests/app/prepared_folder.h"
#include "tests/app/run_pliant.h"
#include "tests/app/small_demo.h"

namespace pliant {

/// A run of a small demo scene up to `seed`, with its reference video, for tests of the fit by the command's way.
class FitVideo : public ::testing::Test {
 protected:
  using Path = std::filesystem::path;

  /// Fills a folder with the scene and its run.
  static void prepare(const Path& out) {
    make_demo(small_demo(out / "scene"));
    std::filesystem::remove_all(out / "scene/truth");
    const std::string run = (out / "run").string();
    ASSERT_EQ(run_quietly({"segment", (out / "scene").string(), "--out", run, "--iterations", "60"}), 0);
    ASSERT_EQ(run_quietly({"extract", run}), 0);
    ASSERT_EQ(run_quietly({"repair", run}), 0);
    ASSERT_EQ(run_quietly({"seed", run, "--particles", "600"}), 0);
  }
  static Path prepared_scene() { return prepared_once("fit_video_scene", prepare); }

  static void SetUpTestSuite() { use_copy_of(prepared_scene()); }
  static void use_copy_of(const Path& prepared) {
    folder = std::filesystem::temp_directory_path() / ("pliant_fit_video_" + std::to_string(getpid()));
    copy_prepared(prepared, folder);
    const nlohmann::json video = nlohmann::json::parse(read_text(folder / "scene/scene.json"))["video"];
    file = folder / "scene" / video["file"].get<std::string>();
    camera = video["camera"].get<std::string>();
    const auto source = open_frames(file, 0);
    fps = source->fps();
    while (auto frame = source->next()) frames.push_back(frame->picture);
  }
  static void TearDownTestSuite() {
    std::filesystem::remove_all(folder);
    frames.clear();
  }

  static std::string write(const std::string& name, const std::vector<ImageF>& pictures) {
    VideoWriter writer(folder / name, fps, pictures[0].width, pictures[0].height);
    for (const ImageF& picture : pictures) writer.write(picture);
    writer.close();
    return (folder / name).string();
  }
  static std::vector<std::string> fit(std::vector<std::string> more) {
    more.insert(more.begin(), {"fit", (folder / "run").string(), "--overwrite"});
    return more;
  }
  /// The command ends with 1 and says these words.
  static void expect_refused(std::vector<std::string> more, const std::vector<std::string>& words) {
    std::filesystem::remove(folder / "run/fit/results.json");
    ::testing::internal::CaptureStderr();
    const int code = run_quietly(fit(std::move(more)));
    const std::string said = ::testing::internal::GetCapturedStderr();
    EXPECT_EQ(code, 1) << said;
    for (const std::string& word : words)
      EXPECT_NE(said.find(word), std::string::npos) << "'" << word << "' in: " << said;
    EXPECT_FALSE(std::filesystem::exists(folder / "run/fit/results.json"));
  }
  static ReferenceVideo load(const FitStage& stage) {
    Progress progress(true);
    const Context context{progress, [] { return false; }};
    const RunDirectory run = RunDirectory::open(folder / "run");
    return load_fit_video(context, run, inputs_of(run, load_run_scene(run), stage), stage);
  }

  static inline Path folder, file;
  static inline std::string camera;
  static inline double fps = 0;
  static inline std::vector<ImageF> frames;
};

}  // namespace pliant
