// A scene that a run directory can be made from.

#include "app/run/attach_scene.h"

#include <gtest/gtest.h>

#include "gaussians/io/splats/ply.h"
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

}  // namespace
}  // namespace pliant
