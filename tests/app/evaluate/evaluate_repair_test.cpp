// What the demo tells about the space behind its flower, and the score of a repair that uses or ignores it.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/demo/kinds/flower.h"
#include "app/demo/make_demo.h"
#include "app/demo/splats.h"
#include "app/demo/truth.h"
#include "app/evaluate/evaluate.h"
#include "gaussians/base/error.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "tests/temporary_folder.h"

using nlohmann::json;

namespace pliant {
namespace {

DemoOptions small(const std::filesystem::path& out) {
  DemoOptions options;
  options.out = out;
  options.width = 120;
  options.height = 90;
  options.photos = 6;
  options.gaussians = 12000;
  options.video = false;
  return options;
}

TEST(HiddenTruth, CoversTheFlowerAndAgreesWithThePhotosBesideIt) {
  const TemporaryFolder folder;
  const std::filesystem::path scene = folder / "demo";
  make_demo(small(scene));
  size_t never = 0, elsewhere = 0;
  for (const Camera& camera : read_cameras(cameras_in(scene), scene / "photos").cameras) {
    const IdImage masks = read_ids(scene / "masks" / (camera.name + ".png"));
    const IdImage hidden = read_ids(scene / "truth/hidden" / (camera.name + ".png"));
    const ImageF photo = read_image(camera.photo),
                 bare = read_image(scene / "truth/without_object" / (camera.name + ".png"));
    for (int y = 0; y < masks.height; ++y)
      for (int x = 0; x < masks.width; ++x) {
        ASSERT_EQ(masks(x, y) == kObjectId, hidden(x, y) != kInPlainView);
        never += hidden(x, y) == kNeverSeen;
        elsewhere += hidden(x, y) == kSeenElsewhere;
        bool near = false;
        for (int j = std::max(0, y - 1); j <= std::min(masks.height - 1, y + 1); ++j)
          for (int i = std::max(0, x - 1); i <= std::min(masks.width - 1, x + 1); ++i)
            near = near || masks(i, j) == kObjectId;
        if (!near) {
          ASSERT_EQ(photo(x, y, 1), bare(x, y, 1)) << x << ' ' << y;
        }
      }
  }
  EXPECT_GT(never, 100u);
  EXPECT_GT(elsewhere, never);
}

TEST(EvaluateRepair, TheTrueBackgroundBeatsAHoleAndInpaintingOfEveryViewAlone) {
  const TemporaryFolder folder;
  const std::filesystem::path scene = folder / "demo", run = folder / "run";
  const DemoOptions options = small(scene);
  make_demo(options);
  std::filesystem::create_directories(run);
  const Flower flower = make_flower(options.seed);
  const Stage stage(flower.object, options.seed);
  const std::vector<Camera> cameras = stage_cameras(stage, options.photos, options.width, options.height);
  const StageSplats splats = make_splats(stage, cameras, options.gaussians, options.seed);
  std::vector<int> rest;
  for (size_t p = 0; p < splats.label.size(); ++p)
    if (splats.label[p] != kObjectId) rest.push_back(static_cast<int>(p));
  const GaussianCloud background = splats.cloud.select(rest);
  write_ply(run / "background.ply", background);
  write_ply(run / "background_repaired.ply", background);
  const json unrepaired = evaluate_repair(run, scene);
  EXPECT_EQ(unrepaired["psnr"], unrepaired["psnr_before"]);
  EXPECT_TRUE(unrepaired["outside"]["identical"].get<bool>());
  EXPECT_TRUE(assert_metrics(unrepaired, {"outside.psnr>=50"}).empty());
  EXPECT_FALSE(assert_metrics(unrepaired, {"gain_over_opencv>=0"}).empty());

  // Only what is under the pot is added from the true background.
  const StageSplats whole = make_splats(stage.without(kObjectId), cameras, options.gaussians, options.seed);
  const Vec3f foot = stage.world_from_object().translation().cast<float>();
  std::vector<int> below;
  for (size_t p = 0; p < whole.label.size(); ++p)
    if (whole.label[p] == kTableId && (whole.surface[p] - foot).head<2>().norm() < flower.pot_radius)
      below.push_back(static_cast<int>(p));
  GaussianCloud repaired = background;
  repaired.append(whole.cloud.select(below));
  write_ply(run / "background_repaired.ply", repaired);
  const json out = evaluate_repair(run, scene);
  EXPECT_TRUE(
      assert_metrics(out, {"psnr>=26", "gain_over_opencv>=3", "consistency_psnr>=26", "outside.psnr>=40", "pixels>100"})
          .empty())
      << out.dump(1);
  EXPECT_GT(out["psnr"].get<double>(), unrepaired["psnr"].get<double>() + 10);
}

TEST(EvaluateRepair, NeedsTheTruthOfADemoScene) {
  const TemporaryFolder folder;
  EXPECT_THROW(evaluate_repair(folder / "run", folder / "scene"), Error);
}

TEST(EvaluateRepair, ARunOfAnotherSceneIsRefusedButNotOneOfACopy) {
  const TemporaryFolder folder;
  for (const char* name : {"truth/without_object", "truth/hidden"})
    std::filesystem::create_directories(folder / "scene" / name);
  write_image(folder / "scene/photos/a.png", ImageF(4, 3, 3, 0.2f));
  write_image(folder / "other/photos/a.png", ImageF(4, 3, 3, 0.4f));
  std::filesystem::copy(folder / "scene", folder / "copy", std::filesystem::copy_options::recursive);
  const auto made_from = [&](const std::string& name) {
    folder.file("run/run.json", json{{"scene", {{"source", (folder / name).string()}}}}.dump());
    return folder / "run";
  };
  expect_error(Failure::kInput, {"run.json", "scene.source", "other"},
               [&] { evaluate_repair(made_from("other"), folder / "scene"); });
  for (const char* same : {"scene", "copy", "gone"})
    expect_error(Failure::kInput, {"background.ply"}, [&] { evaluate_repair(made_from(same), folder / "scene"); });
}

}  // namespace
}  // namespace pliant
