// What a session takes over from a simulation: its material, what stands there all the time, and where it starts.

#include "app/simulate/session_body.h"

#include "app/import/material_fields.h"
#include "app/live/live_scene.h"
#include "app/store/material.h"
#include "physics/simulate/session.h"
#include "tests/app/simulate/bar_run.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class SessionBody : public BarRun {
 protected:
  static json row_of(const char* type, json keys) {
    keys["type"] = type;
    return keys;
  }
  static json foot() { return json::parse(kFoot); }

  SessionSetup setup(const ParticleFile& particles) const {
    const RunDirectory directory = RunDirectory::open(folder_ / "run");
    MovingScene moving;
    moving.particles = particles;
    moving.trajectory = motion();
    return session_setup(directory, load_run_scene(directory), moving);
  }
  SessionSetup setup() const { return setup(particles_); }
  Particles body(const SessionSetup& setup) const {
    return make_body(particles_, load_run_scene(RunDirectory::open(folder_ / "run")), setup.solid, setup.material)
        .particles;
  }

  /// Simulates this script for 0.3 s; why a session is refused.
  std::string refusal(const json& rows, std::vector<std::string> words = {}) {
    words.insert(words.begin(), {"--young", "1e5", "--duration", "0.3", "--interactions", script(rows)});
    EXPECT_EQ(simulate(words), 0) << rows;
    return setup().refused;
  }

  /// Largest distance [m] between the motion and a session in which nothing is done, both from the captured shape.
  double departure() const {
    const SessionSetup setup = this->setup();
    const Particles particles = body(setup);
    Session session(setup.options, particles, setup.held, initial_state(particles));
    float most = 0;
    for (const TrajectoryFile::Frame& frame : motion().frames) {
      for (size_t i = 0; i < particles.size(); ++i)
        most = std::max(most, (session.state().x[i] - frame.position[i]).norm());
      session.advance();
    }
    return most;
  }
};

TEST_F(SessionBody, AnEGivenBesideAFitIsThatOfTheSessionAndOfTheExport) {
  make(true);
  const size_t count = particles_.solid_position.size();
  const std::vector<float> fitted(count, 5e4f), poisson(count, 0.3f), density(count, 500);
  write_material(object() / "material.h5", {fitted, poisson, density, "fitted", {}, {}}, "{}");
  json record = json::parse(read_text(folder_ / "run/run.json"));
  record["stages"]["fit"] = finished_stage(json::object(), json::array({"objects/1_bar/material.h5"}));
  write_text(folder_ / "run/run.json", record.dump());
  for (const char* young : {"5000", "500000"}) {
    ASSERT_EQ(simulate({"--young", young, "--duration", "0.05", "--interactions", script(json::array())}), 0);
    EXPECT_EQ(setup().solid.young, std::vector<float>(count, std::stof(young)));
    const fs::path file = folder_ / (std::string(young) + ".ply");
    ASSERT_EQ(run_quietly({"export", run(), "--material", file.string()}), 0);
    EXPECT_FLOAT_EQ(read_material_field(file).young.at(0), std::stof(young));
  }
  EXPECT_EQ(read_material(object() / "material.h5").young, fitted);
  // It is that of any particles.
  ParticleFile fewer = particles_;
  fewer.solid_position.resize(count / 2);
  EXPECT_EQ(setup(fewer).solid.density, std::vector<float>(count / 2, 500));
}

TEST_F(SessionBody, AMotionOfAnotherMaterialOrScaleIsRefused) {
  make(true);
  fs::copy_file(folder_ / "scene.ply", object() / "object.ply");
  const fs::path file = folder_ / "material.h5";
  const auto write_young = [&](float young) {
    const size_t count = particles_.solid_position.size();
    const std::vector<float> poisson(count, 0.3f), density(count, 500);
    write_material(file, {std::vector<float>(count, young), poisson, density, "made", {}, {}}, "{}");
  };
  write_young(1e5f);
  const std::string simulated = read_text(file);
  ASSERT_EQ(run_quietly({"simulate", run(), "--material", file.string(), "--duration", "0.05", "--interactions",
                         script(json::array())}),
            0);
  EXPECT_EQ(setup().refused, "");
  write_young(2e5f);
  expect_error(Failure::kUsage, {"material", "replaced", "pliant simulate"}, [&] { setup(); });
  EXPECT_EQ(run_quietly({"export", run(), "--html", (folder_ / "clip.html").string()}), 2);
  EXPECT_EQ(run_quietly({"export", run(), "--material", (folder_ / "replaced.ply").string()}), 2);
  EXPECT_FALSE(fs::exists(folder_ / "replaced.ply"));
  write_text(file, simulated);
  EXPECT_EQ(setup().refused, "");
  EXPECT_EQ(run_quietly({"export", run(), "--material", (folder_ / "simulated.ply").string()}), 0);
  json record = json::parse(read_text(folder_ / "run/run.json"));
  record["scene"]["metres_per_unit"] = 0.5;
  write_text(folder_ / "run/run.json", record.dump());
  expect_error(Failure::kUsage, {"scale", "replaced", "pliant simulate"}, [&] { setup(); });
}

TEST_F(SessionBody, WhatStandsThereAllTheTimeActsAsInTheSimulation) {
  make(false);
  const std::vector<std::pair<InteractionType, json>> rows = {
      {InteractionType::kGround, row_of("ground", {{"point", {0, 0, -0.005}}})},
      {InteractionType::kPin, row_of("pin", {{"region", foot()}})},
      {InteractionType::kPin, row_of("pin", {{"region", foot()}, {"duration", 0.3}})},
      {InteractionType::kCollider, row_of("collider", {{"region", {{"box", {-1, -1, -1, 1, 1, -0.005}}}}})},
      {InteractionType::kPoke, row_of("poke", {{"radius", 0.05}, {"path", {{0, 0.3, 0.04, -0.055}}}})},
      {InteractionType::kPoke,
       row_of("poke", {{"radius", 0.05}, {"path", {{0, 0.3, 0.04, -0.055}, {0.3, 0.3, 0.04, -0.055}}}})},
      {InteractionType::kGravity, row_of("gravity", {{"acceleration", {1, 0, -4}}})}};
  for (const auto& [type, row] : rows) {
    EXPECT_EQ(refusal(json::array({row}), {"--settle-time", "0"}), "");
    EXPECT_LT(departure(), 1e-5) << row;
    const SessionSetup setup = this->setup();
    if (type == InteractionType::kGravity) {
      EXPECT_TRUE(setup.held.empty());
      EXPECT_EQ(setup.options.gravity, Vec3d(1, 0, -4));
    } else {
      ASSERT_EQ(setup.held.size(), 1u) << row;
      EXPECT_EQ(setup.held[0].type, type);
    }
  }
}

TEST_F(SessionBody, TheSolverIsThatOfTheSimulation) {
  make(true);
  const json pull = row_of("point_force", {{"region", {{"box", {0.2, -1, -1, 1, 1, 1}}}}, {"force", {0, 0, -1}}});
  refusal(json::array({pull}));
  EXPECT_EQ(setup().options.grid, GridKind::kAutomatic);
  refusal(json::array({pull}), {"--solver", "eulerian", "--flip-time", "0.02"});
  EXPECT_EQ(setup().options.grid, GridKind::kEulerian);
  EXPECT_EQ(setup().options.flip_time, 0.02);
  refusal(json::array({pull}), {"--sleep-speed", "0.001"});
  EXPECT_EQ(setup().options.sleep_speed, 0.001);
  // An earlier version did not record it.
  json record = json::parse(read_text(folder_ / "run/run.json"));
  for (const char* key : {"solver", "flip_time_s", "sleep_speed_m_s"})
    record["stages"]["simulate"]["summary"]["session"].erase(key);
  write_text(folder_ / "run/run.json", record.dump());
  EXPECT_EQ(setup().options.sleep_speed, 0);
  EXPECT_EQ(setup().options.grid, GridKind::kAutomatic);
}

TEST_F(SessionBody, WhatTheScriptDoesForATimeIsNotHeld) {
  make(false);
  const json ball = {{"sphere", {2, 2, 2, 0.1}}};
  EXPECT_EQ(refusal({row_of("pin", {{"region", foot()}, {"duration", 0.1}}),
                     row_of("pin", {{"region", foot()}, {"start", 0.1}}),
                     row_of("collider", {{"region", ball}, {"velocity", {0, 0, 1}}, {"duration", 0.1}}),
                     row_of("gravity", {{"acceleration", {0, 0, 0}}, {"duration", 0.1}}),
                     row_of("poke", {{"radius", 0.1}, {"path", {{0, 2, 2, 2}, {1, 2, 2, 1}}}}),
                     row_of("poke", {{"radius", 0.1}, {"path", {{0, 2, 2, 2}, {0.1, 2, 2, 2}}}}),
                     row_of("ground", {{"point", {0, 0, -0.005}}})},
                    {"--settle-time", "0"}),
            "");
  const SessionSetup setup = this->setup();
  ASSERT_EQ(setup.held.size(), 1u);
  EXPECT_EQ(setup.held[0].type, InteractionType::kGround);
  EXPECT_EQ(setup.options.gravity, Vec3d(0, 0, -9.81));
  // Nor where an earlier version did not record how long the motion is.
  json record = json::parse(read_text(folder_ / "run/run.json"));
  record["stages"]["simulate"]["summary"]["session"].erase("duration_s");
  write_text(folder_ / "run/run.json", record.dump());
  EXPECT_EQ(this->setup().held.size(), 1u);
}

TEST_F(SessionBody, TheRowsOfTheScriptThatGoOnAreToldWithTheirNumbers) {
  make(false);
  const json pin = row_of("pin", {{"region", foot()}}), lasting = row_of("pin", {{"region", foot()}, {"duration", 9}}),
             brief = row_of("pin", {{"region", foot()}, {"duration", 0.1}});
  EXPECT_EQ(refusal({brief, pin, lasting}), "");
  const SessionSetup setup = this->setup();
  ASSERT_EQ(setup.script.size(), 2u) << setup.script;
  const size_t held = setup.held.size();
  EXPECT_EQ(setup.script[0], json({{"row", pin}, {"held", held - 2}}));
  EXPECT_EQ(setup.script[1], json({{"row", pin}, {"held", held - 1}})) << "to the end, whenever that is";
}

TEST_F(SessionBody, WhatASessionCannotHaveIsARefusal) {
  make(false);
  const json ball = {{"sphere", {2, 2, 2, 0.1}}}, room = {{"box", {-1, -1, -1, 1, 1, 1}}};
  const auto expect = [&](const char* word, const json& rows, const std::vector<std::string>& words) {
    const std::string why = refusal(rows, words);
    EXPECT_NE(why.find(word), std::string::npos) << "'" << why << "' of " << rows;
  };
  expect("--collide-scene", json::array(), {"--settle-time", "0", "--collide-scene"});
  expect("moves", json::array({row_of("collider", {{"region", ball}, {"angular_velocity", {0, 0, 1}}})}),
         {"--settle-time", "0"});
  expect("moves", json::array({row_of("collider", {{"region", ball}, {"velocity", {0, 0, 1}}})}),
         {"--settle-time", "0"});
  expect("container", json::array({row_of("collider", {{"region", room}, {"container", true}})}),
         {"--settle-time", "0"});
  make(true);
  EXPECT_EQ(refusal(json::array({row_of("gravity", {{"acceleration", {0, 0, -9.81}}})})), "");
  expect("gravity", json::array({row_of("gravity", {{"acceleration", {0, 0, -12}}})}), {});
}

// A body that carries its weight is captured as it is drawn: nothing is deformed at frame 0, and a session stands
// still.
TEST_F(SessionBody, ASolvedRestShapeCountsFromTheCapturedOne) {
  for (const std::vector<std::string>& law : {std::vector<std::string>{"fixed_corotated"},
                                              {"viscoelastic", "--branch-shear", "2e5", "--branch-viscosity", "2e3"}}) {
    make(true);
    std::vector<std::string> words = {"--young", "2e6", "--duration", "0.1", "--rest-shape", "solve", "--interactions"};
    words.insert(words.end(), {script(json::array()), "--law"});
    words.insert(words.end(), law.begin(), law.end());
    ASSERT_EQ(simulate(words), 0) << law[0];
    EXPECT_GT(summary()["rest_shape"]["sag_m"], 1e-3) << law[0];
    const TrajectoryFile all = motion();
    std::vector<DriverFrame> frames;
    for (const TrajectoryFile::Frame& frame : all.frames) frames.push_back({frame.position, frame.F});
    for (const Mat3f& F : frames[0].F) ASSERT_LT((F - Mat3f::Identity()).norm(), 1e-5f) << law[0];
    const SessionSetup setup = this->setup();
    const Particles particles = body(setup);
    for (const size_t f : {size_t{0}, setup.remembers ? 0 : frames.size() - 1}) {
      Session session(setup.options, particles, setup.held, state_of(frames, f, all.fps, 1, particles, all.memory));
      float most = 0;
      for (int frame = 0; frame < 30; ++frame) {
        session.advance();
        for (size_t i = 0; i < particles.size(); ++i)
          most = std::max(most, (session.state().x[i] - particles.position[i]).norm());
      }
      EXPECT_LT(most, 1e-3f) << law[0] << ' ' << f;
    }
  }
}

// A file that a distilled fit wrote may hold a relaxing branch, which a law on the command line leaves out.
TEST_F(SessionBody, ABranchThatDidNotCountIsNotThatOfTheSession) {
  make(true);
  fs::copy_file(folder_ / "scene.ply", object() / "object.ply");
  const size_t count = particles_.solid_position.size();
  const std::vector<float> young(count, 1e5f), poisson(count, 0.3f), density(count, 500);
  const fs::path file = folder_ / "material.h5";
  write_material(file,
                 {young, poisson, density, "made", {}, {}, {}, std::vector<RelaxingBranch>(count, {1e4f, 1e4f, 1e3f})},
                 "{}");
  for (const bool counts : {false, true}) {
    std::vector<std::string> words = {"simulate", run(), "--material", file.string(), "--duration", "0.05"};
    words.insert(words.end(), {"--interactions", script(json::array())});
    if (!counts) words.insert(words.end(), {"--law", "hencky"});
    ASSERT_EQ(run_quietly(words), 0) << counts;
    const SessionSetup setup = this->setup();
    EXPECT_EQ(setup.refused, "");
    EXPECT_EQ(setup.solid.branch.empty(), !counts);
    const RunDirectory directory = RunDirectory::open(folder_ / "run");
    const LiveScene live = load_live_scene(directory, load_run_scene(directory), "here");
    const LiveBody start(live, {0, 0, 0}, "here");
    EXPECT_EQ(start.state.memory.empty(), !counts);
    EXPECT_NO_THROW(Session(setup.options, start.body.particles, setup.held, start.state).advance());
  }
}

// What flowed while the body settled does not spring back.
TEST_F(SessionBody, ALawWithAMemoryStartsWithTheFirstFrameAndWhatItRemembersThere) {
  make(false);
  fs::copy_file(folder_ / "scene.ply", object() / "object.ply");
  const std::string ground = script(json::array({row_of("ground", {{"point", {0, 0, -0.005}}})}));
  std::vector<std::string> words;
  for (const std::vector<std::string>& law : {std::vector<std::string>{"plasticine", "--yield-stress", "200"},
                                              {"viscoelastic", "--branch-shear", "5e3", "--branch-viscosity", "5e4"}}) {
    words = {"--young", "5e3", "--duration", "0.2", "--interactions", ground, "--law"};
    words.insert(words.end(), law.begin(), law.end());
    ASSERT_EQ(simulate(words), 0) << law[0];
    const TrajectoryFile all = motion();
    ASSERT_TRUE(all.memory.has_value());
    const SessionSetup setup = this->setup();
    EXPECT_EQ(setup.refused, "");
    EXPECT_TRUE(setup.remembers);
    EXPECT_EQ(setup.material.branch_viscosity, law[0] == "viscoelastic" ? 5e4 : 0);
    const Particles particles = body(setup);
    std::vector<DriverFrame> frames;
    for (const TrajectoryFile::Frame& frame : all.frames) frames.push_back({frame.position, frame.F});
    const auto departure_from = [&](const TrajectoryFile::Memory& memory) {
      Session session(setup.options, particles, setup.held, state_of(frames, 0, all.fps, 1, particles, memory));
      float most = 0;
      for (const DriverFrame& frame : frames) {
        for (size_t i = 0; i < particles.size(); ++i)
          most = std::max(most, (session.state().x[i] - frame.position[i]).norm());
        session.advance();
      }
      return most;
    };
    const float departure = departure_from(*all.memory);
    EXPECT_LT(departure, 1e-3f) << law[0];
    TrajectoryFile::Memory nothing = *all.memory;
    nothing.F = frames[0].F;
    for (Mat3f& F : nothing.F_viscous) F.setIdentity();
    EXPECT_GT(departure_from(nothing), 2 * departure) << law[0];

    const RunDirectory directory = RunDirectory::open(folder_ / "run");
    const LiveScene live = load_live_scene(directory, load_run_scene(directory), "here");
    EXPECT_EQ(LiveBody(live, {0, 0, 0}, "here").state.memory.size(), particles.size());
    EXPECT_EQ(LiveBody(live, {0, 8, 0}, "here").state.memory.size(), 8u);
    expect_error(Failure::kInput, {"start_frame", "frame 0"}, [&] { LiveBody(live, {0, 0, 1}, "here"); });
  }
  // An earlier version did not write it; simulated again it is there.
  TrajectoryFile old = motion();
  old.memory.reset();
  write_trajectory(object() / "trajectory.h5", old, "{}");
  json record = json::parse(read_text(folder_ / "run/run.json"));
  EXPECT_EQ(record["stages"]["simulate"]["found"].erase("memory"), 1u);
  write_text(folder_ / "run/run.json", record.dump());
  EXPECT_NE(setup().refused.find("earlier version"), std::string::npos);
  ASSERT_EQ(simulate(words), 0);
  EXPECT_EQ(setup().refused, "");
}

TEST_F(SessionBody, AnObjectMayHaveANameThatHdf5DoesNotTake) {
  for (const auto& [name, group] : {std::pair("a/b", "a_b"), std::pair(".", "_"), std::pair("", "_")}) {
    make(false, name);
    ASSERT_EQ(simulate({"--young", "1e5", "--duration", "0.05", "--settle-time", "0", "--interactions",
                        script(json::array())}),
              0);
    EXPECT_EQ(motion().object, group);
  }
}

}  // namespace
}  // namespace pliant
