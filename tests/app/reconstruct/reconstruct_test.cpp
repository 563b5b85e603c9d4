// From photos to a scene: a made scene is found again from its pictures, an interrupted training ends with the same
// bits, the source's scene.json lives on, budgets hold, and what cannot be done is said.

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "app/reconstruct/photo_set.h"
#include "app/reconstruct/reconstruct_stage.h"
#include "app/reconstruct/training_masks.h"
#include "app/store/lenses.h"
#include "app/store/segmentation.h"
#include "gaussians/base/random.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/photo.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/render/render.h"
#include "tests/app/run_pliant.h"
#include "tests/gaussians/photo_files.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Pictures this small are not worth more than one thread.
class Reconstruct : public ::testing::Test {
 protected:
  Reconstruct() : threads_(omp_get_max_threads()) { omp_set_num_threads(1); }
  ~Reconstruct() override { omp_set_num_threads(threads_); }

 private:
  int threads_;
};

constexpr int kWidth = 80, kHeight = 60;

/// Blobs of many colours in a ball of radius 0.5.
GaussianCloud made_cloud() {
  GaussianCloud cloud;
  cloud.resize(150);
  for (size_t i = 0; i < cloud.size(); ++i) {
    Random random(5, i);
    const Vec3d direction(random.normal(), random.normal(), random.normal());
    cloud.position[i] = (0.5 * std::cbrt(random.uniform()) * direction.normalized()).cast<float>();
    cloud.log_scale[i].setConstant(std::log(0.07f));
    cloud.opacity_logit[i] = 2;
    for (int c = 0; c < 3; ++c) cloud.sh_of(i)[c] = static_cast<float>(random.uniform(-1.5, 1.5));
  }
  return cloud;
}

/// Photos of the made cloud from all around: transforms.json and photos/.
void make_photos(const fs::path& folder, int count = 16) {
  const GaussianCloud cloud = made_cloud();
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count, height = 0.6 * std::sin(3 * angle);
    Camera camera =
        look_at({2 * std::cos(angle), 2 * std::sin(angle), height}, {0, 0, 0}, {0, 0, 1}, kWidth, kHeight, 90);
    camera.name = "v" + std::to_string(10 + i);
    camera.photo = (folder / "photos" / (camera.name + ".png")).string();
    fs::create_directories(folder / "photos");
    write_image(camera.photo, render(cloud, camera).color);
    cameras.push_back(camera);
  }
  write_transforms(folder / "transforms.json", cameras);
}

std::vector<std::string> command(const fs::path& photos, const fs::path& out, std::vector<std::string> more = {}) {
  std::vector<std::string> words = {"reconstruct", photos.string(), "--out", out.string()};
  words.insert(words.end(), more.begin(), more.end());
  for (const auto& [option, value] : {std::pair{"--init", "random"}, {"--max-gaussians", "1k"}, {"--sh-degree", "0"}})
    if (std::find(more.begin(), more.end(), option) == more.end()) words.insert(words.end(), {option, value});
  return words;
}

TEST_F(Reconstruct, FindsAMadeSceneAgainFromItsPhotos) {
  const TemporaryFolder folder;
  make_photos(folder / "set");
  const fs::path out = folder / "scene";
  ASSERT_EQ(run_quietly(command(folder / "set", out, {"--iterations", "600"})), 0);

  const json results = read_json(out / "results.json");
  EXPECT_GE(results["psnr"].get<double>(), 25);
  EXPECT_EQ(results["held_out"].size(), 2u);
  EXPECT_EQ(results["photos"], 14);
  EXPECT_EQ(results["iterations"], 600);
  EXPECT_LE(results["gaussians"].get<int>(), 1000);
  EXPECT_EQ(results["curve"].size(), 20u);
  EXPECT_LT(results["curve"][0]["psnr"].get<double>(), results["curve"][19]["psnr"].get<double>());
  EXPECT_EQ(results["start"]["kind"], "random");
  for (const char* file : {"point_cloud/iteration_600/point_cloud.ply", "cameras.json", "preview.png", "run.json"})
    EXPECT_TRUE(fs::exists(out / file)) << file;
  EXPECT_FALSE(fs::exists(out / "checkpoint.h5"));
  EXPECT_FALSE(fs::exists(out / "photos")) << "photos that were not changed are not copied";

  // The scene is one like any other, with its photos.
  const Scene scene = load_scene(out);
  EXPECT_EQ(scene.cloud.size(), results["gaussians"].get<size_t>());
  ASSERT_EQ(scene.cameras.size(), 16u);
  EXPECT_TRUE(fs::equivalent(scene.cameras[3].photo, folder / "set/photos/v13.png"));
  ASSERT_EQ(run_quietly({"render", out.string(), "--out", (folder / "views").string()}), 0);
  EXPECT_TRUE(fs::exists(folder / "views/v13.png"));

  // Once is enough.
  const std::string record = read_text(out / "run.json");
  ASSERT_EQ(run_quietly(command(folder / "set", out, {"--iterations", "600"})), 0);
  EXPECT_EQ(read_text(out / "run.json"), record);
  // Another training replaces it and keeps it.
  const std::string splats = sha256_of_file(scene.settings.splats);
  const fs::path within = fs::relative(scene.settings.splats, out / "point_cloud");
  ASSERT_EQ(run_quietly(command(folder / "set", out, {"--iterations", "20"})), 0);
  EXPECT_EQ(read_json(out / "results.json")["iterations"], 20);
  EXPECT_EQ(sha256_of_file(out / "point_cloud.1" / within), splats);
  EXPECT_EQ(read_json(out / "results.json.1")["iterations"], 600);
}

/// Trains with the library; interrupted after so many questions about it, two an iteration (-1 = never).
bool train(const fs::path& photos, const fs::path& out, ReconstructStage stage, int questions, bool overwrite = false) {
  RunDirectory run = RunDirectory::create(out);
  Progress progress(true);
  const Context context{progress, [&, asked = 0]() mutable { return questions >= 0 && asked++ >= questions; }, 1, 1,
                        overwrite};
  try {
    run_reconstruct(context, run, photos, stage);
    return true;
  } catch (const Error& error) {
    if (error.failure != Failure::kInterrupted) throw;
    return false;
  }
}

ReconstructStage short_stage() {
  ReconstructStage stage;
  stage.train.iterations = 250;
  stage.train.most_gaussians = 600;
  stage.train.exposure = true;
  stage.start = "random";
  return stage;
}

TEST_F(Reconstruct, AnInterruptedTrainingThatIsGoneOnWithEndsWithTheSameBits) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 8);
  for (const Densification strategy : {Densification::kMcmc, Densification::kClassic}) {
    ReconstructStage stage = short_stage();
    stage.train.densification = strategy;
    const fs::path whole = folder / "whole", parts = folder / "parts";
    ASSERT_TRUE(train(folder / "set", whole, stage, -1));
    int interrupted = 0;
    while (!train(folder / "set", parts, stage, 130)) {
      EXPECT_TRUE(fs::exists(parts / "checkpoint.h5"));
      EXPECT_FALSE(fs::exists(parts / "scene.json"));
      ASSERT_LT(++interrupted, 10);
    }
    EXPECT_GE(interrupted, 2);
    for (const char* file :
         {"point_cloud/iteration_250/point_cloud.ply", "cameras.json", "transforms.json", "scene.json", "preview.png"})
      EXPECT_EQ(sha256_of_file(whole / file), sha256_of_file(parts / file)) << file;
    EXPECT_EQ(read_json(whole / "results.json")["held_out"], read_json(parts / "results.json")["held_out"]);
    EXPECT_EQ(read_json(whole / "results.json")["exposure"], read_json(parts / "results.json")["exposure"]);
    fs::remove_all(whole);
    fs::remove_all(parts);
  }
}

TEST_F(Reconstruct, TheCheckpointOfOtherOptionsOrADamagedOneIsMovedAside) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 8);
  ReconstructStage stage = short_stage();
  stage.train.iterations = 60;
  ASSERT_FALSE(train(folder / "set", folder / "scene", stage, 20));
  const std::string before = sha256_of_file(folder / "scene/checkpoint.h5");
  stage.train.most_gaussians = 700;
  EXPECT_TRUE(train(folder / "set", folder / "scene", stage, -1));
  EXPECT_EQ(sha256_of_file(folder / "scene/checkpoint.h5.1"), before);
  EXPECT_FALSE(fs::exists(folder / "scene/checkpoint.h5"));

  fs::remove_all(folder / "scene");
  ASSERT_FALSE(train(folder / "set", folder / "scene", stage, 20));
  write_text(folder / "scene/checkpoint.h5", "damaged");
  EXPECT_TRUE(train(folder / "set", folder / "scene", stage, -1));
  EXPECT_EQ(read_text(folder / "scene/checkpoint.h5.1"), "damaged");
}

TEST_F(Reconstruct, WhatTheScenesFileSaysLivesOn) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 6);
  const json said = {{"cameras", "transforms.json"},
                     {"photos", "photos"},
                     {"masks", "masks"},
                     {"labels", "labels.json"},
                     {"up", {0, 0, 1}},
                     {"metres_per_unit", 0.5},
                     {"object", "ball"},
                     {"support", "table"},
                     {"pinned", {{{"sphere", {0, 0, 0, 1}}}}},
                     {"material", {{"young", 1000.0}}}};
  write_json(folder / "set/scene.json", said);
  write_json(folder / "set/labels.json", {{"1", "ball"}, {"2", "table"}});
  IdImage ids(kWidth, kHeight, 1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) ids(x, y) = x < kWidth / 2 ? 1 : 2;
  fs::create_directories(folder / "set/masks");
  for (int i = 10; i < 16; ++i) write_ids(folder / ("set/masks/v" + std::to_string(i) + ".png"), ids);

  for (const bool smaller : {false, true}) {
    const fs::path out = folder / (smaller ? "smaller" : "same");
    ASSERT_EQ(
        run_quietly(command(folder / "set", out, {"--iterations", "20", "--max-image-size", smaller ? "40" : "960"})),
        0);
    const Scene scene = load_scene(out);
    EXPECT_EQ(scene.metres_per_unit, 0.5);
    EXPECT_EQ(scene.up, Eigen::Vector3d(0, 0, 1));
    EXPECT_EQ(scene.settings.object, "ball");
    EXPECT_EQ(scene.settings.support, "table");
    EXPECT_EQ(scene.settings.pinned.size(), 1u);
    EXPECT_EQ(scene.settings.material.young, 1000.0);
    EXPECT_TRUE(fs::equivalent(scene.settings.labels, folder / "set/labels.json"));
    ASSERT_EQ(scene.cameras.size(), 6u);
    EXPECT_EQ(scene.cameras[2].width, smaller ? 40 : kWidth);
    EXPECT_EQ(fs::path(scene.cameras[2].photo).parent_path().filename(), "photos");
    EXPECT_EQ(fs::equivalent(scene.settings.masks, folder / "set/masks"), !smaller);
    const IdImage seen = read_ids(scene.settings.masks / "v12.png");
    ASSERT_EQ(seen.width, scene.cameras[2].width);
    EXPECT_EQ(seen(seen.width / 2 - 1, 5), 1u);
    EXPECT_EQ(seen(seen.width / 2, 5), 2u);
  }
}

TEST_F(Reconstruct, WhatTheUserMakesOfTheSceneLivesOn) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 6);
  write_json(folder / "set/scene.json",
             {{"cameras", "transforms.json"}, {"photos", "photos"}, {"up", {0, 0, 1}}, {"object", "ball"}});
  const fs::path out = folder / "scene", file = out / "scene.json";
  const auto train_for = [&](const char* iterations) {
    return run_quietly(command(folder / "set", out, {"--iterations", iterations, "--max-image-size", "40"}));
  };
  ASSERT_EQ(train_for("5"), 0);
  json mine = read_json(file);
  mine["metres_per_unit"] = 0.5;
  mine["up"] = {0, 1, 0};
  mine["masks"] = "masks";
  mine.erase("object");
  write_json(file, mine);
  const IdImage ids(40, 30, 1, 3);
  write_ids(out / "masks/v12.png", ids);
  ASSERT_EQ(train_for("5"), 0) << "unchanged";
  EXPECT_EQ(read_json(file), mine);
  ASSERT_EQ(train_for("6"), 0);
  mine["splats"] = "point_cloud/iteration_6/point_cloud.ply";
  EXPECT_EQ(read_json(file), mine);
  EXPECT_EQ(read_ids(out / "masks/v12.png").data, ids.data);

  // What the source says anew holds.
  json source = read_json(folder / "set/scene.json");
  source["up"] = {1, 0, 0};
  source["support"] = "table";
  write_json(folder / "set/scene.json", source);
  ASSERT_EQ(train_for("6"), 0);
  mine["up"] = {1, 0, 0};
  mine["support"] = "table";
  EXPECT_EQ(read_json(file), mine);

  // Masks of the source take the place of the user's, which are kept.
  IdImage halves(kWidth, kHeight, 1, 2);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth / 2; ++x) halves(x, y) = 1;
  for (int i = 10; i < 16; ++i) write_ids(folder / ("set/masks/v" + std::to_string(i) + ".png"), halves);
  source["masks"] = "masks";
  write_json(folder / "set/scene.json", source);
  ASSERT_EQ(train_for("6"), 0);
  EXPECT_EQ(read_ids(out / "masks/v12.png")(5, 5), 1u);
  EXPECT_EQ(read_ids(out / "masks.1/v12.png").data, ids.data);
  ASSERT_EQ(train_for("7"), 0);
  EXPECT_FALSE(fs::exists(out / "masks.2")) << "its own are written anew";
  write_ids(out / "masks/v12.png", ids);
  ASSERT_EQ(train_for("8"), 0);
  EXPECT_EQ(read_ids(out / "masks.2/v12.png").data, ids.data) << "its own with another mask in it";
}

TEST_F(Reconstruct, TheLensesOfChangedPhotosAreKept) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 4);
  std::vector<Camera> cameras = read_transforms(folder / "set/transforms.json").cameras;
  for (Camera& camera : cameras) camera.distortion[0] = 0.1;
  write_transforms(folder / "set/transforms.json", cameras);
  ASSERT_EQ(run_quietly(command(folder / "set", folder / "scene", {"--iterations", "5"})), 0);
  const Scene scene = load_scene(folder / "scene");
  ASSERT_LT(scene.cameras[2].width, kWidth);
  EXPECT_EQ(read_lens(folder / "scene" / kLensFile, scene.cameras[2]).value().distortion[0], 0.1);
  EXPECT_EQ(read_lens(folder / "scene" / kLensFile, scene.cameras[2]).value().width, kWidth);
}

TEST_F(Reconstruct, UpIsThatOfPhotosThatWereHeldSideways) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 12);
  // Half a ring of cameras that were turned by a quarter, whose photos say so as JPEG.
  std::vector<Camera> cameras = read_transforms(folder / "set/transforms.json").cameras, half;
  for (size_t i = 0; i < 6; ++i) {
    Camera& camera = half.emplace_back(cameras[i]);
    const Eigen::Matrix<double, 2, 3> right_down = camera.cam_from_world.linear().topRows<2>();
    camera.cam_from_world.linear().topRows<2>() = stored_from_upright(6).cast<double>() * right_down;
    const cv::Mat picture = picture_of(kWidth, kHeight, [](int x, int y, int c) { return 3 * x + 2 * y + 9 * c; });
    camera.photo = (folder / "set/photos" / (camera.name + ".jpg")).string();
    write_text(camera.photo, with_orientation(encoded(".jpg", picture), 6, true));
  }
  write_transforms(folder / "set/transforms.json", half);
  const fs::path out = folder / "scene";
  const auto train = [&] {
    return run_quietly(
        command(folder / "set", out, {"--iterations", "3", "--max-image-size", "40", "--pose-convention", "as-given"}));
  };
  ASSERT_EQ(train(), 0);
  EXPECT_LT((load_scene(out).up - Vec3d::UnitZ()).norm(), 1e-5);
  ASSERT_EQ(train(), 0);
  EXPECT_LT((load_scene(out).up - Vec3d::UnitZ()).norm(), 1e-5) << "after a skipped training";
}

TEST_F(Reconstruct, AFinishedResultLeavesTheCheckpointOfALongerTraining) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 4);
  ReconstructStage brief = short_stage(), longer = short_stage();
  brief.train.iterations = 10;
  longer.train.iterations = 60;
  ASSERT_TRUE(train(folder / "set", folder / "scene", brief, -1));
  EXPECT_FALSE(fs::exists(folder / "scene/checkpoint.h5"));
  ASSERT_FALSE(train(folder / "set", folder / "scene", longer, 40));
  const std::string checkpoint = sha256_of_file(folder / "scene/checkpoint.h5");
  ASSERT_TRUE(train(folder / "set", folder / "scene", brief, -1));
  EXPECT_EQ(sha256_of_file(folder / "scene/checkpoint.h5"), checkpoint);
  ASSERT_TRUE(train(folder / "set", folder / "scene", longer, -1));
  EXPECT_FALSE(fs::exists(folder / "scene/checkpoint.h5"));
}

TEST_F(Reconstruct, ARunDirectoryIsNotReplacedByAScene) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 4);
  RunDirectory::create(folder / "with_scene").set_scene({{"source", "flower"}}, false);
  Progress progress(true);
  StageKey key;
  key.name = "simulate";
  RunDirectory::create(folder / "with_stage").stage({progress, [] { return false; }}, key, [](const std::string&) {
    return json::object();
  });
  for (const auto& [name, of] : {std::pair{"with_scene", "another command"}, {"with_stage", "`simulate`"}})
    expect_error(Failure::kUsage, {"--out", "holds the results of", of},
                 [&] { train(folder / "set", folder / name, short_stage(), -1); });
}

TEST_F(Reconstruct, ChangedPhotosKeepTheMasksOfEveryLayoutAndTheirNames) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 6);
  const auto half = [](bool right, uint32_t id, uint32_t rest) {
    IdImage ids(kWidth, kHeight, 1, rest);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth / 2; ++x) ids(right ? x + kWidth / 2 : x, y) = id;
    return ids;
  };
  for (int i = 10; i < 16; ++i) {
    const std::string name = "v" + std::to_string(i) + ".png";
    write_ids(folder / "set/by_photo" / (name + ".png"), half(false, 1, 2));
    write_ids(folder / "set/by_object/ball" / name, half(false, 255, 0));
    write_ids(folder / "set/by_object/table" / name, half(true, 255, 0));
    write_ids(folder / "set/of_one/ball" / name, half(false, 255, 0));
  }
  folder.file("set/by_photo/labels.json", R"({"1": "cup"})");  // as `label` leaves it
  folder.file("set/labels.json", R"({"1": "cat"})");           // of other masks
  const std::map<std::string, std::string> second = {
      {"by_photo", "object_2"}, {"by_object", "table"}, {"of_one", "background"}};
  for (const auto& [layout, name] : second) {
    json settings = {{"cameras", "transforms.json"}, {"photos", "photos"}, {"masks", layout}};
    if (layout == "of_one") settings["labels"] = "labels.json";
    write_json(folder / "set/scene.json", settings);
    for (int repeated = 0; repeated < 2; ++repeated) {
      ASSERT_EQ(run_quietly(command(folder / "set", folder / layout, {"--iterations", "5", "--max-image-size", "40"})),
                0);
      const Scene scene = load_scene(folder / layout);
      const fs::path beside = scene.settings.masks / "labels.json";
      const MaskSet masks =
          load_masks(scene.settings.masks, fs::exists(beside) ? beside : scene.settings.labels, scene.cameras);
      ASSERT_EQ(masks.views.size(), 6u) << layout;
      EXPECT_EQ(masks.views[2].ids(19, 5), 1u);
      EXPECT_EQ(masks.views[2].ids(20, 5), 2u);
      EXPECT_EQ(masks.name_of(2), name);
      EXPECT_EQ(masks.name_of(1), layout == "by_photo" ? "cup" : "ball");
      EXPECT_EQ(fs::exists(beside), layout == "by_photo");
    }
  }
}

TEST_F(Reconstruct, MasksMayHaveTheSizeOfThePhotosWhereTheCamerasAreLarger) {
  const TemporaryFolder folder;
  IdImage ids(40, 30, 1, 2);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 20; ++x) ids(x, y) = 1;
  write_ids(folder / "a.png", ids);
  CameraFile cameras;
  cameras.cameras = {look_at({0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 80, 60, 90)};
  cameras.cameras[0].name = "a";
  TrainingPhotos photos;
  photos.photos.resize(1);
  photos.photos[0].camera = cameras.cameras[0].scaled(0.25);
  const MaskSet masks = training_masks(folder.path(), {}, cameras, photos);
  ASSERT_EQ(masks.views.size(), 1u);
  EXPECT_EQ(masks.views[0].ids.width, 20);
  EXPECT_EQ(masks.views[0].ids(9, 7), 1u);
  EXPECT_EQ(masks.views[0].ids(10, 7), 2u);
}

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
  // What excludes joint training is said before it.
  for (const std::vector<std::string>& excluded : std::vector<std::vector<std::string>>{
           {"--click", "v12,40,30"}, {"--auto"}, {"--gaussian-grouping", "model"}, {"--mask-zero", "background"}}) {
    std::vector<std::string> words = segment;
    words.back() = (folder / "excluded").string();
    words.insert(words.end(), excluded.begin(), excluded.end());
    EXPECT_EQ(run_quietly(words), 2) << excluded[0];
    EXPECT_FALSE(fs::exists(folder / "excluded/scene")) << excluded[0];
  }
}

TEST_F(Reconstruct, TimeIsHonoured) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 8);
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(run_quietly(command(folder / "set", folder / "scene", {"--time-limit", "2s"})), 0);
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double seconds = read_json(folder / "scene/results.json")["seconds"];
  EXPECT_GE(seconds, 2.0);
  EXPECT_LE(seconds, 2.5);  // the last iteration and what belongs to it
  EXPECT_GE(wall, 1.8);
  EXPECT_LE(wall, 3.5);  // and writing the results
}

TEST_F(Reconstruct, PhotosWithoutCamerasAreToldHowToGetThem) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 4);
  fs::remove(folder / "set/transforms.json");
  expect_error(Failure::kInput,
               {"4 photos", "no cameras", "colmap automatic_reconstructor", (folder / "set/photos").string()},
               [&] { find_photo_set(folder / "set"); });
  EXPECT_TRUE(lacks_splats(folder / "set"));
  // Several splats beside a picture are no photo set.
  GaussianCloud cloud;
  cloud.resize(1);
  for (const char* name : {"set/a.ply", "set/b.ply"}) write_ply(folder / name, cloud);
  EXPECT_FALSE(lacks_splats(folder / "set"));
  for (const char* name : {"set/a.ply", "set/b.ply"}) fs::remove(folder / name);
  EXPECT_EQ(run_quietly(command(folder / "set", folder / "scene")), 1);
  EXPECT_EQ(
      run_quietly({"run", (folder / "set").string(), "--out", (folder / "run").string(), "--aabb", "0,0,0,1,1,1"}), 1);
  EXPECT_EQ(run_quietly(command(folder / "absent", folder / "scene")), 1);
}

TEST_F(Reconstruct, OfSeveralColmapModelsTheLargestIsTakenAndTheOthersAreNamed) {
  const TemporaryFolder folder;
  std::string images;
  for (int model = 0; model < 2; ++model) {
    const std::string name = std::to_string(model);
    images += name + " 1 0 0 0 0 0 " + name + " 1 " + name + ".png\n\n";
    folder.file("images/" + name + ".png", "not decoded");
    folder.file("sparse/" + name + "/cameras.txt", "1 PINHOLE 64 48 60 60 32 24\n");
    folder.file("sparse/" + name + "/images.txt", images);
  }
  const PhotoSet set = find_photo_set(folder.path());
  EXPECT_EQ(set.cameras, folder / "sparse/1");
  const CameraFile cameras = read_photo_cameras(set);
  EXPECT_EQ(cameras.cameras.size(), 2u);
  ASSERT_EQ(cameras.warnings.size(), 1u);
  EXPECT_NE(cameras.warnings[0].find("sparse/1 with 2 images is used; sparse/0 has 1"), std::string::npos);
}

TEST_F(Reconstruct, TooFewPhotosAndImpossibleOptionsEndWithTheRightExitCode) {
  const TemporaryFolder folder;
  make_photos(folder / "one", 1);
  EXPECT_EQ(run_quietly(command(folder / "one", folder / "a")), 1);
  make_photos(folder / "set", 4);
  EXPECT_EQ(run_quietly(command(folder / "set", folder / "b", {"--hold-out-every", "1"})), 2);
  for (const std::vector<std::string>& bad :
       std::vector<std::vector<std::string>>{{"--time-limit", "10x"},
                                             {"--time-limit", "0s"},
                                             {"--time-limit", "-5"},
                                             {"--iterations", "0"},
                                             {"--time-limit", "5s", "--iterations", "100"},
                                             {"--max-gaussians", "many"},
                                             {"--max-gaussians", "0"},
                                             {"--max-gaussians", "2kk"},
                                             {"--background", "0,0"},
                                             {"--background", "0,0,2"},
                                             {"--sh-degree", "4"},
                                             {"--strategy", "best"},
                                             {"--photos", "nowhere"}})
    EXPECT_EQ(run_quietly(command(folder / "set", folder / "c", bad)), 2) << bad[0] << " " << bad[1];
  EXPECT_EQ(run_quietly(command(folder / "set", folder / "d", {"--init", "points"})), 2);
  EXPECT_EQ(run_quietly(command(folder / "set", folder / "e", {"--max-image-size", "12"})), 1);
}

}  // namespace
}  // namespace pliant
