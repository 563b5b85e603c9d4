// The laws that yield, flow and relax in the solver of clip.html against the native one, run in node.

#include "tests/app/page/page_solver_case.h"

namespace pliant {
namespace {

/// A material whose law gives way under the loads of a PageSolverCase.
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

TEST_F(PageSolver, HasTheLawsThatYieldFlowAndRelax) {
  setenv("PLIANT_INSTRUCTION_SET", "baseline", 1);
  for (const Law law :
       {Law::kMetal, Law::kSand, Law::kSnow, Law::kFoam, Law::kPlasticine, Law::kFluid, Law::kViscoelastic}) {
    const PageSolverCase c(yielding(law)), elastic(Law::kHencky);
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

TEST_F(PageSolver, RefusesAStateWithoutWhatTheLawRemembers) {
  json description = described(PageSolverCase(yielding(Law::kMetal)));
  description["script"] = json::array();
  description["start"]["memory"] = json::array();
  const json printed = run(description);
  ASSERT_TRUE(printed.contains("error")) << printed;
  EXPECT_NE(printed["error"].get<std::string>().find("remembers"), std::string::npos) << printed;
}

// A state is whole with what the law remembers: the motion goes on as it would have.
TEST_F(PageSolver, GoesOnWithWhatTheLawRemembers) {
  setenv("PLIANT_INSTRUCTION_SET", "baseline", 1);
  for (const Law law : {Law::kMetal, Law::kSand, Law::kViscoelastic}) {
    PageSolverCase c(yielding(law));
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

}  // namespace
}  // namespace pliant
