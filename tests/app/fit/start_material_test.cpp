// Where a fit starts: a material of every sample, of which it finds factors.

#include "app/fit/start_material.h"

#include "tests/app/fit_of_few_particles.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using nlohmann::json;

class StartMaterialTest : public FitOfFewParticles {
 protected:
  /// A material.h5 of these samples whose E is `lower` in the lower half of the flower of 0.32 m, else `upper`.
  std::string material(double lower, double upper, float poisson, float density) const {
    const std::vector<Vec3f> places = read_particles(object / "particles.h5").solid_position;
    MaterialFile given;
    for (const Vec3f& x : places) given.young.push_back(static_cast<float>(x.z() < 0.16f ? lower : upper));
    given.poisson.assign(places.size(), poisson);
    given.density.assign(places.size(), density);
    given.source = "given";
    const Path file = folder / "small/given.h5";
    write_material(file, given, "{}");
    return file.string();
  }
};

TEST_F(StartMaterialTest, OneFactorOfAGivenMaterialIsFitted) {
  const std::string file = material(1e5, 2e4, 0.4f, 600);
  const MaterialFile given = read_material(file);
  const json one = fitted({"--initial-material", file});
  const MaterialFile uniform = read_material(object / "material.h5");
  EXPECT_EQ(uniform.source, "the initial material times one factor, fitted to the reference video");
  EXPECT_EQ(uniform.poisson, given.poisson);
  EXPECT_EQ(uniform.density, given.density);
  const double factor = double(uniform.young[0]) / given.young[0];
  EXPECT_GT(std::abs(std::log(factor)), 0.05);
  for (size_t s = 0; s < given.young.size(); ++s) ASSERT_NEAR(uniform.young[s] / given.young[s] / factor, 1, 1e-5);
  const ParticleFile particles = read_particles(object / "particles.h5");
  EXPECT_NEAR(one["young_pa"].get<double>() / mean_young(particles, given.young) / factor, 1, 1e-5);
  EXPECT_NE(one["undetermined"].dump().find("One factor of the given material"), std::string::npos);
}

TEST_F(StartMaterialTest, ASmoothFieldOfFactorsLeavesTheStepsOfAGivenMaterial) {
  const std::string file = material(1e5, 2e4, 0.4f, 600);
  fitted({"--initial-material", file, "--field", "smooth"});
  const MaterialFile smooth = read_material(object / "material.h5");
  EXPECT_EQ(smooth.source, "the initial material times factors (a smooth field), fitted to the reference video");
  const ParticleFile particles = read_particles(object / "particles.h5");
  // The step at half the height is not smooth, so it is that of the given material.
  double below = 0, above = 0, volume_below = 0, volume_above = 0;
  for (size_t s = 0; s < smooth.young.size(); ++s) {
    const float z = particles.solid_position[s].z();
    if (particles.solid_driver[s] < 0 || std::abs(z - 0.16f) > 0.02f) continue;
    (z < 0.16f ? below : above) += particles.solid_volume[s] * std::log(smooth.young[s]);
    (z < 0.16f ? volume_below : volume_above) += particles.solid_volume[s];
  }
  EXPECT_GT(below / volume_below - above / volume_above, 0.5 * std::log(5.0));
}

TEST_F(StartMaterialTest, AUniformFileIsTheSameAsItsConstants) {
  const json typed = fitted({"--young", "40000", "--poisson", "0.35", "--density", "700"});
  const MaterialFile by_constants = read_material(object / "material.h5");
  const json given = fitted({"--initial-material", material(4e4, 4e4, 0.35f, 700)});
  const MaterialFile by_file = read_material(object / "material.h5");
  EXPECT_EQ(by_file.young, by_constants.young);
  EXPECT_EQ(by_file.poisson, by_constants.poisson);
  EXPECT_EQ(by_file.density, by_constants.density);
  EXPECT_EQ(given["rms_px"], typed["rms_px"]);
  EXPECT_EQ(given["damping_time_s"], typed["damping_time_s"]);
  EXPECT_NEAR(given["young_pa"].get<double>(), typed["young_pa"].get<double>(), 1e-6 * typed["young_pa"].get<double>());
}

TEST_F(StartMaterialTest, ThePredictionIsThatOfTheRun) {
  const std::string run = (folder / "small").string();
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(run_quietly({"fit", run, "--initial-material", "predicted"}), 2);
  const std::string said = ::testing::internal::GetCapturedStderr();
  for (const char* word : {"--initial-material predicted", "`pliant predict`"})
    EXPECT_NE(said.find(word), std::string::npos) << said;
  ASSERT_EQ(run_quietly({"predict", run, "--label", "potted flower"}), 0);
  const MaterialFile predicted = read_material(object / "predicted.h5");
  fitted({"--initial-material", "predicted"});
  const MaterialFile found = read_material(object / "material.h5");
  ASSERT_EQ(found.young.size(), predicted.young.size());
  const double factor = double(found.young[0]) / predicted.young[0];
  for (size_t s = 0; s < found.young.size(); ++s) ASSERT_NEAR(found.young[s] / predicted.young[s] / factor, 1, 1e-5);
  EXPECT_EQ(found.density, predicted.density);
}

TEST_F(StartMaterialTest, WithoutDensityAndPoissonsRatioAMotionWithoutPhysicsIsFittedAndOthersSayWhatHelps) {
  const RunDirectory bare = RunDirectory::open(folder / "small");
  Scene scene = load_run_scene(bare);
  scene.settings.material = {};
  FitStage stage;
  stage.recipe = "dreamgaussian4d";
  const ParticleFile particles = read_particles(object / "particles.h5");
  EXPECT_FALSE(start_material(inputs_of(bare, scene, stage), particles).given);
  stage.recipe = "search";
  expect_error(
      Failure::kUsage,
      {"--poisson --density", "give --poisson NU --density RHO", "`pliant predict`", "--initial-material predicted"},
      [&] { inputs_of(bare, scene, stage); });
  // That does help.
  ASSERT_EQ(run_quietly({"predict", (folder / "small").string(), "--label", "potted flower"}), 0);
  stage.initial_material = "predicted";
  const RunDirectory predicted = RunDirectory::open(folder / "small");
  EXPECT_TRUE(start_material(inputs_of(predicted, scene, stage), particles).given);
}

}  // namespace
}  // namespace pliant
