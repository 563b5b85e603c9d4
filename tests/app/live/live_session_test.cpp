#include "app/live/live_session.h"

#include <gtest/gtest.h>

#include <cstring>
#include <tuple>

#include "app/live/live_messages.h"
#include "app/page/interaction_numbers.h"
#include "gaussians/base/error.h"
#include "gaussians/base/random.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

using nlohmann::json;

/// A bar, pinned at its foot.
struct PlayedBar {
  SimulateOptions options;
  Particles particles = fixture::block<float>({0.03, 0.03, 0.08}, 0.01, 0.5, 2e4, 0.3, 800);
  std::vector<Interaction> held;

  PlayedBar() {
    options.fps = 60;
    options.damping_time = 0.4;
    Interaction pin;
    pin.type = InteractionType::kPin;
    pin.region = Region::half_space(Vec3d(0, 0, 0.015), Vec3d(0, 0, 1));
    held = {pin};
  }
  LiveSession session() const { return {options, particles, held, initial_state(particles)}; }
};

LiveCommand command(const json& value) { return parse_command(value, {1, {0, 0, 1}}, "test"); }

json grab_of(int number, const Vec3d& centre, double radius) {
  Interaction grab;
  grab.type = InteractionType::kGrab;
  grab.region = Region::sphere(centre, radius);
  return {"begin", number, numbers_of(grab)};
}

bool same_bits(const SimulationState& a, const SimulationState& b) {
  return a.size() == b.size() && std::memcmp(a.x.data(), b.x.data(), a.size() * sizeof(Vec3f)) == 0 &&
         std::memcmp(a.v.data(), b.v.data(), a.size() * sizeof(Vec3f)) == 0 &&
         std::memcmp(a.F.data(), b.F.data(), a.size() * sizeof(Mat3f)) == 0;
}

// Replay: the history of a session, given as JSON to another one, gives the same bits, whatever was done.
TEST(LiveSession, WhatWasDoneDoneAgainGivesTheSameBits) {
  const PlayedBar bar;
  LiveSession first = bar.session();
  Random random(7);
  const auto draw = [&] { return 0.02 * random.normal(); };
  std::vector<int> acting;
  int next = 100;
  for (int frame = 0; frame < 90; ++frame) {
    std::vector<LiveCommand> commands;
    if (random.uniform() < 0.15) {
      commands.push_back(command(grab_of(next, {0.015 + draw(), 0.015 + draw(), 0.07}, 0.03)));
      acting.push_back(next++);
    }
    for (const int number : acting)
      if (random.uniform() < 0.5) commands.push_back(command({"drag", number, draw(), draw(), draw()}));
    if (!acting.empty() && random.uniform() < 0.1) {
      commands.push_back(command({"end", acting.back()}));
      acting.pop_back();
    }
    if (random.uniform() < 0.05)
      commands.push_back(command({"set", std::pow(10.0, random.normal() / 3), 0.3, draw(), 0, -9.81}));
    first.step(commands);
  }
  ASSERT_GT(first.history().size(), 40u);
  const json text = json::parse(first.history().dump());
  LiveSession again = bar.session();
  size_t next_row = 0;
  for (int frame = 0; frame < first.frames(); ++frame) {
    std::vector<LiveCommand> commands;
    for (; next_row < text.size() && text[next_row][0] == frame; ++next_row)
      commands.push_back(command(text[next_row][1]));
    again.step(commands);
  }
  EXPECT_TRUE(same_bits(first.state(), again.state()));
  EXPECT_GT((first.state().x.back() - bar.particles.position.back()).norm(), 1e-4f) << "something moved";
}

// To look at a frame under way changes no bit of it, and what is seen after its last time step is the frame.
TEST(LiveSession, AGlanceChangesNothing) {
  enum Kind { kLagrangian, kEulerian, kMetal, kSleeping };
  for (const Kind kind : {kLagrangian, kEulerian, kMetal, kSleeping}) {
    PlayedBar bar;
    if (kind == kEulerian) bar.options.grid = GridKind::kEulerian;
    if (kind == kSleeping) bar.options.sleep_speed = 0.01;
    if (kind == kMetal) {
      bar.particles.materials[0].law = Law::kMetal;
      bar.particles.materials[0].yield_stress = 200;
    }
    LiveSession watched = bar.session(), alone = bar.session();
    const std::vector<LiveCommand> pull = {command(grab_of(7, {0.015, 0.015, 0.07}, 0.03)),
                                           command({"drag", 7, 0.02, 0.01, 0})};
    const json kick = {{"type", "impulse"}, {"region", "all"}, {"impulse", {1e7, 0, 0}}};
    const std::vector<LiveCommand> too_much = {command({"begin", 9, kick})};
    for (int frame = 0; frame < 10; ++frame) {
      const std::vector<LiveCommand> commands = frame == 2 ? pull : frame == 7 ? too_much : std::vector<LiveCommand>();
      std::vector<SimulationState> seen;
      const LiveAnswer answer = watched.step(commands, [&] { seen.push_back(*watched.state_within()); });
      alone.step(commands);
      EXPECT_EQ(answer.failed.empty(), frame != 7);
      ASSERT_GE(seen.size(), static_cast<size_t>(answer.substeps));
      EXPECT_TRUE(same_bits(seen.back(), watched.state())) << kind << " " << frame;
      EXPECT_TRUE(same_bits(watched.state(), alone.state())) << kind << " " << frame;
    }
  }
}

// Who has left waits for no frame; what was ordered before it did not happen.
TEST(LiveSession, AFrameCanBeInterrupted) {
  const PlayedBar bar;
  LiveSession session = bar.session();
  session.step({});
  const SimulationState before = session.state();
  const std::vector<LiveCommand> pull = {command(grab_of(7, {0.015, 0.015, 0.07}, 0.03))};
  int steps = 0;
  EXPECT_THROW(session.step(pull,
                            [&] {
                              if (++steps == 2) throw Error(Failure::kInterrupted, "test", "", "is left", "go on");
                            }),
               Error);
  EXPECT_EQ(steps, 2);
  EXPECT_TRUE(same_bits(before, session.state()));
  EXPECT_EQ(session.frames(), 1);
  EXPECT_TRUE(session.history().empty());
}

// A body that recovers at rest moves in no way, its affine velocity included.
TEST(LiveSession, ABodyThatRecoversAtRestDoesNotSpin) {
  PlayedBar bar;
  bar.options.grid = GridKind::kEulerian;
  bar.options.gravity = {0, 0, 0};
  SimulationState start = initial_state(bar.particles);
  for (size_t i = 0; i < start.size(); ++i) {
    start.v[i] = 1e6f * Vec3f::UnitX();
    start.C[i] = 1e4f * Mat3f::Identity();
  }
  LiveSession session(bar.options, bar.particles, bar.held, start);
  const LiveAnswer answer = session.step({});
  EXPECT_FALSE(answer.failed.empty());
  float fastest = 0;
  for (const Vec3f& v : session.state().v) fastest = std::max(fastest, v.norm());
  EXPECT_LT(fastest, 1e-3f);
}

// The force that is read back is the one that was ordered, in newtons.
TEST(LiveSession, APushIsAsStrongAsItSays) {
  const PlayedBar bar;
  LiveSession session = bar.session();
  const json push = {{"type", "point_force"}, {"region", "all"}, {"force", {0.003, 0, -0.001}}};
  const std::vector<LiveCommand> begin = {command({"begin", 5, push})};
  LiveAnswer answer = session.step(begin);
  answer = session.step({});
  const auto found = std::find_if(answer.forces.begin(), answer.forces.end(), [](auto& f) { return f.first == 5; });
  ASSERT_NE(found, answer.forces.end());
  EXPECT_NEAR((found->second - Vec3d(0.003, 0, -0.001)).norm(), 0, 1e-8);
  session.step(std::vector<LiveCommand>{command({"end", 5})});
  EXPECT_EQ(session.step({}).forces.size(), bar.held.size());
}

// What no solver can follow ends what was begun, not the session.
TEST(LiveSession, GoesOnAfterWhatTheSolverCannotFollow) {
  const PlayedBar bar;
  LiveSession session = bar.session();
  const json push = {{"type", "impulse"}, {"region", "all"}, {"impulse", {1e7, 0, 0}}};
  const LiveAnswer failed = session.step(std::vector<LiveCommand>{command({"begin", 9, push})});
  EXPECT_FALSE(failed.failed.empty());
  for (int frame = 0; frame < 20; ++frame) EXPECT_TRUE(session.step({}).failed.empty());
  for (const Vec3f& x : session.state().x) ASSERT_TRUE(x.allFinite());
  // Moves of what is not there do no harm either.
  session.step(
      std::vector<LiveCommand>{command({"move", 77, 0, 0, 0}), command({"move", 0, 0, 0, 0}), command({"end", 12345})});
  EXPECT_EQ(session.frames(), 22);
}

// Equilibrium: what a pin held as it was captured weighs nothing while another holds it, after a failure as well.
TEST(LiveSession, AfterAFailureTheBodyStillIsOneThatWasHeldAsItWasCaptured) {
  PlayedBar bar;
  bar.options.damping_time = 0.05;
  Interaction top = bar.held[0];
  top.region = Region::half_space(Vec3d(0, 0, 0.065), Vec3d(0, 0, -1));
  const json push = {{"type", "impulse"}, {"region", "all"}, {"impulse", {1e7, 0, 0}}};
  for (const bool held : {true, false}) {
    if (!held) bar.held.clear();
    LiveSession session = bar.session();
    session.step(std::vector<LiveCommand>{command({"end", 0})});
    EXPECT_FALSE(session.step(std::vector<LiveCommand>{command({"begin", 9, push})}).failed.empty());
    LiveAnswer answer = session.step(std::vector<LiveCommand>{command({"begin", 10, numbers_of(top)})});
    for (int frame = 0; frame < 60; ++frame) answer = session.step({});
    ASSERT_EQ(answer.forces.size(), 1u);
    const double weight = 9.81 * bar.particles.total_mass();
    EXPECT_NEAR(answer.forces[0].second.z(), held ? 0 : weight, 0.03 * weight);
  }
}

// What cannot begin is refused by its number; the wind and the settings of the session go on as without it.
TEST(LiveSession, WhatCannotBeginIsRefusedAndAllElseGoesOn) {
  const PlayedBar bar;
  LiveSession session = bar.session(), alone = bar.session();
  const json wind = {{"type", "wind"}, {"wind", {3, 0, 0}}};
  const std::vector<LiveCommand> begin = {command({"set", 0.5, 1, 0, 0, -9.81}), command({"begin", 7, wind})};
  session.step(begin);
  alone.step(begin);
  const std::vector<LiveCommand> bad = {command({"begin", 7, wind}), command(grab_of(8, {5, 5, 5}, 0.01)),
                                        command({"begin", 0, wind})};
  const LiveAnswer answer = session.step(bad);
  alone.step({});
  EXPECT_TRUE(answer.failed.empty()) << answer.failed;
  ASSERT_EQ(answer.refused.size(), 3u);
  for (const auto& [k, number, why] : {std::tuple(0, 7, "in use"), {1, 8, "region"}, {2, 0, "from the start"}}) {
    EXPECT_EQ(answer.refused[k].first, number);
    EXPECT_NE(answer.refused[k].second.find(why), std::string::npos) << answer.refused[k].second;
  }
  EXPECT_EQ(answer.forces.size(), bar.held.size() + 1);
  EXPECT_TRUE(same_bits(session.state(), alone.state()));
}

TEST(LiveSession, ANumberIsFreeAgainWhenItsDurationHasPassed) {
  const PlayedBar bar;
  LiveSession session = bar.session();
  const json push = {{"type", "point_force"}, {"region", "all"}, {"force", {0.003, 0, 0}}, {"duration", 0.04}};
  const json kick = {{"type", "impulse"}, {"region", "all"}, {"impulse", {1e-5, 0, 0}}};
  for (int k = 0; k < 70; ++k) {
    const LiveAnswer answer = session.step(std::vector<LiveCommand>{command({"begin", k % 3 == 0 ? 5 : 1000 + k, push}),
                                                                    command({"begin", 2000 + k, kick})});
    EXPECT_TRUE(answer.failed.empty() && answer.refused.empty()) << k;
  }
  for (int k = 0; k < 3; ++k) session.step({});
  EXPECT_EQ(session.step({}).forces.size(), bar.held.size()) << "nothing is left of them";
}

// A hundred times the stiffness, the slider's end, only takes longer, however many particles there are; a million times
// would take minutes a frame and is given up.
TEST(LiveSession, AStifferBodyTakesMoreSubstepsUpToALimit) {
  PlayedBar bar;
  bar.particles = fixture::block<float>({0.14, 0.14, 0.28}, 0.01, 0.5, 2e4, 0.3, 800);
  ASSERT_GT(bar.particles.size(), 40000u);
  LiveSession session = bar.session();
  const int soft = session.step({}).substeps;
  LiveAnswer answer = session.step(std::vector<LiveCommand>{command({"set", 100, 0.4, 0, 0, -9.81})});
  EXPECT_TRUE(answer.failed.empty()) << answer.failed;
  EXPECT_NEAR(answer.substeps, 10 * soft, 10);
  answer = session.step(std::vector<LiveCommand>{command({"set", 1e6, 0.4, 0, 0, -9.81})});
  EXPECT_FALSE(answer.failed.empty());
  EXPECT_EQ(answer.substeps, soft);
}

TEST(LiveCommand, RefusesWhatIsNoCommand) {
  const json good = grab_of(3, {0, 0, 0}, 0.01);
  EXPECT_NO_THROW(command(good));
  ASSERT_EQ(good[2].size(), 22u) << "as the protocol says";
  json longer = good, shorter = good;
  longer[2].push_back(0);
  shorter[2].erase(size_t{21});
  std::vector<json> bad = {nullptr,
                           3,
                           "begin",
                           json::array(),
                           {"begin"},
                           {"begin", 1},
                           {"begin", 1, 2},
                           {"begin", -1, good[2]},
                           {"begin", 1.5, good[2]},
                           {"begin", 1, {{"type", "nothing"}}},
                           {"begin", 1, json::array({1, 2})},
                           longer,
                           shorter,
                           {"move", 1, 0, 0},
                           {"move", 1, 0, 0, "x"},
                           {"move", 1, 0, 0, 1e300},
                           {"drag", "1", 0, 0, 0},
                           {"end"},
                           {"end", 1, 2},
                           {"set", 0, 0, 0, 0, 0},
                           {"set", 1, -1, 0, 0, 0},
                           {"set", 1, 1, 0, 0},
                           {"fly", 1}};
  for (const size_t at : {0u, 2u, 20u})  // type, kind of region, contact
    for (const double value : {-1.0, 99.0, 0.5}) {
      json row = good;
      row[2][at] = value;
      bad.push_back(row);
    }
  json negative = good;
  negative[2][9] = -0.01;  // radius
  bad.push_back(negative);
  for (const json& value : bad) EXPECT_THROW(command(value), Error) << value;
}

// A grab as a row of interactions.json takes hold where its region is now; lengths are in scene units.
TEST(LiveCommand, RowsAreInSceneUnits) {
  const json row = {{"type", "grab"}, {"region", {{"sphere", {1, 2, 3, 0.5}}}}, {"max_force", 2}};
  const LiveCommand parsed = parse_command({"begin", 4, row}, {0.1, {0, 0, 1}}, "test");
  EXPECT_TRUE(parsed.interaction.path.empty());
  EXPECT_NEAR((parsed.interaction.region.point - Vec3d(0.1, 0.2, 0.3)).norm(), 0, 1e-12);
  EXPECT_NEAR(parsed.interaction.region.radius, 0.05, 1e-12);
  EXPECT_EQ(parsed.interaction.max_force, 2);
}

}  // namespace
}  // namespace pliant
