// A scene that a run directory can be made from.

#include "app/run/attach_scene.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/splats/ply.h"
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
  const auto attach = [&](const fs::path& scene, const std::string& out) {
    RunDirectory run = RunDirectory::create(folder / out);
    Progress progress(true);
    LoadOptions options;
    options.up = Eigen::Vector3d(0, 0, 1);
    attach_scene({progress, [] { return false; }}, run, scene, options);
  };
  const auto expect_refused = [&](const fs::path& scene, const std::string& out = "run") {
    expect_error(Failure::kInput, {shown, "is not UTF-8", "rename"}, [&] { attach(scene, out); });
  };
  expect_refused(splats(wrong + ".ply"));
  expect_refused(splats(wrong + "/scene.ply"));
  const fs::path good = splats("caf\xc3\xa9/scene.ply");
  expect_refused(good, wrong + "_run");
  EXPECT_NO_THROW(attach(good, "run"));

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
