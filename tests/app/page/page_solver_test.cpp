// The solver of clip.html against the native one, run in node.

#include "app/page/page_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>
#include <tuple>

#include "app/page/interaction_numbers.h"
#include "app/page/material_numbers.h"
#include "app/page/page_assets.h"
#include "gaussians/io/files/files.h"
#include "physics/mpm/whole_deformation.h"
#include "physics/simulate/session.h"
#include "tests/physics/shapes.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using nlohmann::json;

constexpr int kFrames = 30;

/// A bar, pinned at its foot over a floor, that is grabbed, blown at and made softer.
struct Case {
  SimulateOptions options;
  Particles particles;
  std::vector<Interaction> held;
  Interaction grab, wind;

  explicit Case(Law law, double viscosity_time = 0) : Case(material_of_law(law, viscosity_time)) {}

  explicit Case(const Material& material) {
    options.fps = 120;
    options.damping_time = 0.4;
    particles = fixture::block<float>({0.03, 0.03, 0.08}, 0.01, 0.5, 2e4, 0.3, 800);
    particles.materials = {material};
    Interaction pin, floor;
    pin.type = InteractionType::kPin;
    pin.region = Region::half_space(Vec3d(0, 0, 0.015), Vec3d(0, 0, 1));
    floor.type = InteractionType::kGround;
    floor.friction = 0.5;
    floor.region = Region::half_space(Vec3d(0, 0, -0.01), Vec3d(0, 0, 1));
    Interaction weight;
    weight.type = InteractionType::kWeight;
    weight.mass = 5e-3;
    weight.region = Region::box(Vec3d(0, 0, 0.07), Vec3d(0.01, 0.03, 0.09));
    held = {pin, floor, weight};
    grab.type = InteractionType::kGrab;
    grab.region = Region::sphere(Vec3d(0.015, 0.015, 0.08), 0.02);
    wind.type = InteractionType::kWind;
    wind.vector = Vec3d(3, 1, 0);
    wind.region = Region::all();
  }

  static Material material_of_law(Law law, double viscosity_time) {
    Material out;
    out.law = law;
    out.viscosity_time = viscosity_time;
    return out;
  }

  /// The bar slit lengthwise down to z = 0.03.
  void slit() {
    const auto& x = particles.position;
    for (int i = 0; i < static_cast<int>(particles.size()); ++i)
      for (int k = i + 1; k < static_cast<int>(particles.size()); ++k)
        if ((x[i] - x[k]).norm() < 0.75f * particles.cell_size &&
            ((x[i].x() < 0.015f) == (x[k].x() < 0.015f) || std::min(x[i].z(), x[k].z()) < 0.03f))
          particles.links.push_back({i, k});
  }
};

/// A material whose law gives way under the loads of a Case.
Material yielding(Law law) {
  Material out;
  out.law = law;
  out.yield_stress = 400;
  out.hardening = law == Law::kMetal ? 500 : law == Law::kPlasticine ? -100 : 0;
  out.plastic_viscosity = 20;
  out.dynamic_viscosity = 0.5;
  out.branch_shear = 5e3;
  out.branch_lambda = 8e3;
  out.branch_viscosity = 200;
  return out;
}

/// What the header of a page says of the solver.
json solver_header(const Case& c) {
  ParticleFile level;
  level.driving_position = level.solid_position = c.particles.position;
  level.driving_volume = level.solid_volume = c.particles.volume;
  for (size_t i = 0; i < c.particles.size(); ++i) level.solid_driver.push_back(static_cast<int>(i));
  level.cell_size = c.particles.cell_size;
  SessionSetup setup;
  setup.options = c.options;
  setup.solid = {c.particles.young, c.particles.poisson, std::vector<float>(c.particles.size(), 800)};
  setup.material = c.particles.materials[0];
  setup.remembers = c.particles.has_memory();
  setup.held = c.held;
  ClipFile file;
  add_solver(file, {0, level, {}, {}}, setup, Scene(), {});
  return file.header["solver"];
}

void append_rows(std::vector<float>& out, const std::vector<Mat3f>& matrices) {
  for (const Mat3f& F : matrices)
    for (int k = 0; k < 9; ++k) out.push_back(F(k / 3, k % 3));
}

/// How a page begins in this state: {x, v, F, memory}.
json start_json(const SimulationState& state) {
  std::vector<float> x, v, F, memory;
  append_rows(F, whole_deformation(state));
  for (size_t i = 0; i < state.size(); ++i) {
    x.insert(x.end(), state.x[i].data(), state.x[i].data() + 3);
    v.insert(v.end(), state.v[i].data(), state.v[i].data() + 3);
    if (state.memory.empty()) continue;
    append_rows(memory, {state.F[i], state.memory[i].F_viscous});
    memory.push_back(state.memory[i].history);
  }
  return {{"x", x}, {"v", v}, {"F", F}, {"memory", memory}};
}

/// Positions and deformation gradients (rows) of every frame, and what was done.
std::vector<float> native(const Case& c, const SimulationState& start, json& script) {
  Session session(c.options, c.particles, c.held, start);
  std::vector<float> out;
  int grab = -1;
  for (int f = 0; f < kFrames; ++f) {
    if (f == 2) {
      grab = session.begin(c.grab);
      script.push_back({{"frame", f}, {"begin", numbers_of(c.grab)}});
    }
    if (f >= 2 && f < 14) {
      const Vec3d hand = session.history()[grab].path.front().position + Vec3d(0.002, 0.001, 0) * (f - 1);
      session.move(grab, hand);
      script.push_back({{"frame", f}, {"move", {grab, hand.x(), hand.y(), hand.z()}}});
    }
    if (f == 10) {
      session.begin(c.wind);
      script.push_back({{"frame", f}, {"begin", numbers_of(c.wind)}});
    }
    if (f == 14) {
      session.end(grab);
      script.push_back({{"frame", f}, {"end", grab}});
    }
    if (f == 20) {
      session.set({0.5, 0.2, Vec3d(0, 0, -5)});
      script.push_back({{"frame", f}, {"set", {0.5, 0.2, 0, 0, -5}}});
    }
    session.advance();
    for (const Vec3f& x : session.state().x) out.insert(out.end(), x.data(), x.data() + 3);
    append_rows(out, whole_deformation(session.state()));
  }
  return out;
}
std::vector<float> native(const Case& c, json& script) { return native(c, initial_state(c.particles), script); }

class PageSolver : public ::testing::Test {
 protected:
  void SetUp() override {
    if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
    if (std::system("node --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "node is not installed";
    write_text(folder_ / "solver.wasm", std::string(solver_module()));
  }

  static json described(const Case& c) {
    json out = {{"solver", solver_header(c)}, {"cell_size", c.particles.cell_size}, {"volume", c.particles.volume},
                {"mass", c.particles.mass},   {"young", c.particles.young},         {"poisson", c.particles.poisson},
                {"frames", kFrames}};
    std::vector<float> position;
    for (const Vec3f& x : c.particles.position) position.insert(position.end(), x.data(), x.data() + 3);
    out["position"] = position;
    std::vector<double> materials;
    for (const Material& material : c.particles.materials) {
      const std::vector<double> row = numbers_of(material);
      materials.insert(materials.end(), row.begin(), row.end());
    }
    out["materials"] = materials;
    out["material"] = c.particles.material_index;
    out["material"].get_ref<json::array_t&>().resize(c.particles.size(), 0);
    out["start"] = start_json(initial_state(c.particles));
    out["links"] = json::array();
    for (const auto& [i, k] : c.particles.links) out["links"].insert(out["links"].end(), {i, k});
    return out;
  }

  json run(const json& described) const {
    write_text(folder_ / "case.json", described.dump());
    const std::string command = "node " + std::string(PLIANT_RUN_SOLVER) + " " + (folder_ / "solver.wasm").string() +
                                " " + (folder_ / "case.json").string() + " " + (folder_ / "out").string();
    FILE* const pipe = popen(command.c_str(), "r");
    std::string text;
    char line[4096];
    while (pipe && std::fgets(line, sizeof line, pipe)) text += line;
    EXPECT_EQ(pclose(pipe), 0) << text;
    return json::parse(text, nullptr, false);
  }
  std::vector<float> result() const {
    const std::string bytes = read_text(folder_ / "out");
    std::vector<float> out(bytes.size() / sizeof(float));
    std::memcpy(out.data(), bytes.data(), bytes.size());
    return out;
  }

  TemporaryFolder folder_;
};

/// Largest distance between two motions of `native` [m].
double largest_difference(const std::vector<float>& a, const std::vector<float>& b, size_t particles) {
  double largest = 0;
  for (size_t k = 0; k < a.size(); ++k)
    if (k % (a.size() / kFrames) < 3 * particles)
      largest = std::max(largest, static_cast<double>(std::abs(a[k] - b[k])));
  return largest;
}

// The same sources with the same rounding: only functions of the mathematical library differ.
TEST_F(PageSolver, GivesTheBitsOfTheNativeBaselineSolver) {
  setenv("PLIANT_INSTRUCTION_SET", "baseline", 1);
  constexpr double kViscous = 2e-3;  // s
  for (const auto& [law, slit, viscosity_time] :
       {std::tuple(Law::kFixedCorotated, false, 0.0), std::tuple(Law::kFixedCorotated, true, 0.0),
        std::tuple(Law::kFixedCorotated, false, kViscous), std::tuple(Law::kNeoHookean, false, 0.0),
        std::tuple(Law::kHencky, false, 0.0)}) {
    Case c(law, viscosity_time);
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

TEST_F(PageSolver, HasTheLawsThatYieldFlowAndRelax) {
  setenv("PLIANT_INSTRUCTION_SET", "baseline", 1);
  for (const Law law :
       {Law::kMetal, Law::kSand, Law::kSnow, Law::kFoam, Law::kPlasticine, Law::kFluid, Law::kViscoelastic}) {
    const Case c(yielding(law)), elastic(Law::kHencky);
    json description = described(c), none;
    description["script"] = json::array();
    const std::vector<float> expected = native(c, description["script"]), others = native(elastic, none);
    const json printed = run(description);
    ASSERT_FALSE(printed.contains("error")) << printed;
    const std::vector<float> computed = result();
    ASSERT_EQ(computed.size(), expected.size());
    const double largest = largest_difference(computed, expected, c.particles.size());
    const double gave_way = largest_difference(expected, others, c.particles.size());
    std::printf("[ %s ] %s substeps, largest difference %.2g m, from the elastic motion %.2g m\n", law_name(law),
                printed["substeps"].dump().c_str(), largest, gave_way);
    EXPECT_GT(gave_way, 0.002) << law_name(law);
    EXPECT_LE(largest, 1e-5 * 0.08) << law_name(law);
  }
  unsetenv("PLIANT_INSTRUCTION_SET");
}

// A state is whole with what the law remembers: the motion goes on as it would have.
TEST_F(PageSolver, GoesOnWithWhatTheLawRemembers) {
  setenv("PLIANT_INSTRUCTION_SET", "baseline", 1);
  for (const Law law : {Law::kMetal, Law::kSand, Law::kViscoelastic}) {
    Case c(yielding(law));
    c.particles.materials.push_back(c.particles.materials[0]);  // half of it yields later and relaxes faster
    c.particles.materials[1].yield_stress *= 2;
    c.particles.materials[1].branch_viscosity /= 2;
    for (const Vec3f& x : c.particles.position) c.particles.material_index.push_back(x.x() < 0.015f ? 0 : 1);
    Session before(c.options, c.particles, c.held, initial_state(c.particles));
    before.set({1, 0.4, Vec3d(5, 0, -20)});
    for (int f = 0; f < 10; ++f) before.advance();
    SimulationState start = initial_state(c.particles);
    start.x = before.state().x;
    start.v = before.state().v;
    start.F = before.state().F;
    start.memory = before.state().memory;
    json description = described(c);
    description["script"] = json::array();
    description["start"] = start_json(start);
    const std::vector<float> expected = native(c, start, description["script"]);
    const json printed = run(description);
    ASSERT_FALSE(printed.contains("error")) << printed;
    EXPECT_LE(largest_difference(result(), expected, c.particles.size()), 1e-5 * 0.08) << law_name(law);
    json script;
    for (LawMemory<float>& memory : start.memory) memory = {memory.F_total};
    const std::vector<float> forgetful = native(c, start, script);
    EXPECT_GT(largest_difference(forgetful, expected, c.particles.size()), 1e-5) << law_name(law);
  }
  unsetenv("PLIANT_INSTRUCTION_SET");
}

TEST_F(PageSolver, MovesABodyThatNeedsManySubstepsAtRest) {
  Case c(Law::kFixedCorotated);
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
    Case c(Law::kFixedCorotated);
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
  Case c(Law::kFixedCorotated);
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

TEST_F(PageSolver, WhereTooFewParticlesCarryAWeightThePageOnlyPlays) {
  Case c(Law::kFixedCorotated);
  EXPECT_TRUE(solver_header(c).is_object());
  c.held.back().region = Region::sphere(Vec3d(5, 5, 5), 0.01);
  EXPECT_TRUE(solver_header(c).is_null());
}

TEST_F(PageSolver, ErrorsReachThePageWithTheirText) {
  const Case c(Law::kFixedCorotated);
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
