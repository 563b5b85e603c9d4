#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/page/interaction_numbers.h"
#include "app/page/material_numbers.h"
#include "app/page/page_assets.h"
#include "app/page/page_solver.h"
#include "gaussians/io/files/files.h"
#include "physics/mpm/whole_deformation.h"
#include "physics/simulate/session.h"
#include "tests/physics/shapes.h"
#include "tests/temporary_folder.h"

namespace pliant {

using nlohmann::json;

inline constexpr int kFrames = 30;

/// A bar, pinned at its foot over a floor, that is grabbed, blown at and made softer.
struct PageSolverCase {
  SimulateOptions options;
  Particles particles;
  std::vector<Interaction> held;
  Interaction grab, wind;

  explicit PageSolverCase(Law law, double viscosity_time = 0) : PageSolverCase(material_of_law(law, viscosity_time)) {}

  explicit PageSolverCase(const Material& material) {
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

/// What the header of a page says of the solver.
inline json solver_header(const PageSolverCase& c) {
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

inline void append_rows(std::vector<float>& out, const std::vector<Mat3f>& matrices) {
  for (const Mat3f& F : matrices)
    for (int k = 0; k < 9; ++k) out.push_back(F(k / 3, k % 3));
}

/// How a page begins in this state: {x, v, F, memory}.
inline json start_json(const SimulationState& state) {
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
inline std::vector<float> native(const PageSolverCase& c, const SimulationState& start, json& script) {
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
inline std::vector<float> native(const PageSolverCase& c, json& script) {
  return native(c, initial_state(c.particles), script);
}

class PageSolver : public ::testing::Test {
 protected:
  void SetUp() override {
    if (solver_module().empty()) GTEST_SKIP() << "this build has no solver for pages (clang-14 and wasi-libc)";
    if (std::system("node --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "node is not installed";
    write_text(folder_ / "solver.wasm", std::string(solver_module()));
  }

  static json described(const PageSolverCase& c) {
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
inline double largest_difference(const std::vector<float>& a, const std::vector<float>& b, size_t particles) {
  double largest = 0;
  for (size_t k = 0; k < a.size(); ++k)
    if (k % (a.size() / kFrames) < 3 * particles)
      largest = std::max(largest, static_cast<double>(std::abs(a[k] - b[k])));
  return largest;
}

}  // namespace pliant
