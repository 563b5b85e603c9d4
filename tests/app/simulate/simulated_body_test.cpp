// What acts on an object by default: its floor, its damping, and which options it takes.

#include "app/simulate/simulated_body.h"

#include <cmath>

#include "app/simulate/session_body.h"
#include "app/simulate/simulation_plan.h"
#include "tests/app/simulate/bar_run.h"

namespace pliant {
namespace {

using nlohmann::json;

/// A ground through a point [m], tilted by so many degrees.
Interaction ground_at(const Vec3d& point, double degrees = 0, double start = 0) {
  const double angle = degrees * 3.14159265358979324 / 180;
  Interaction ground;
  ground.type = InteractionType::kGround;
  ground.region = Region::half_space(point, Vec3d(std::sin(angle), 0, std::cos(angle)));
  ground.start = start;
  return ground;
}

TEST(Floor, YieldsToAGroundThatIsAboutItsPlaneOrAboveFromTheStart) {
  Scene scene;
  scene.metres_per_unit = 0.5;
  const json found = {{"height", 0.4},
                      {"contact", {{"support", "table"}, {"point", {0.2, 0, 2}}, {"normal", {0, 0, 1}}}}};
  const auto stays = [&](const std::vector<Interaction>& interactions) {
    const auto floor = floor_of(found, interactions, scene);
    EXPECT_EQ(floor ? floor->region.point : Vec3d(0.1, 0, 1), Vec3d(0.1, 0, 1));
    return floor.has_value();
  };
  EXPECT_TRUE(stays({}));
  EXPECT_FALSE(stays({ground_at({3, 3, 1})}));
  EXPECT_FALSE(stays({ground_at({0, 0, 1.5})})) << "above";
  EXPECT_FALSE(stays({ground_at({0, 0, 0.995})})) << "about there";
  EXPECT_FALSE(stays({ground_at({0.1, 0, 1}, 25)})) << "a ramp";
  EXPECT_TRUE(stays({ground_at({0.1, 0, 1}, 35)})) << "a steep ramp";
  EXPECT_TRUE(stays({ground_at({1.1, 0, 0.8}, -25)})) << "a ramp that passes below";
  EXPECT_TRUE(stays({ground_at({-9, 0, 0}, 90)})) << "a wall";
  EXPECT_TRUE(stays({ground_at({0, 0, 0.9})})) << "far below";
  EXPECT_TRUE(stays({ground_at({0, 0, 1}, 0, 0.5)})) << "later";
  EXPECT_FALSE(stays({ground_at({-9, 0, 0}, 90), ground_at({0, 0, 1})}));
  EXPECT_FALSE(floor_of({{"height", 0.4}}, {}, scene).has_value()) << "nothing was found";
}

class SimulatedBar : public BarRun {
 protected:
  /// Vertical speed [m/s] at the end of half a second of falling.
  double fall(std::vector<std::string> words) const {
    words.insert(words.end(), {"--young", "1e5", "--duration", "0.5", "--settle-time", "0", "--interactions",
                               script(json::array())});
    EXPECT_EQ(simulate(words), 0);
    float sum = 0;
    const std::vector<Vec3f> velocity = motion().frames.back().velocity;
    for (const Vec3f& v : velocity) sum += v.z();
    return -sum / static_cast<float>(velocity.size());
  }
};

TEST_F(SimulatedBar, FallsFreelyByDefaultAndDampedWhereThatIsAskedFor) {
  constexpr double kGravity = 9.81, kSeconds = 0.5;
  make(false);
  EXPECT_NEAR(fall({}), kGravity * kSeconds, 1e-3);
  EXPECT_EQ(summary()["damping_time_s"], 0);
  const double limit = 0.5 * kGravity * 0.4;
  EXPECT_NEAR(fall({"--damping-time", "0.4"}), limit * (1 - std::exp(-2 * kSeconds / 0.4)), 0.03);
}

TEST_F(SimulatedBar, IsDampedByDefaultWhereAPinHoldsItAtTheStart) {
  const auto damping = [&](const json& rows) {
    EXPECT_EQ(simulate({"--young", "1e5", "--duration", "0.05", "--settle-time", "0", "--interactions", script(rows)}),
              0);
    return summary()["damping_time_s"].get<double>();
  };
  make(true);
  EXPECT_EQ(damping(json::array()), kDampingTime);
  make(false);
  json pin = {{"type", "pin"}, {"region", json::parse(kFoot)}, {"duration", 0.02}};
  EXPECT_EQ(damping(json::array({pin})), kDampingTime);
  pin["start"] = 0.02;
  EXPECT_EQ(damping(json::array({pin})), 0);
  pin = {{"type", "pin"}, {"region", {{"sphere", {9, 9, 9, 0.1}}}}};
  EXPECT_EQ(damping(json::array({pin})), 0) << "holds nothing";
}

TEST_F(SimulatedBar, RefusesToSolveTheRestShapeOfWhatNothingHolds) {
  make(false);
  const auto code = [&](const json& rows) {
    return simulate({"--young", "2e6", "--duration", "0.02", "--rest-shape", "solve", "--interactions", script(rows)});
  };
  EXPECT_EQ(code(json::array()), static_cast<int>(Failure::kUsage));
  const json pin = {{"type", "pin"}, {"region", json::parse(kFoot)}};
  EXPECT_EQ(code(json::array({pin})), 0);
}

TEST_F(SimulatedBar, SaysThatTheAutomaticPushComesTooLate) {
  make(true);
  std::filesystem::copy_file(folder_ / "scene.ply", object() / "object.ply");
  const auto said = [&](const char* duration) {
    testing::internal::CaptureStderr();
    const int code = run_pliant(
        {"simulate", run(), "--young", "1e6", "--poisson", "0.3", "--density", "500", "--duration", duration});
    const std::string out = testing::internal::GetCapturedStderr();
    EXPECT_EQ(code, 0) << out;
    return out;
  };
  const std::string late = said("0.3");
  EXPECT_NE(late.find("the clip ends before the push begins"), std::string::npos) << late;
  EXPECT_EQ(late.find("size the push"), std::string::npos) << late;
  EXPECT_EQ(said("0.4").find("push begins"), std::string::npos);
}

TEST_F(SimulatedBar, IsInterruptedAlreadyWhileItSettlesForTheAutomaticPush) {
  make(false);
  std::filesystem::copy_file(folder_ / "scene.ply", object() / "object.ply");
  const Scene scene = load_run_scene(RunDirectory::open(folder_ / "run"));
  const SimulatedBody body = make_body(particles_, scene, solid_material(particles_, {1e6, 0.3, 500, {}}), {});
  const json extract = {{"height", 0.08},
                        {"contact", {{"support", "plate"}, {"point", {0, 0, 0}}, {"normal", {0, 0, 1}}}}};
  Progress progress(true);
  int asked = 0;
  const Context context{progress, [&] { return ++asked > 0; }};
  try {
    plan_simulation(context, {{"object", object() / "object.ply"}}, extract, scene, {}, body);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.failure, Failure::kInterrupted);
    EXPECT_EQ(error.where, "simulate") << "not only in the trials of the push";
    EXPECT_EQ(asked, 1);
  }
}

TEST_F(SimulatedBar, StaysWhereNothingHoldsOrStopsItUnlessThatIsAskedFor) {
  make(false);
  std::filesystem::copy_file(folder_ / "scene.ply", object() / "object.ply");
  const auto gravity = [&](std::vector<std::string> words) {
    words.insert(words.end(), {"--young", "1e5", "--duration", "0.4", "--settle-time", "0.1"});
    EXPECT_EQ(simulate(words), 0);
    return summary()["session"]["gravity_m_s2"][2].get<double>();
  };
  EXPECT_EQ(gravity({}), 0);
  ASSERT_FALSE(summary()["push"].is_null());
  const double weightless_newtons = summary()["push"]["newtons"];
  EXPECT_EQ(summary()["settle_displacement_m"], 0);
  EXPECT_EQ(gravity({"--no-floor"}), -9.81);
  EXPECT_NEAR(summary()["push"]["newtons"].get<double>() / weightless_newtons, 1, 0.1) << "inertia alone resists it";
  EXPECT_EQ(summary()["settle_displacement_m"], 0) << "not before the first frame";
  EXPECT_EQ(gravity({"--interactions", script(json::array())}), -9.81);
  EXPECT_EQ(summary()["settle_displacement_m"], 0);
  const json weightless = {{"type", "gravity"}, {"acceleration", {0, 0, 0}}, {"duration", 0.1}};
  EXPECT_EQ(gravity({"--interactions", script(json::array({weightless}))}), -9.81);
  EXPECT_EQ(summary()["settle_displacement_m"], 0) << "nor under the gravity of later";
  const json ground = {{"type", "ground"}, {"point", {0, 0, -0.2}}};
  EXPECT_EQ(gravity({"--interactions", script(json::array({ground}))}), -9.81);
  EXPECT_GT(summary()["settle_displacement_m"], 0.01) << "there is something to fall on";
}

TEST_F(SimulatedBar, IsPushedByAShareOfItsExtentWhereItIsFlat) {
  make(false);
  std::filesystem::copy_file(folder_ / "scene.ply", object() / "object.ply");
  constexpr double kHeight = 1e-4;
  json record = json::parse(read_text(folder_ / "run/run.json"));
  record["stages"]["extract"]["summary"]["height"] = kHeight;
  write_text(folder_ / "run/run.json", record.dump());
  Box box;
  for (const Vec3f& x : particles_.driving_position) box.add(x);
  ASSERT_EQ(simulate({"--young", "1e6", "--duration", "0.9"}), 0);
  const double moved = kHeight * summary()["motion"]["particle_peak"].get<double>();
  EXPECT_NEAR(moved / (0.15 * 0.2 * box.size().norm()), 1, 0.2);
}

TEST_F(SimulatedBar, IsDescribedByInfoAsARun) {
  make(true);
  write_text(folder_ / "run/objects.json", R"([{"id": 1, "name": "bar"}])");
  testing::internal::CaptureStdout();
  const int code = run_pliant({"info", run()});
  const std::string out = testing::internal::GetCapturedStdout();
  EXPECT_EQ(code, 0);
  for (const char* word : {"kind: run directory", "scene.ply", "- extract", "- seed", "- 1 = bar"})
    EXPECT_NE(out.find(word), std::string::npos) << word << " in: " << out;
}

TEST_F(SimulatedBar, IsNoSceneAndNamesItsOwn) {
  make(true);
  testing::internal::CaptureStderr();
  const int code = run_pliant({"segment", run(), "--out", (folder_ / "other").string()});
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_EQ(code, static_cast<int>(Failure::kUsage));
  for (const char* words : {"is a run directory, not a scene", "scene.ply, with --out"})
    EXPECT_NE(said.find(words), std::string::npos) << said;
}

TEST_F(SimulatedBar, SlidesFarOverTheRestOfTheSceneWithoutSinking) {
  make(false);
  GaussianCloud table;
  table.sh_degree = 0;
  for (int i = 0; i < 100; ++i)
    for (int k = 0; k < 24; ++k) {
      const size_t at = table.size();
      table.resize(at + 1);
      table.position[at] = Vec3f(0.02f * static_cast<float>(i) - 0.2f, 0.02f * static_cast<float>(k) - 0.2f, -0.01f);
      table.log_scale[at] = Vec3f(0.012f, 0.012f, 0.002f).array().log();
      table.rotation[at] = Vec4f(1, 0, 0, 0);
      table.opacity_logit[at] = 4;
    }
  std::filesystem::remove(folder_ / "run/background.ply");
  write_ply(folder_ / "run/background.ply", table);
  const json push = {{"type", "gust"}, {"region", "all"}, {"acceleration", {18, 0, 0}}, {"duration", 0.25}};
  ASSERT_EQ(simulate({"--young", "1e6", "--duration", "0.8", "--settle-time", "0", "--collide-scene", "--interactions",
                      script(json::array({push}))}),
            0);
  const std::vector<Vec3f> end = motion().frames.back().position;
  float lowest = 1, least = 9;
  for (const Vec3f& x : end) {
    lowest = std::min(lowest, x.z());
    least = std::min(least, x.x());
  }
  EXPECT_GT(least, 0.32f) << "farther than its size";
  EXPECT_GT(lowest, -0.03f);
}

// The box is given in simulation space, where the Gaussians' box has the configuration's scale and lies about (1, 1,
// 1).
TEST_F(SimulatedBar, KeepsTheMaterialOfTheBoxesOfPhysGaussian) {
  make(false);
  GaussianCloud cloud;
  cloud.sh_degree = 0;
  cloud.resize(particles_.solid_position.size());
  for (size_t i = 0; i < cloud.size(); ++i) {
    cloud.position[i] = particles_.solid_position[i];
    cloud.log_scale[i] = Vec3f::Constant(std::log(0.01f));
    cloud.rotation[i] = Vec4f(1, 0, 0, 0);
    cloud.opacity_logit[i] = 4;
  }
  write_ply(object() / "object.ply", cloud);
  const json config = {{"E", 1e5},
                       {"nu", 0.3},
                       {"density", 200},
                       {"g", {0, 0, 0}},
                       {"frame_dt", 0.02},
                       {"frame_num", 1},
                       {"additional_material_params",
                        {{{"point", {0.5, 1, 1}}, {"size", {0.5, 1, 1}}, {"E", 4e5}, {"nu", 0.2}, {"density", 50}}}}};
  const std::string file = folder_.file("config.json", config.dump()).string();
  ASSERT_EQ(run_quietly({"simulate", run(), "--physgaussian", file}), 0);
  const json session = summary()["session"];
  EXPECT_FALSE(session.contains("uniform"));
  EXPECT_EQ(session["material_file"], "objects/1_bar/material.h5");
  const ElasticSamples solid = simulated_material(RunDirectory::open(run()), session, particles_.solid_position);
  float middle = 0;
  for (const Vec3f& x : particles_.solid_position)
    middle += x.x() / static_cast<float>(particles_.solid_position.size());
  for (size_t i = 0; i < solid.size(); ++i) {
    const bool inside = particles_.solid_position[i].x() < middle;
    EXPECT_EQ(solid.young[i], inside ? 4e5f : 1e5f);
    EXPECT_EQ(solid.poisson[i], inside ? 0.2f : 0.3f);
    EXPECT_EQ(solid.density[i], inside ? 50 : 200);
  }
}

TEST_F(SimulatedBar, RefusesANegativePoissonsRatioBeforeAnythingRuns) {
  make(true);
  const auto code = [&](const std::string& law) {
    return run_quietly({"simulate", run(), "--young", "1e5", "--poisson=-0.5", "--density", "500", "--law", law,
                        "--duration", "0.05", "--interactions", script(json::array())});
  };
  EXPECT_EQ(code("fixed_corotated"), static_cast<int>(Failure::kUsage));
  EXPECT_FALSE(std::filesystem::exists(object() / "material.h5"));
  EXPECT_EQ(code("hencky"), 0);
}

}  // namespace
}  // namespace pliant
