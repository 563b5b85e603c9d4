// Labels that are trained along with a scene: from photos, and from splats of which a level of detail may be chosen.

#include <nlohmann/json.hpp>

#include "app/reconstruct/reconstruct_stage.h"
#include "app/store/segmentation.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/render/render.h"
#include "tests/app/reconstruct/made_photos.h"
#include "tests/gaussians/sog_files.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Which side of the plane z = 0 most of what a pixel shows lies on; 0 where nothing is.
void make_masks(const fs::path& folder) {
  const GaussianCloud cloud = made_cloud();
  std::vector<float> side(2 * cloud.size(), 0.0f);
  for (size_t i = 0; i < cloud.size(); ++i) side[2 * i + (cloud.position[i].z() > 0)] = 1;
  for (const Camera& camera : read_transforms(folder / "transforms.json").cameras) {
    const RenderResult picture = render(cloud, camera, {}, side, 2);
    IdImage ids(camera.width, camera.height, 1, 0);
    for (size_t k = 0; k < ids.data.size(); ++k)
      if (picture.alpha.data[k] > 0.5f)
        ids.data[k] = picture.features.data[2 * k] > picture.features.data[2 * k + 1] ? 3 : 8;
    fs::create_directories(folder / "masks");
    write_ids(folder / "masks" / (camera.name + ".png"), ids);
  }
}

TEST_F(Reconstruct, LabelsTrainedAlongWithTheSceneDivideItsGaussians) {
  const TemporaryFolder folder;
  make_photos(folder / "set");
  make_masks(folder / "set");
  write_json(folder / "set/masks/labels.json", {{"3", "below"}, {"8", "above"}});
  const std::vector<std::string> segment = {"segment",
                                            (folder / "set").string(),
                                            "--joint",
                                            "--masks",
                                            (folder / "set/masks").string(),
                                            "--reconstruct.init",
                                            "random",
                                            "--reconstruct.max-gaussians",
                                            "1k",
                                            "--reconstruct.sh-degree",
                                            "0",
                                            "--reconstruct.iterations",
                                            "400",
                                            "--out",
                                            (folder / "run").string()};
  ASSERT_EQ(run_quietly(segment), 0);
  const Segmentation segmentation = read_segmentation(folder / "run/segmentation.h5");
  const Scene scene = load_scene(folder / "run/scene");
  ASSERT_EQ(segmentation.label.size(), scene.cloud.size());
  EXPECT_EQ(segmentation.class_name, (std::vector<std::string>{"below", "above"}));
  double right = 0, all = 0;
  for (size_t i = 0; i < scene.cloud.size(); ++i) {
    const Vec3f& x = scene.cloud.position[i];
    if (x.norm() > 0.5f || std::abs(x.z()) < 0.1f) continue;
    const double opacity = sigmoid(scene.cloud.opacity_logit[i]);
    all += opacity;
    right += opacity * (segmentation.label[i] == (x.z() > 0 ? 8u : 3u));
  }
  EXPECT_GT(right / all, 0.93);
  EXPECT_EQ(read_json(folder / "run/objects.json").size(), 2u);
  ASSERT_EQ(run_quietly(segment), 0) << "what is done is not done again";

  // A scene that is trained already keeps its Gaussians and how they are drawn.
  write_ply(scene.settings.splats, scene.cloud, true);
  ASSERT_EQ(run_quietly({"segment", (folder / "run/scene").string(), "--joint", "--masks",
                         (folder / "set/masks").string(), "--reconstruct.iterations", "20", "--reconstruct.sh-degree",
                         "0", "--out", (folder / "again").string()}),
            0);
  const Scene again = load_scene(folder / "again/scene");
  EXPECT_EQ(again.cloud.size(), scene.cloud.size());
  EXPECT_TRUE(again.report.antialiased);
  EXPECT_EQ(run_quietly({"segment", (folder / "set").string(), "--joint", "--reconstruct.iterations", "5", "--out",
                         (folder / "none").string()}),
            2)
      << "no masks";
  // The cameras of splats are found from their file and from its folder.
  const fs::path file = scene.settings.splats;
  for (const fs::path& splats : {file, file.parent_path()}) {
    const fs::path out = folder / ("of_" + splats.filename().string());
    ASSERT_EQ(run_quietly({"segment", splats.string(), "--joint", "--masks", (folder / "set/masks").string(),
                           "--reconstruct.iterations", "20", "--reconstruct.sh-degree", "0", "--out", out.string()}),
              0);
    EXPECT_EQ(read_segmentation(out / "segmentation.h5").label.size(), scene.cloud.size());
    EXPECT_EQ(load_scene(out / "scene").cameras.size(), scene.cameras.size());
  }
  // The splats' degree is kept, so that a lower one would do nothing.
  const fs::path lit = folder / "run/scene/lit.ply";
  write_ply(lit, with_sh_degree(scene.cloud, 1));
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_quietly({"segment", lit.string(), "--joint", "--masks", (folder / "set/masks").string(),
                         "--reconstruct.iterations", "5", "--reconstruct.sh-degree", "0", "--out",
                         (folder / "lower").string()}),
            2);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("below that of the splats, 1"), std::string::npos) << said;
  // What excludes joint training is said before it.
  for (const std::vector<std::string>& excluded :
       std::vector<std::vector<std::string>>{{"--click", "v12,40,30"}, {"--auto"}, {"--gaussian-grouping", "model"}}) {
    std::vector<std::string> words = segment;
    words.back() = (folder / "excluded").string();
    words.insert(words.end(), excluded.begin(), excluded.end());
    EXPECT_EQ(run_quietly(words), 2) << excluded[0];
    EXPECT_FALSE(fs::exists(folder / "excluded/scene")) << excluded[0];
  }
  // ID 0 may be an object of its own.
  std::vector<std::string> zero = segment;
  zero.back() = (folder / "zero").string();
  std::replace(zero.begin(), zero.end(), std::string("400"), std::string("20"));
  zero.insert(zero.end(), {"--mask-zero", "background"});
  ASSERT_EQ(run_quietly(zero), 0);
  EXPECT_EQ(read_segmentation(folder / "zero/scene/segmentation.h5").class_name,
            (std::vector<std::string>{"below", "above", "background"}));
}

/// The made cloud as level 0 of a streamed SOG, its first 60 Gaussians as level 1, and an environment that is not
/// there.
void make_levels(const fs::path& folder) {
  json meta = {{"lodLevels", 2}, {"tree", {{"children", json::array()}}}, {"environment", "env/meta.json"}};
  for (const int level : {0, 1}) {
    GaussianCloud cloud = made_cloud();
    if (level == 1) cloud.resize(60);
    const std::string name = std::to_string(level) + "_0";
    for (const auto& [file, bytes] : sog_files(cloud)) write_text(folder / name / file, bytes);
    meta["filenames"].push_back(name + "/meta.json");
    meta["tree"]["children"].push_back(
        {{"lods", {{std::to_string(level), {{"file", level}, {"offset", 0}, {"count", cloud.size()}}}}}});
  }
  write_json(folder / "lod-meta.json", meta);
}

TEST_F(Reconstruct, JointTrainingGoesOnFromTheLevelOfDetailThatIsChosen) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 8);
  make_masks(folder / "set");
  make_levels(folder / "set/lod");
  write_json(
      folder / "set/scene.json",
      {{"splats", "lod/lod-meta.json"}, {"cameras", "transforms.json"}, {"photos", "photos"}, {"masks", "masks"}});
  const auto segment = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"segment",
                                      (folder / "set").string(),
                                      "--joint",
                                      "--reconstruct.iterations",
                                      "20",
                                      "--reconstruct.sh-degree",
                                      "0",
                                      "--out",
                                      (folder / "run").string()};
    words.insert(words.end(), more.begin(), more.end());
    return run_quietly(words);
  };
  const auto gaussians = [&] { return load_scene(folder / "run/scene").cloud.size(); };
  ASSERT_EQ(segment({"--level", "1"}), 0);
  EXPECT_EQ(gaussians(), 60u);
  EXPECT_EQ(read_segmentation(folder / "run/segmentation.h5").label.size(), 60u);
  const std::string record = read_text(folder / "run/scene/run.json");
  ASSERT_EQ(segment({"--level", "1"}), 0);
  EXPECT_EQ(read_text(folder / "run/scene/run.json"), record) << "what is done is not done again";

  // What was met in the splats is said, and kept with the results.
  const json results = read_json(folder / "run/scene/results.json");
  for (const json& warnings : {results["warnings"], results["start"]["warnings"]})
    EXPECT_NE(warnings.dump().find("env/meta.json does not exist"), std::string::npos) << warnings;

  ASSERT_EQ(segment({}), 0);
  EXPECT_EQ(gaussians(), 150u) << "the finest level";
  EXPECT_EQ(segment({"--level", "2"}), 1) << "is not there";
  EXPECT_EQ(segment({"--orbit-views", "9"}), 2) << "the scene has cameras";
  EXPECT_EQ(gaussians(), 150u);
}

TEST_F(Reconstruct, ALevelOfDetailOfSplatsThatAreYetToBeTrainedIsRefusedBeforeTheTraining) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 4);
  const std::string photos = (folder / "set").string(), out = (folder / "run").string();
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"segment", photos, "--level", "1", "--out", out},
           {"segment", photos, "--level", "all", "--joint", "--masks", photos, "--out", out},
           {"run", photos, "--scene.level", "0", "--out", out}}) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_quietly(words), 2);
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find("level"), std::string::npos) << said;
    EXPECT_NE(said.find("the scene has no splats yet"), std::string::npos) << said;
    EXPECT_FALSE(fs::exists(folder / "run/scene"));
  }
}

}  // namespace
}  // namespace pliant
