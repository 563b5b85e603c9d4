// The solver of clip.html against the native one, run in node.

#include <tuple>

#include "app/simulate/driver_level.h"
#include "tests/app/page/page_solver_case.h"
#include "tests/app/page/two_sheets.h"

namespace pliant {
namespace {

// The same sources with the same rounding: only functions of the mathematical library differ.
TEST_F(PageSolver, GivesTheBitsOfTheNativeBaselineSolver) {
  setenv("PLIANT_INSTRUCTION_SET", "baseline", 1);
  constexpr double kViscous = 2e-3;  // s
  for (const auto& [law, slit, viscosity_time] :
       {std::tuple(Law::kFixedCorotated, false, 0.0), std::tuple(Law::kFixedCorotated, true, 0.0),
        std::tuple(Law::kFixedCorotated, false, kViscous), std::tuple(Law::kNeoHookean, false, 0.0),
        std::tuple(Law::kHencky, false, 0.0)}) {
    PageSolverCase c(law, viscosity_time);
    if (slit) c.slit();
    json description = described(c);
    description["script"] = json::array();
    const std::vector<float> expected = native(c, description["script"]);
    const json printed = run(description);
    ASSERT_FALSE(printed.contains("error")) << printed;
    const std::vector<float> computed = result();
    ASSERT_EQ(computed.size(), expected.size());
    double largest = 0, moved = 0;
    bool equal = true;
    const size_t frame = expected.size() / kFrames;
    for (size_t k = 0; k < expected.size(); ++k) {
      if (k % frame >= 3 * c.particles.size()) continue;
      equal = equal && std::memcmp(&computed[k], &expected[k], sizeof(float)) == 0;
      largest = std::max(largest, static_cast<double>(std::abs(computed[k] - expected[k])));
      moved = std::max(moved, static_cast<double>(std::abs(expected[k] - expected[k % frame])));
    }
    std::printf("[ law %d%s%s ] %s substeps, largest difference %.2g m, motion %.2g m, %s\n", static_cast<int>(law),
                slit ? ", slit" : "", viscosity_time > 0 ? ", viscous" : "", printed["substeps"].dump().c_str(),
                largest, moved, equal ? "equal bit for bit" : "not equal");
    EXPECT_GT(moved, 0.005) << "it moves";
    EXPECT_LE(largest, 1e-5 * 0.08);
    EXPECT_TRUE(equal || law == Law::kHencky) << "a law without transcendental functions";
  }
  unsetenv("PLIANT_INSTRUCTION_SET");
}

TEST_F(PageSolver, MovesABodyThatNeedsManySubstepsAtRest) {
  PageSolverCase c(Law::kFixedCorotated);
  for (float& young : c.particles.young) young = 5e9f;
  json description = described(c);
  description["script"] = {{{"frame", 1}, {"set", {4, 0.4, 0, 0, -9.81}}}};
  description["frames"] = 2;
  const json printed = run(description);
  ASSERT_FALSE(printed.contains("error")) << printed;
  EXPECT_GT(printed["substeps"].get<int>(), 2 * 2000);
}

TEST_F(PageSolver, HasTheGridAndTheTransfersOfTheSimulation) {
  setenv("PLIANT_INSTRUCTION_SET", "baseline", 1);
  std::vector<float> usual;
  for (const bool others : {false, true}) {
    PageSolverCase c(Law::kFixedCorotated);
    if (others) {
      c.options.grid = GridKind::kEulerian;
      c.options.flip_time = 0.05;
      c.options.sleep_speed = 1e-4;
    }
    json description = described(c);
    description["script"] = json::array();
    const std::vector<float> expected = native(c, description["script"]);
    const json printed = run(description);
    ASSERT_FALSE(printed.contains("error")) << printed;
    const std::vector<float> computed = result();
    ASSERT_EQ(computed.size(), expected.size());
    for (size_t k = 0; k < expected.size(); ++k) ASSERT_NEAR(computed[k], expected[k], 1e-5) << k;
    EXPECT_NE(computed, usual);
    usual = computed;
  }
  unsetenv("PLIANT_INSTRUCTION_SET");
}

// Equilibrium: a bar whose foot was let go weighs nothing for another pin, also in the instance that goes on after a
// failure.
TEST_F(PageSolver, AfterAFailureTheBodyStillIsOneThatWasHeldAsItWasCaptured) {
  PageSolverCase c(Law::kFixedCorotated);
  c.options.damping_time = 0.05;
  c.held.resize(1);
  Interaction top = c.held[0];
  top.region = Region::half_space(Vec3d(0, 0, 0.065), Vec3d(0, 0, -1));
  const double weight = 9.81 * c.particles.total_mass();
  for (const bool held : {true, false}) {
    if (!held) c.held.clear();
    json description = described(c);
    for (const auto& [command, frames] :
         {std::pair(json({"end", 0}), 1), {{"set", 1e6, 0.05, 0, 0, -9.81}, 1}, {{"begin", 5, numbers_of(top)}, 120}})
      description["steps"].push_back({{"commands", json::array({command})}, {"frames", frames}});
    const json answers = run(description);
    ASSERT_EQ(answers.size(), 3u) << answers;
    EXPECT_TRUE(answers[1]["failed"].is_string()) << answers;
    ASSERT_EQ(answers[2]["forces"].size(), 1u) << answers;
    EXPECT_NEAR(answers[2]["forces"][0][3], held ? 0 : weight, 0.03 * weight) << answers;
  }
}

/// Numbers of an array in an unpacked file.
template <class V>
std::vector<V> array_of(const ClipFile& file, const std::string& name) {
  for (const json& row : file.header["arrays"]) {
    if (row["name"] != name) continue;
    size_t count = 1;
    for (const size_t extent : row["shape"]) count *= extent;
    std::vector<V> out(count);
    const std::string& bytes = file.sections.at(row["section"].get<std::string>());
    std::memcpy(out.data(), bytes.data() + row["offset"].get<size_t>(), count * sizeof(V));
    return out;
  }
  ADD_FAILURE() << "no array " << name;
  return {};
}

std::vector<float> flat(const std::vector<Vec3f>& points) {
  std::vector<float> out;
  for (const Vec3f& x : points) out.insert(out.end(), x.data(), x.data() + 3);
  return out;
}

// A rigid motion, which is carried as it is, and one that shears and turns, which is carried as natively.
TEST_F(PageSolver, ACoarserBodyIsCarriedAsByTheNativeProgram) {
  constexpr double kJitter = 0.3;  // of a lattice: every driver hangs together with those around it
  MovingScene moving;
  ParticleFile level;
  const std::vector<Vec3f>& from = moving.particles.driving_position =
      fixture::block<float>({0.06, 0.04, 0.08}, 0.02, kJitter).position;
  level.driving_position = fixture::block<float>({0.06, 0.04, 0.08}, 0.04, kJitter).position;
  const Mat3f turn = Eigen::AngleAxisf(1.2f, Vec3f(1, 2, 3).normalized()).toRotationMatrix();
  const Vec3f by(0.1f, -0.2f, 0.3f);
  TrajectoryFile::Frame rigid, bent;
  for (const Vec3f& x : from) {
    rigid.position.push_back(turn * x + by);
    rigid.F.push_back(turn);
    bent.position.push_back(turn * Vec3f(x.x() + 8 * x.z() * x.z(), x.y(), x.z() * (1 + 2 * x.y())));
    Mat3f F;
    F << 1, 0, 16 * x.z(), 0, 1, 0, 0, 2 * x.z(), 1 + 2 * x.y();
    bent.F.push_back(turn * F);
  }
  moving.trajectory.frames = {rigid, bent};
  const std::vector<DriverFrame> natively = motion_of(moving, level);
  const size_t n = level.driving_position.size();
  const Binding binding = bind_level(moving.particles, level);
  std::vector<uint16_t> driver;  // as add_binding writes them
  for (const int d : binding.driver) driver.push_back(static_cast<uint16_t>(d));
  for (size_t t = 0; t < 2; ++t) {
    const TrajectoryFile::Frame& frame = moving.trajectory.frames[t];
    std::vector<float> gradients, expected = flat(natively[t].position);
    append_rows(gradients, frame.F);
    append_rows(expected, natively[t].F);
    const json printed = run({{"carry",
                               {{"rest", flat(level.driving_position)},
                                {"from", flat(from)},
                                {"driver", driver},
                                {"weight", binding.weight},
                                {"positions", flat(frame.position)},
                                {"gradients", gradients}}}});
    ASSERT_TRUE(printed.is_object()) << printed;
    const std::vector<float> carried = result();
    ASSERT_EQ(carried.size(), 12 * n);
    for (size_t k = 0; k < carried.size(); ++k) EXPECT_NEAR(carried[k], expected[k], k < 3 * n ? 1e-6 : 1e-5) << t;
    if (t > 0) continue;
    for (size_t i = 0; i < n; ++i) {
      const Vec3f x = turn * level.driving_position[i] + by;
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(carried[3 * i + c], x[c], 1e-6) << i;
    }
  }
}

// Of two sheets that lie closer than the drivers of the coarser body, one is lifted and the other stays.
TEST_F(PageSolver, ACoarserBodyIsCarriedByTheDriversThatItHangsTogetherWith) {
  constexpr float kLift = 0.3f;
  const ParticleFile sheets = two_sheets();
  const SolverLevel coarser{60, with_drivers(sheets, Scene(), 60), {}, {}};
  const std::vector<Vec3f>&from = sheets.driving_position, &rest = coarser.file.driving_position;
  ASSERT_LT(rest.size(), from.size());
  SessionSetup setup;
  setup.solid = {std::vector<float>(from.size(), 2e4f), std::vector<float>(from.size(), 0.3f),
                 std::vector<float>(from.size(), 800)};
  ClipFile file;
  file.header["levels"] = json::array({json::object()});
  add_solver(file, {0, sheets, {}, {}}, setup, Scene(), {&coarser, 1});
  std::vector<Vec3f> lifted = from;
  for (size_t i = 0; const int sheet : sheets_of_drivers(sheets)) lifted[i++].z() += sheet == 2 ? kLift : 0;
  std::vector<float> gradients;
  append_rows(gradients, std::vector<Mat3f>(from.size(), Mat3f::Identity()));
  const json printed = run({{"carry",
                             {{"rest", flat(rest)},
                              {"from", flat(from)},
                              {"driver", array_of<uint16_t>(file, "level1.from.driver")},
                              {"weight", array_of<uint8_t>(file, "level1.from.weight")},
                              {"positions", flat(lifted)},
                              {"gradients", gradients}}}});
  ASSERT_TRUE(printed.is_object()) << printed;
  const std::vector<float> carried = result();
  ASSERT_EQ(carried.size(), 12 * rest.size());
  const std::vector<int> sheet = sheets_of_drivers(coarser.file);
  for (size_t i = 0; i < rest.size(); ++i) {
    ASSERT_NE(sheet[i], 3) << i;
    const Vec3f by = Eigen::Map<const Vec3f>(&carried[3 * i]) - rest[i];
    EXPECT_LT((by - Vec3f(0, 0, sheet[i] == 2 ? kLift : 0)).norm(), 1e-5f) << i;
  }
}

TEST_F(PageSolver, WhereTooFewParticlesCarryAWeightThePageOnlyPlays) {
  PageSolverCase c(Law::kFixedCorotated);
  EXPECT_TRUE(solver_header(c).is_object());
  c.held.back().region = Region::sphere(Vec3d(5, 5, 5), 0.01);
  EXPECT_TRUE(solver_header(c).is_null());
}

TEST_F(PageSolver, ErrorsReachThePageWithTheirText) {
  const PageSolverCase c(Law::kFixedCorotated);
  json description = described(c);
  Interaction nowhere = c.grab;
  nowhere.region = Region::sphere(Vec3d(5, 5, 5), 0.01);
  description["script"] = {{{"frame", 0}, {"begin", numbers_of(nowhere)}}};
  const json printed = run(description);
  ASSERT_TRUE(printed.contains("error"));
  EXPECT_NE(printed["error"].get<std::string>().find("touches no particle"), std::string::npos) << printed;
}

}  // namespace
}  // namespace pliant
