#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/fit/fit_video.h"
#include "app/run/attach_scene.h"
#include "fitting/observe/frame_source.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/video.h"
#include "tests/app/run_pliant.h"
#include "tests/app/small_demo.h"

namespace pliant {

/// A run of a small demo scene up to `seed`, with its reference video, for tests of the fit by the command's way.
class FitVideo : public ::testing::Test {
 protected:
  using Path = std::filesystem::path;

  static void prepare(const Path& prepared) {
    std::filesystem::remove_all(prepared.parent_path());
    const Path partial = prepared.parent_path().string() + "_partial";
    std::filesystem::remove_all(partial);
    make_demo(small_demo(partial / "scene"));
    std::filesystem::remove_all(partial / "scene/truth");
    const std::string out = (partial / "run").string();
    ASSERT_EQ(run_quietly({"segment", (partial / "scene").string(), "--out", out, "--iterations", "60"}), 0);
    ASSERT_EQ(run_quietly({"extract", out}), 0);
    ASSERT_EQ(run_quietly({"repair", out}), 0);
    ASSERT_EQ(run_quietly({"seed", out, "--particles", "600"}), 0);
    write_text(partial / "place", partial.string());
    std::filesystem::create_directories(prepared.parent_path());
    std::filesystem::rename(partial, prepared);
  }

  /// Where that is, once for all tests of this build of the program: a test that comes while another prepares it waits.
  static Path prepared_scene() {
    const Path program = std::filesystem::read_symlink("/proc/self/exe");
    const Path all = program.parent_path() / "fit_video_scene";
    const Path prepared = all / std::to_string(std::filesystem::last_write_time(program).time_since_epoch().count());
    const int lock = open((all.string() + ".lock").c_str(), O_CREAT | O_RDWR, 0644);
    flock(lock, LOCK_EX);
    if (!std::filesystem::exists(prepared)) prepare(prepared);
    close(lock);
    return prepared;
  }

  static void SetUpTestSuite() {
    const Path prepared = prepared_scene();
    folder = std::filesystem::temp_directory_path() / ("pliant_fit_video_" + std::to_string(getpid()));
    std::filesystem::remove_all(folder);
    std::filesystem::copy(prepared, folder, std::filesystem::copy_options::recursive);
    // The run directory names the scene that it was made from.
    std::string run = read_text(folder / "run/run.json");
    const std::string from = read_text(prepared / "place");
    for (size_t at = run.find(from); at != std::string::npos; at = run.find(from, at))
      run.replace(at, from.size(), folder.string());
    write_text(folder / "run/run.json", run);
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
