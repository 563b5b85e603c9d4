// From photos to a scene: a made scene is found again from its pictures, an interrupted training ends with the same
// bits, budgets hold, and what cannot be done is said.

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "app/reconstruct/photo_set.h"
#include "app/reconstruct/reconstruct_stage.h"
#include "app/reconstruct/training_masks.h"
#include "app/store/training.h"
#include "gaussians/base/random.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/render/render.h"
#include "tests/app/reconstruct/made_photos.h"
#include "tests/gaussians/textured_scene.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

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

TEST_F(Reconstruct, APhotoThatSeesHardlyAnyTriangulatedPointIsNamed) {
  const TemporaryFolder folder;
  const GaussianCloud cloud = textured_sheet();
  std::vector<Camera> cameras = arc_of_cameras(9);
  for (Camera& camera : cameras) {
    camera.photo = (folder / ("set/" + camera.name + ".png")).string();
    fs::create_directories(folder / "set");
    write_image(camera.photo, render(cloud, camera).color);
  }
  Eigen::Isometry3d& wrong = cameras[3].cam_from_world;
  wrong.linear() = (Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 1, 0).normalized()) * wrong.linear()).eval();
  write_transforms(folder / "set/transforms.json", cameras);
  ReconstructStage stage = short_stage();
  stage.train.iterations = 2;
  stage.photo.hold_out_every = 0;
  stage.start = "triangulate";
  stage.poses = "as-given";
  ASSERT_TRUE(train(folder / "set", folder / "scene", stage, -1));
  const json results = read_json(folder / "scene/results.json");
  EXPECT_EQ(results["start"]["kind"], "triangulate");
  for (const json& warnings : {results["warnings"], results["start"]["warnings"]}) {
    const std::string all = warnings.dump();
    EXPECT_NE(all.find("view_d.png: sees"), std::string::npos) << all;
    for (const char* other : {"view_c.png: sees", "view_e.png: sees"}) EXPECT_EQ(all.find(other), std::string::npos);
  }
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

TEST_F(Reconstruct, OfATimeLimitAResumedTrainingHasWhatWasLeftOfIt) {
  const TemporaryFolder folder;
  make_photos(folder / "set", 8);
  const fs::path file = folder / "scene/checkpoint.h5";
  ReconstructStage stage = short_stage();
  stage.train.seconds = 30;
  ASSERT_FALSE(train(folder / "set", folder / "scene", stage, 10));
  TrainingCheckpoint checkpoint = read_training(file);
  const int before = checkpoint.state.iteration;
  // Less is left than reading the photos takes.
  checkpoint.state.seconds = stage.train.seconds - 1e-3;
  write_training(file, checkpoint);
  ASSERT_TRUE(train(folder / "set", folder / "scene", stage, -1));
  EXPECT_GT(read_json(folder / "scene/results.json")["iterations"].get<int>(), before);
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
  // Where there are no photos either, COLMAP is of no help.
  fs::create_directories(folder / "empty");
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_quietly(command(folder / "empty", folder / "scene")), 1);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("neither photos nor cameras"), std::string::npos) << said;
  EXPECT_EQ(said.find("colmap"), std::string::npos) << said;
  // Photos of a phone that cannot be read are named.
  folder.file("phone/images/IMG_0001.HEIC", "not read");
  EXPECT_TRUE(lacks_splats(folder / "phone"));
  expect_error(Failure::kInput, {"1 photos", ".HEIC", "mogrify", "phone/images"},
               [&] { find_photo_set(folder / "phone"); });
  // An archive beside photos is no splat file.
  make_photos(folder / "archives", 2);
  folder.file("archives/scan.usdz", "PK\3\4");
  EXPECT_TRUE(lacks_splats(folder / "archives"));
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
