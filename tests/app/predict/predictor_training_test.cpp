// `train-predictor`: weights that `predict` takes, from the corpus and from finished fits.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/import/material_fields.h"
#include "app/predict/object_samples.h"
#include "app/store/material.h"
#include "app/store/particles.h"
#include "fitting/distribution/distribution_loss.h"
#include "fitting/distribution/distribution_network.h"
#include "fitting/distribution/local_features.h"
#include "gaussians/base/random.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/io/splats/splats.h"
#include "tests/app/fit_video_scene.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

class TrainPredictor : public FitVideo {
 protected:
  void SetUp() override {
    if (!can_train_networks()) GTEST_SKIP() << "built without libtorch";
  }
  static std::string run() { return (folder / "run").string(); }
  /// A fit that found E from 1e4 to 3e4 Pa.
  static void pretend_fit() {
    const fs::path object = folder / "run" / object_folder(RunDirectory::open(run()));
    MaterialFile found;
    const size_t count = read_particles(object / "particles.h5").solid_position.size();
    for (size_t i = 0; i < count; ++i)
      found.young.push_back(1e4f + 2e4f * static_cast<float>(i) / static_cast<float>(count));
    found.poisson.assign(count, 0.3f);
    found.density.assign(count, 400.0f);
    write_material(object / "material.h5", found, "{}");
    json record = read_json(folder / "run/run.json");
    json& fit = record["stages"]["fit"] = record["stages"]["seed"];
    fit["inputs"] = {{"particles", hash_of_input(object / "particles.h5")}};
    fit["outputs"] = json::array({"objects/" + object.filename().string() + "/material.h5"});
    write_text(folder / "run/run.json", record.dump());
  }
  static fs::path out(const char* name) { return folder / name; }
  static int train(const char* name, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"train-predictor", "--out", out(name).string(), "--count", "18", "--members", "1",
                               "--epochs", "2", "--threads", "1"});
    return run_quietly(more);
  }
};

TEST_F(TrainPredictor, GivesWeightsFiguresAndACurveThatAreTheSameAgain) {
  ASSERT_EQ(train("a"), 0);
  ASSERT_EQ(train("b"), 0);
  EXPECT_EQ(read_text(out("a") / "predictor.safetensors"), read_text(out("b") / "predictor.safetensors"));
  EXPECT_FALSE(fs::exists(out("a") / "checkpoint.safetensors"));
  const json figures = read_json(out("a") / "figures.json");
  EXPECT_EQ(figures.size(), 6u);  // five families and all
  EXPECT_EQ(figures.back()["family"], "all");
  EXPECT_EQ(read_network(out("a") / "predictor.safetensors").members.size(), 1u);
  // What is there is not lost.
  EXPECT_EQ(train("a"), 2);
  EXPECT_EQ(run_quietly({"train-predictor"}), 2);
  EXPECT_EQ(run_quietly({"train-predictor", "--out", out("c").string(), "--count", "3"}), 2);
}

TEST(TrainPredictorOptions, MoreNetworksThanAnEnsembleHoldsAreRefusedByTheOptionsName) {
  const TemporaryFolder folder;
  ::testing::internal::CaptureStderr();
  const int code = run_quietly({"train-predictor", "--out", (folder / "out").string(), "--members", "17"});
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(code, 2);
  EXPECT_NE(said.find("--members"), std::string::npos) << said;
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST_F(TrainPredictor, AFittedObjectJoinsAndPredictUsesTheWeights) {
  EXPECT_EQ(train("none", {"--add-run", run()}), 2);  // nothing was fitted there
  pretend_fit();
  ASSERT_EQ(train("plain"), 0);
  ASSERT_EQ(train("joined", {"--add-run", run()}), 0);
  EXPECT_NE(read_text(out("plain") / "predictor.safetensors"), read_text(out("joined") / "predictor.safetensors"));
  const auto predicted = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"predict", run(), "--label", "flower"};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(run_quietly(words), 0);
    for (const auto& object : fs::directory_iterator(folder / "run/objects"))
      if (fs::exists(object.path() / "predicted.h5")) return read_material(object.path() / "predicted.h5").young;
    return std::vector<float>();
  };
  const std::vector<float> shipped = predicted({});
  ASSERT_FALSE(shipped.empty());
  EXPECT_NE(predicted({"--weights", (out("joined") / "predictor.safetensors").string()}), shipped);
  EXPECT_EQ(run_quietly({"predict", run(), "--weights", (folder / "run/run.json").string()}), 1);
}

TEST_F(TrainPredictor, SplatsWithAFieldBesideThemJoin) {
  const fs::path objects = folder / "objects";
  fs::create_directories(objects);
  EXPECT_EQ(train("none", {"--objects", objects.string()}), 2);  // empty
  const auto copied = [&](const char* name) {
    for (const auto& object : fs::directory_iterator(folder / "run/objects"))
      fs::copy_file(object.path() / "object.ply", objects / name, fs::copy_options::overwrite_existing);
    return read_splats(objects / name);
  };
  const GaussianCloud cloud = copied("daisy-1.ply");
  EXPECT_EQ(train("none", {"--objects", objects.string()}), 2);  // no field
  MaterialFile field;
  field.position = cloud.position;
  for (size_t i = 0; i < cloud.size(); ++i) {
    field.young.push_back(i % 2 ? 1e5f : 3e5f);
    field.poisson.push_back(0.3f);
    field.density.push_back(400);
  }
  write_material_field(objects / "daisy-1.npz", field);
  const std::vector<MaterialObject> read = splat_objects(objects, 1);
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].family, "daisy");
  EXPECT_EQ(read[0].young.size(), read[0].samples.size());
  EXPECT_TRUE(std::all_of(read[0].young.begin(), read[0].young.end(), [](float E) { return E == 1e5f || E == 3e5f; }));
  ASSERT_EQ(train("splats", {"--objects", objects.string()}), 0);
  // Of two fields or two splat files of one name neither is chosen.
  write_material_field(objects / "daisy-1.field.ply", field);
  EXPECT_EQ(train("twice", {"--objects", objects.string()}), 2);
  fs::remove(objects / "daisy-1.field.ply");
  // A field of something else is refused before any training.
  for (Vec3f& x : field.position) x.x() *= 5;
  write_material_field(objects / "daisy-1.npz", field);
  EXPECT_EQ(train("other", {"--objects", objects.string()}), 1);
}

/// A ball on a wide plate that stands along `up`.
GaussianCloud ball_on_plate(const Vec3f& up) {
  GaussianCloud cloud;
  cloud.resize(6000);
  Random random(5);
  const Vec3f a = Vec3f::UnitX(), b = up.cross(a);
  for (size_t i = 0; i < cloud.size(); ++i) {
    Vec3f x;
    do {
      for (int k = 0; k < 3; ++k) x[k] = random.uniform(-1, 1);
    } while (x.norm() > 1);
    x = i < 3000 ? Vec3f(2 * x.x(), 2 * x.y(), 0.03f * x.z()) : Vec3f(0.5f * x + 0.55f * Vec3f::UnitZ());
    cloud.position[i] = x.x() * a + x.y() * b + x.z() * up;
    cloud.opacity_logit[i] = 3;
    cloud.log_scale[i] = Vec3f::Constant(-3);
  }
  return cloud;
}

TEST(SplatObjects, StandAsTheyAreWhicheverAxisIsUp) {
  const TemporaryFolder folder;
  std::vector<float> means[2];
  const Vec3f ups[] = {Vec3f(0, -1, 0), Vec3f(0, 0, 1)};
  for (int turned = 0; turned < 2; ++turned) {
    const fs::path objects = folder / std::to_string(turned);
    fs::create_directories(objects);
    const GaussianCloud cloud = ball_on_plate(ups[turned]);
    write_ply(objects / "lamp-1.ply", cloud);
    MaterialFile field;
    field.position = cloud.position;
    field.young.assign(cloud.size(), 1e5f);
    field.poisson.assign(cloud.size(), 0.3f);
    field.density.assign(cloud.size(), 400);
    write_material_field(objects / "lamp-1.npz", field);
    const MaterialObject object = splat_objects(objects, 1).at(0);
    EXPECT_GT(object.up.dot(ups[turned]), 0.999f) << object.up.transpose();
    const std::vector<float> features = local_features({object.samples, object.colour, {}, object.up, {}});
    means[turned].resize(kFeatures);
    for (size_t i = 0; i < features.size(); ++i)
      means[turned][i % kFeatures] += features[i] / static_cast<float>(object.samples.size());
  }
  for (int f = 0; f < kFeatures; ++f) EXPECT_NEAR(means[0][f], means[1][f], 0.2) << f;
}

TEST(SplatObjects, TwoFieldsOrSplatFilesOfOneNameAreRefused) {
  const TemporaryFolder folder;
  const GaussianCloud cloud = ball_on_plate(Vec3f(0, 0, 1));
  MaterialFile field;
  field.position = cloud.position;
  field.young.assign(cloud.size(), 1e5f);
  field.poisson.assign(cloud.size(), 0.3f);
  field.density.assign(cloud.size(), 400);
  const auto refuses = [&](const std::vector<const char*>& names) {
    expect_error(Failure::kUsage, {"--objects", names[0], names[1]}, [&] { splat_objects(folder / "objects", 1); });
  };
  fs::create_directories(folder / "objects");
  write_ply(folder / "objects/lamp-1.ply", cloud);
  write_material_field(folder / "objects/lamp-1.npz", field);
  write_material_field(folder / "objects/lamp-1.field.ply", field);
  refuses({"lamp-1.field.ply", "lamp-1.npz"});
  fs::remove(folder / "objects/lamp-1.field.ply");
  write_splats(folder / "objects/lamp-1.splat", cloud);
  refuses({"lamp-1.ply", "lamp-1.splat"});
  // Splats without a field may have any names.
  for (const char* name : {"lamp-1.ply", "lamp-1.splat"})
    fs::rename(folder / "objects" / name, folder / "objects" / ("other" + std::string(name).substr(4)));
  write_ply(folder / "objects/lamp-1.ply", cloud);
  EXPECT_EQ(splat_objects(folder / "objects", 1).size(), 1u);
}

}  // namespace
}  // namespace pliant
