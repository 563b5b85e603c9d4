// What the folder of a trained scene keeps: the source's scene.json and the user's edits, lenses, up, masks,
// checkpoints.

#include "app/reconstruct/trained_scene.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "app/reconstruct/photo_set.h"
#include "app/reconstruct/reconstruct_stage.h"
#include "app/reconstruct/training_masks.h"
#include "app/store/lenses.h"
#include "app/store/segmentation.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/photo.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/reconstruct/made_photos.h"
#include "tests/gaussians/photo_files.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

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

TEST_F(Reconstruct, TheBackgroundIsThatOfTheSceneFromThenOn) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 4);
  const auto trained = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"--iterations", "5"};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(run_quietly(command(folder / "set", folder / "scene", words)), 0);
    return load_scene(folder / "scene").settings;
  };
  EXPECT_FALSE(trained({}).background);
  EXPECT_EQ(trained({"--background", "1,0.5,1"}).background, Vec3d(1, 0.5, 1));
  const auto picture = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"render", (folder / "scene").string(), "--out", (folder / "views").string()};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(run_quietly(words), 0);
    return read_image(folder / "views/v11.png").data;
  };
  EXPECT_EQ(picture({}), picture({"--background", "1,0.5,1"}));
  EXPECT_NE(picture({}), picture({"--background", "0,0,0"}));
  EXPECT_FALSE(trained({}).background);

  // The source may say it; what a training is told goes first.  What it says of its own splats is of no others.
  write_json(folder / "set/scene.json",
             {{"cameras", "transforms.json"}, {"photos", "photos"}, {"background", {0, 1, 0}}, {"antialiased", true}});
  EXPECT_EQ(trained({}).background, Vec3d(0, 1, 0));
  EXPECT_FALSE(trained({}).antialiased);
  EXPECT_EQ(trained({"--background", "0,0,0"}).background, Vec3d(0, 0, 0));
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
  // The source may say another one for a while.
  for (const bool trained_anew : {true, false}) {
    if (trained_anew) fs::remove_all(out);
    write_json(folder / "set/scene.json", {{"cameras", "transforms.json"}, {"up", {1, 0, 0}}});
    ASSERT_EQ(train(), 0);
    EXPECT_EQ(load_scene(out).up, Vec3d::UnitX());
    write_json(folder / "set/scene.json", {{"cameras", "transforms.json"}});
    ASSERT_EQ(train(), 0);
    EXPECT_LT((load_scene(out).up - Vec3d::UnitZ()).norm(), 1e-5) << trained_anew;
  }
}

TEST_F(Reconstruct, ThePlySaysWhetherZIsUp) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 4);
  PhotoSet set = find_photo_set(folder / "set");
  const CameraFile cameras = read_photo_cameras(set);
  const TrainingPhotos photos = load_training_photos({}, cameras);
  const GaussianCloud cloud = made_cloud();
  RunDirectory run = RunDirectory::create(folder / "scene");
  const auto z_is_up = [&](std::optional<Vec3d> up, bool declared) {
    set.settings.up = up;
    write_trained_scene(run, {.set = set, .cameras = cameras, .photos = photos, .cloud = cloud, .z_is_up = declared});
    ReadReport report;
    read_ply(folder / "scene/point_cloud/iteration_0/point_cloud.ply", &report);
    return report.z_is_up;
  };
  EXPECT_TRUE(z_is_up(std::nullopt, false)) << "the cameras see it";
  EXPECT_TRUE(z_is_up(Vec3d(0, 0, 1), false));
  EXPECT_TRUE(z_is_up(Vec3d(0, std::sin(0.6), std::cos(0.6)), false));
  EXPECT_FALSE(z_is_up(Vec3d(0, std::sin(0.8), std::cos(0.8)), false));
  EXPECT_FALSE(z_is_up(Vec3d(0, -1, 0), false)) << "the scene file goes before the cameras";
  EXPECT_TRUE(z_is_up(Vec3d(0, -1, 0), true)) << "the splats that were trained on say so";
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

TEST_F(Reconstruct, AFolderBehindALinkKeepsItsPhotos) {
  const TemporaryFolder folder;
  make_photos(folder / "home/set", 4);
  fs::create_directories(folder / "real/deep/disk");
  fs::create_directory_symlink(folder / "real/deep/disk", folder / "scratch");
  const PhotoSet set = find_photo_set(folder / "home/set");
  const CameraFile cameras = read_photo_cameras(set);
  const TrainingPhotos photos = load_training_photos({}, cameras);
  const GaussianCloud cloud = made_cloud();
  RunDirectory run = RunDirectory::create(folder / "scratch/scene");
  write_trained_scene(run, {.set = set, .cameras = cameras, .photos = photos, .cloud = cloud});
  const Scene scene = load_scene(folder / "scratch/scene");
  EXPECT_TRUE(fs::equivalent(scene.settings.photos, folder / "home/set"));
  ASSERT_EQ(scene.cameras.size(), 4u);
  EXPECT_TRUE(fs::equivalent(scene.cameras[2].photo, folder / "home/set/photos/v12.png"));
}

TEST_F(Reconstruct, WhatAnUnfinishedTrainingHasWrittenIsWrittenAnew) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 4);
  const PhotoSet set = find_photo_set(folder / "set");
  const CameraFile cameras = read_photo_cameras(set);
  TrainingPhotos photos = load_training_photos({.longest_side = 40}, cameras);
  const GaussianCloud cloud = made_cloud();
  const fs::path out = folder / "scene";
  RunDirectory run = RunDirectory::create(out);
  const auto write = [&] {
    return write_trained_scene(run, {.set = set, .cameras = cameras, .photos = photos, .cloud = cloud});
  };
  for (int trainings = 0; trainings < 2; ++trainings) {
    const std::string name = std::exchange(photos.photos[3].camera.name, std::string(300, 'x'));  // no file has it
    EXPECT_ANY_THROW(write());
    ASSERT_TRUE(fs::exists(out / "photos"));
    photos.photos[3].camera.name = name;
    EXPECT_EQ(write(), std::vector<std::string>());
    EXPECT_FALSE(fs::exists(out / "photos.1"));
    EXPECT_EQ(load_scene(out).cameras.size(), 4u);
  }
  // What the user has changed in a finished one is kept.
  fs::remove(out / "photos/v11.png");
  EXPECT_EQ(write().size(), 1u);
  EXPECT_TRUE(fs::exists(out / "photos.1/v12.png"));
}

}  // namespace
}  // namespace pliant
