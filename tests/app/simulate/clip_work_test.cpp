// A clip that takes long because of its stiffness is announced, with the number of steps that the solver takes.

#include "app/simulate/clip_work.h"

#include <fmt/format.h>

#include "gaussians/base/error.h"
#include "physics/simulate/simulator.h"
#include "tests/app/simulate/bar_run.h"

namespace pliant {
namespace {

TEST(ClipWork, OfAStiffMaterialIsAnnouncedWithItsTimeSteps) {
  Particles bar = fixture::block<float>({0.32, 0.08, 0.08}, 0.02, 0);
  SimulateOptions options;
  options.duration = 4;
  EXPECT_EQ(describe_work(options, bar), "");
  bar.young[3] = 4e13f;
  const double steps = 120 * substeps_at_rest(options, bar);
  const std::string sentence = describe_work(options, bar);
  for (const std::string& part : {std::string("E = 4e+13 Pa"), std::string("cells of 0.02 m"),
                                  fmt::format("{:.3g} steps of {} particles", steps, bar.size()),
                                  std::string("hours on two cores"), std::string("--particles")})
    EXPECT_NE(sentence.find(part), std::string::npos) << part << " in: " << sentence;
  // A short clip is no matter.
  options.duration = 0.04;
  EXPECT_EQ(describe_work(options, bar), "");
}

class ClipWorkBar : public BarRun {};

TEST_F(ClipWorkBar, IsSaidBeforeTheSimulationBegins) {
  make(true);
  testing::internal::CaptureStderr();
  // So stiff that the solver gives up at once.
  const int code = run_pliant({"simulate", run(), "--young", "1e18", "--poisson", "0.3", "--density", "500",
                               "--interactions", script(nlohmann::json::array())});
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_EQ(code, static_cast<int>(Failure::kNumerical)) << said;
  const size_t warned = said.find("E = 1e+18 Pa"), failed = said.find("needs more than the maximum");
  EXPECT_NE(warned, std::string::npos) << said;
  EXPECT_LT(warned, failed) << said;
}

}  // namespace
}  // namespace pliant
