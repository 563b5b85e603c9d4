// A scene that a run directory can be made from.

#include "app/run/attach_scene.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/run/scene_parts.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/io/splats/splat_file.h"
#include "tests/app/finished_stage.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;

TEST(AttachScene, ANameThatIsNotUtf8IsRefusedAndShownWithoutWhatIsWrong) {
  const TemporaryFolder folder;
  GaussianCloud cloud;
  cloud.resize(20);
  for (int i = 0; i < 20; ++i) cloud.position[i] = Vec3f(0.1f * i, 0, 0.1f * (i % 3));
  const std::string wrong = "caf\xe9", shown = "caf\xef\xbf\xbd";
  const auto splats = [&](const std::string& name) {
    fs::create_directories((folder / name).parent_path());
    write_ply(folder / name, cloud);
    return folder / name;
  };
  const auto attach_to = [&](const fs::path& scene, const std::string& out) {
    RunDirectory run = RunDirectory::create(folder / out);
    Progress progress(true);
    LoadOptions options;
    options.up = Eigen::Vector3d(0, 0, 1);
    attach_scene({progress, [] { return false; }}, run, scene, options);
  };
  const auto expect_refused = [&](const fs::path& scene, const std::string& out = "run") {
    expect_error(Failure::kInput, {shown, "is not UTF-8", "rename"}, [&] { attach_to(scene, out); });
  };
  expect_refused(splats(wrong + ".ply"));
  expect_refused(splats(wrong + "/scene.ply"));
  const fs::path good = splats("caf\xc3\xa9/scene.ply");
  expect_refused(good, wrong + "_run");
  EXPECT_NO_THROW(attach_to(good, "run"));

  splats("photos/splats.ply");
  const fs::path scene =
      folder.file("photos/scene.json", R"({"splats": "splats.ply", "cameras": "sparse"})").parent_path();
  folder.file("photos/sparse/cameras.txt", "1 PINHOLE 64 48 60 60 32 24\n");
  folder.file("photos/sparse/images.txt", "1 1 0 0 0 0 0 2 1 " + wrong + ".png\n\n");
  expect_refused(scene, "other_run");
}

/// A 3DGS model folder whose cameras look down by 30 degrees from one side, z up.
void write_model(const fs::path& folder) {
  GaussianCloud cloud;
  cloud.resize(200);
  for (int i = 0; i < 200; ++i) cloud.position[i] = Vec3f(0.1f * (i % 10), 0.02f * (i / 10), 0.1f * (i % 3));
  write_ply(folder / "point_cloud/iteration_7/point_cloud.ply", cloud);
  std::vector<Camera> cameras;
  for (int i = 0; i < 9; ++i) {
    const double a = 0.15 * i;
    cameras.push_back(look_at({4 * std::cos(a), 4 * std::sin(a), 2.3}, {0, 0, 0}, {0, 0, 1}, 40, 30, 30));
    cameras.back().name = std::to_string(i);
  }
  write_cameras(folder / "cameras.json", cameras);
}

TEST(AttachScene, LoadsTheSceneAsLaterStagesDoHoweverItsPathIsWritten) {
  const TemporaryFolder folder;
  const fs::path before = fs::current_path(), splats = folder / "model/point_cloud/iteration_7";
  write_model(folder / "model");
  fs::create_directories(folder / "links");
  fs::create_symlink(splats / "point_cloud.ply", folder / "links/point_cloud.ply");
  Progress progress(true);
  for (const auto& [from, name] : {std::pair<fs::path, std::string>{folder.path(), splats / "point_cloud.ply"},
                                   {splats, "point_cloud.ply"},
                                   {folder / "links", "point_cloud.ply"}}) {
    fs::current_path(from);
    RunDirectory run = RunDirectory::create(folder / ("run_" + from.filename().string()));
    EXPECT_EQ(attach_scene({progress, [] { return false; }}, run, name, {}).cameras.size(), 9u) << from;
    EXPECT_EQ(load_run_scene(run).cameras.size(), 9u) << from;
  }
  fs::current_path(before);
}

/// Attaches a scene as a command does.
Scene attach(RunDirectory& run, const fs::path& source, const LoadOptions& options = {}, bool overwrite = false) {
  Progress progress(true);
  Context context{progress, [] { return false; }};
  context.overwrite = overwrite;
  return attach_scene(context, run, source, options);
}

/// A run of the scene in which `segment` is done.
RunDirectory segmented_run(const fs::path& path, const fs::path& source, const LoadOptions& options = {}) {
  nlohmann::json manifest;
  {
    RunDirectory run = RunDirectory::create(path);
    StageKey key;
    key.inputs = record_of({ScenePart::kSplats}, attach(run, source, options)).files;
    manifest = run.manifest();
    manifest["stages"]["segment"] = finished_stage(nlohmann::json::object());
    manifest["stages"]["segment"]["inputs"] = record_of(key, 1)["inputs"];
  }
  write_text(path / "run.json", manifest.dump());
  return RunDirectory::open(path);
}

TEST(AttachScene, ASceneThatHasMovedIsTheSameAndAnotherIsNot) {
  const TemporaryFolder folder;
  write_model(folder / "model");
  LoadOptions options;
  options.up = Eigen::Vector3d(0, 0.6, 0.8);
  RunDirectory run = segmented_run(folder / "run", folder / "model", options);
  run.set_note("assumed_height", 0.3);
  fs::copy(folder / "model", folder / "copy", fs::copy_options::recursive);
  EXPECT_FALSE(is_recorded_scene(run, folder / "copy"));
  attach(run, folder / "copy", recorded_options(run));
  EXPECT_EQ(recorded_place(run), fs::weakly_canonical(folder / "copy"));
  EXPECT_EQ(load_run_scene(run).up, *options.up);
  EXPECT_EQ(run.note("assumed_height"), 0.3);

  fs::rename(folder / "copy", folder / "moved");
  expect_error(Failure::kInput, {"copy", "does not exist", "pliant run NEWSCENE --out " + (folder / "run").string()},
               [&] { load_run_scene(run); });
  attach(run, folder / "moved", options);
  EXPECT_EQ(load_run_scene(run).cameras.size(), 9u);

  GaussianCloud cloud = read_ply(folder / "model/point_cloud/iteration_7/point_cloud.ply");
  cloud.position[5].x() += 0.01f;
  write_ply(folder / "model/point_cloud/iteration_7/point_cloud.ply", cloud);
  expect_error(Failure::kUsage, {"moved", "model", "--overwrite"}, [&] { attach(run, folder / "model", options); });
  EXPECT_NO_THROW(attach(run, folder / "model", options, true));
}

TEST(AttachScene, ASceneWhoseSingleFileIsRenamedIsTheSameAndItsStagesStay) {
  const TemporaryFolder folder;
  GaussianCloud cloud;
  cloud.resize(20);
  for (int i = 0; i < 20; ++i) cloud.position[i] = Vec3f(0.1f * i, 0, 0.1f * (i % 3));
  write_ply(folder / "flower.ply", cloud);
  const std::string hash = sha256_of_file(folder / "flower.ply");
  LoadOptions options;
  options.up = Eigen::Vector3d(0, 0, 1);
  segmented_run(folder / "run", folder / "flower.ply", options);
  fs::rename(folder / "flower.ply", folder / "rose.ply");
  // Records of earlier versions hold the name.
  nlohmann::json named = nlohmann::json::parse(read_text(folder / "run/run.json"));
  EXPECT_EQ(named["stages"]["segment"]["inputs"], nlohmann::json({{"splats", hash}}));
  named["stages"]["segment"]["inputs"] = {{"splats flower.ply", hash}};
  folder.file("earlier/run.json", named.dump());
  for (const char* name : {"run", "earlier"}) {
    RunDirectory run = RunDirectory::open(folder / name);
    StageKey key;
    key.inputs = record_of({ScenePart::kSplats}, attach(run, folder / "rose.ply", options)).files;
    EXPECT_EQ(recorded_place(run), fs::weakly_canonical(folder / "rose.ply")) << name;
    EXPECT_EQ(run.manifest()["stages"]["segment"]["inputs"], record_of(key, 1)["inputs"]) << name;
  }
}

TEST(AttachScene, ATrainedSceneInARunDirectoryMovesWithIt) {
  const TemporaryFolder folder;
  const fs::path before = folder / "a/run";
  {
    RunDirectory run = RunDirectory::create(before);
    write_model(before / "scene");
    write_text(before / "scene/scene.json",
               R"({"splats": "point_cloud/iteration_7/point_cloud.ply", "cameras": "cameras.json"})");
    attach(run, before / "scene");
    EXPECT_EQ(run.scene()["source"], "scene");
  }
  const std::string relative = read_text(before / "run.json");
  nlohmann::json full = nlohmann::json::parse(relative);
  full["scene"]["source"] = fs::weakly_canonical(before / "scene").string();
  const auto expect_own = [&](const fs::path& path) {
    for (const std::string& record : {relative, full.dump()}) {
      write_text(path / "run.json", record);
      RunDirectory run = RunDirectory::open(path);
      EXPECT_EQ(load_run_scene(run).source, fs::weakly_canonical(path / "scene")) << record;
      EXPECT_EQ(attach(run, path / "scene").cameras.size(), 9u);
      EXPECT_EQ(run.scene()["source"], "scene");
    }
  };
  expect_own(before);
  fs::copy(folder / "a", folder / "copy", fs::copy_options::recursive);
  expect_own(folder / "copy/run");
  fs::rename(folder / "a", folder / "b");
  expect_own(folder / "b/run");
}

TEST(AttachScene, ALinkToSplatsStaysALinkBesideWhichTheCamerasLie) {
  const TemporaryFolder folder;
  write_model(folder / "model");
  const fs::path splats = folder / "model/point_cloud/iteration_7/point_cloud.ply";
  fs::create_directories(folder / "data");
  fs::rename(splats, folder / "data/0123abcd");
  fs::create_symlink("../data/0123abcd", folder / "model/flower.ply");
  RunDirectory run = RunDirectory::create(folder / "run");
  EXPECT_EQ(attach(run, folder / "model/flower.ply").cameras.size(), 9u);
  EXPECT_EQ(load_run_scene(run).source.filename(), "flower.ply");
  EXPECT_TRUE(is_recorded_scene(run, folder / "model/flower.ply"));

  // A name without an extension tells nothing of these.
  write_splat(folder / "model/flower.splat", read_ply(folder / "data/0123abcd"));
  fs::rename(folder / "model/flower.splat", folder / "data/4567cdef");
  fs::create_symlink("../data/4567cdef", folder / "model/flower.splat");
  RunDirectory other = RunDirectory::create(folder / "other");
  EXPECT_EQ(attach(other, folder / "model/flower.splat").cloud.size(), 200u);

  // A run that reads the file itself goes on so, unless it is started over.
  RunDirectory earlier = RunDirectory::create(folder / "earlier");
  attach(earlier, folder / "data/0123abcd");
  EXPECT_TRUE(attach(earlier, folder / "model/flower.ply").cameras_are_orbit);
  EXPECT_EQ(recorded_place(earlier).filename(), "0123abcd");
  EXPECT_EQ(attach(earlier, folder / "model/flower.ply", {}, true).cameras.size(), 9u);
  EXPECT_EQ(recorded_place(earlier).filename(), "flower.ply");
}

TEST(AttachScene, OfAnUnknownScaleOneSentenceIsSaidWhereNoHeightOfThisObjectIsAssumed) {
  const TemporaryFolder folder;
  write_model(folder / "model");
  const auto extract = [&](const std::string& object) {
    fs::create_directories(folder / ("run/objects/" + object));
    nlohmann::json manifest = {
        {"scene", {{"source", (folder / "model").string()}}},
        {"stages", {{"extract", finished_stage({{"folder", "objects/" + object}, {"height", 0.4}})}}}};
    if (fs::exists(folder / "run/run.json"))
      manifest["assumed_height"] = RunDirectory::open(folder / "run").note("assumed_height");
    folder.file("run/run.json", manifest.dump());
  };
  // Sentences about the scale, and metres per unit.
  const auto said = [&](const LoadOptions& options = {}) {
    RunDirectory run = RunDirectory::open(folder / "run");
    int sentences = 0;
    Progress progress(true);
    progress.listen([&](const ProgressEvent& event) {
      for (const char* word : {"scale", "length of a unit"}) sentences += event.text.find(word) != std::string::npos;
    });
    const Scene scene = attach_scene({progress, [] { return false; }}, run, folder / "model", options);
    EXPECT_EQ(load_run_scene(run).metres_per_unit, scene.metres_per_unit);
    return std::pair(sentences, scene.metres_per_unit);
  };
  extract("1_palm");
  EXPECT_EQ(said(), std::pair(1, 1.0));
  {
    RunDirectory run = RunDirectory::open(folder / "run");
    record_assumed_height(run, 1.2);
  }
  EXPECT_EQ(said(), std::pair(0, 1.2 / 0.4));
  extract("2_vase");
  EXPECT_EQ(said(), std::pair(1, 1.0)) << "the height is that of the palm";
  extract("1_palm");
  EXPECT_EQ(said(), std::pair(0, 1.2 / 0.4));
  // Another name of the same object.
  fs::remove(folder / "run/objects/1_palm");
  extract("1_plant");
  EXPECT_EQ(said(), std::pair(0, 1.2 / 0.4));
  LoadOptions options;
  options.metres_per_unit = 2;
  EXPECT_EQ(said(options), std::pair(0, 2.0));
  EXPECT_EQ(said(), std::pair(1, 1.0)) << "what the user says of the scale ends what was assumed";
}

TEST(AttachScene, ARunKeepsThatItsSceneIsAntialiased) {
  const TemporaryFolder folder;
  write_model(folder / "model");
  Progress progress(true);
  for (const bool antialiased : {false, true}) {
    RunDirectory run = RunDirectory::create(folder / (antialiased ? "mip_run" : "run"));
    LoadOptions options;
    options.antialiased = antialiased;
    EXPECT_EQ(attach_scene({progress, [] { return false; }}, run, folder / "model", options).report.antialiased,
              antialiased);
    EXPECT_EQ(load_run_scene(run).report.antialiased, antialiased);
  }
}

TEST(AttachScene, ARunThatWasMadeWithTheMeanUpOfItsCamerasKeepsIt) {
  const TemporaryFolder folder;
  write_model(folder / "model");
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Camera& camera : read_cameras(folder / "model/cameras.json").cameras)
    mean -= camera.cam_from_world.linear().row(1).transpose();
  mean.normalize();
  EXPECT_GT(std::acos(mean.z()), 0.2);
  const auto up_of_run = [&](const Eigen::Vector3d& recorded, bool overwrite) {
    nlohmann::json segment = finished_stage(nlohmann::json::object());
    segment["scene"]["up"] = {recorded.x(), recorded.y(), recorded.z()};
    const nlohmann::json manifest = {{"scene", {{"source", (folder / "model").string()}}},
                                     {"stages", {{"segment", segment}}}};
    folder.file("run/run.json", manifest.dump());
    RunDirectory run = RunDirectory::open(folder / "run");
    Progress progress(true);
    Context context{progress, [] { return false; }};
    context.overwrite = overwrite;
    const Eigen::Vector3d later = load_run_scene(run).up, found = attach_scene(context, run, folder / "model", {}).up;
    EXPECT_TRUE(overwrite || later == found);
    return found;
  };
  EXPECT_EQ(up_of_run(mean, false), mean);
  EXPECT_GT(up_of_run(mean, true).z(), 1 - 1e-9);
  EXPECT_GT(up_of_run({0, 1, 0}, false).z(), 1 - 1e-9) << "given by an option that has been left out since";
}

}  // namespace
}  // namespace pliant
