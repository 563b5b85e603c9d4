// Constants that a guide asks for, as Physics3D and DreamPhysics step: the rule, its ranges, what a guide sees, and a
// fit that is stopped and continued.

#include "fitting/fit/fit_distilled.h"

#include <cmath>
#include <set>
#include <sstream>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "tests/fitting/made_motion.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using namespace fixture;

TEST(DistilledStep, ScalesTheGradientToItsRangeAndStaysWithinBounds) {
  const DistilledFitOptions::Range range{0.1, 10};
  std::vector<double> log10_factor(3, 0.0);
  distilled_step(1, range, std::vector<double>{-1, 0, 3}, log10_factor);
  const double expected[3] = {0.5, 0.25, -0.5};
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(log10_factor[i], expected[i], 1e-12);
  // A thousandth of the gradient is the same step; after three more, both ends are at the bounds.
  for (int k = 0; k < 3; ++k) distilled_step(1, range, std::vector<double>{-1e-3, 0, 3e-3}, log10_factor);
  EXPECT_DOUBLE_EQ(log10_factor[0], 1);
  EXPECT_NEAR(log10_factor[1], 1, 1e-12);
  EXPECT_DOUBLE_EQ(log10_factor[2], -1);
}

TEST(DistilledStep, LeavesConstantsThatTheLossDoesNotTellApart) {
  std::vector<double> log10_factor = {0.2, -0.3};
  distilled_step(1, {0.1, 10}, std::vector<double>{2, 2}, log10_factor);
  EXPECT_EQ(log10_factor, (std::vector<double>{0.2, -0.3}));
}

/// A block that swings, and a program whose derivative by a colour is the colour itself.
class FitDistilled : public testing::Test {
 protected:
  TemporaryFolder folder;
  Motion<float> motion = swinging_block<float>(kFrames - 1);
  ClipTerms drawn;
  static constexpr int kFrames = 6;

  FitDistilled() {
    drawn.drawn = drawn_block<float>(motion.particles, 60, 0.1);
    drawn.guide_camera = block_camera(32, 32, 0.1);
    drawn.guide_weight = 1;
    drawn.guide = guide();
  }
  std::shared_ptr<Guidance> guide() {
    GuidanceOptions options;
    options.command = "sh " + folder
                                  .file("guide.sh", R"(cd "$1"; echo '{"ready": 1, "name": "copy"}'
while read line; do case "$line" in *quit*) exit 0;; esac; echo "$line" >> seen.txt
step=${line##*\"step\":}; step=${step%%[,\}]*}
cp frames.f32 gradient.f32; echo "{\"step\": $step, \"loss\": 2}"; done)")
                                  .string();
    return std::make_shared<Guidance>(options, folder / "work");
  }
  static DistilledFitOptions few(DistilledFitOptions options) {
    options.iterations = 4;
    options.stages = 2;
    return options;
  }
  /// Of a fit that is stopped after two iterations.
  GradientFitState stopped(const DistilledFitOptions& options) {
    GradientFitState kept;
    EXPECT_THROW(fit_distilled(options, motion, drawn, 24, {}, {},
                               [&](const GradientFitState& state) {
                                 kept = state;
                                 return state.rows.size() < 2;
                               }),
                 Error);
    EXPECT_EQ(kept.rows.size(), 2u);
    return kept;
  }
  void relax() {
    std::vector<RelaxingBranch> branch;
    for (size_t i = 0; i < motion.particles.size(); ++i)
      branch.push_back(usual_branch(motion.particles.young[i], motion.particles.poisson[i]));
    give_branches(branch, Material{}, motion.particles);
    motion.start.memory = initial_state(motion.particles).memory;
  }
};

TEST_F(FitDistilled, Physics3dsConstantsVaryWithinTheirRanges) {
  relax();
  const ClipFit fit = fit_distilled(few(DistilledFitOptions::physics3d()), motion, drawn, 24, {});
  ASSERT_EQ(fit.iterations.size(), 4u);
  EXPECT_DOUBLE_EQ(fit.iterations[0].loss, 2);  // the mean of the clips'
  const Particles &before = motion.particles, &after = fit.motion.particles;
  std::set<float> seen[4];
  for (size_t i = 0; i < before.size(); ++i) {
    const Material &was = before.material(i), &is = after.material(i);
    const double factor[4] = {after.young[i] / before.young[i], is.branch_shear / was.branch_shear,
                              is.branch_lambda / was.branch_lambda, is.branch_viscosity / was.branch_viscosity};
    const double low[4] = {0.5, 0.02, 0.02, 1}, high[4] = {2, 2, 2, 1000};
    for (int c = 0; c < 4; ++c) {
      EXPECT_GE(factor[c], low[c] * (1 - 1e-5));
      EXPECT_LE(factor[c], high[c] * (1 + 1e-5));
      seen[c].insert(static_cast<float>(factor[c]));
    }
  }
  for (const auto& factors : seen) EXPECT_GT(factors.size(), before.size() / 10);
}

TEST_F(FitDistilled, AGuideSeesInterleavedClipsOfTheFrames) {
  fit_distilled(few({}), motion, drawn, 24, {});
  drawn.guide.reset();
  std::istringstream lines(read_text(folder / "work/seen.txt"));
  int steps = 0;
  for (std::string line; std::getline(lines, line); ++steps)
    for (const char* words : {"\"shape\":[3,32,32,3]", "\"fps\":12.0"})  // every other frame of 24 a second
      EXPECT_NE(line.find(words), std::string::npos) << line;
  EXPECT_EQ(steps, 2 * 4);
}

TEST_F(FitDistilled, DreamphysicsAsksTwiceAndFindsNothingInAMotionThatStandsStill) {
  motion.start = initial_state(motion.particles);
  const ClipFit fit = fit_distilled(few(DistilledFitOptions::dreamphysics()), motion, drawn, 24, {});
  EXPECT_DOUBLE_EQ(fit.iterations.back().loss, 0);
  EXPECT_EQ(fit.motion.particles.young, motion.particles.young);
}

TEST_F(FitDistilled, DreamphysicsAsksAboutAClipAndItsStillFramesUnderOneNumber) {
  fit_distilled(few(DistilledFitOptions::dreamphysics()), motion, drawn, 24, {});
  drawn.guide.reset();
  std::istringstream lines(read_text(folder / "work/seen.txt"));
  int asked = 0;
  for (std::string line; std::getline(lines, line); ++asked)
    EXPECT_NE(line.find("\"step\":" + std::to_string(asked / 2) + "}"), std::string::npos) << line;
  EXPECT_EQ(asked, 2 * 2 * 4);
}

// DreamPhysics' paper: E is a network of places.
TEST_F(FitDistilled, ANetworkVariesWithinItsRangeAndGoesOnFromWhereItWasStopped) {
  DistilledFitOptions options = few(DistilledFitOptions::dreamphysics());
  options.network = true;
  const ClipFit whole = fit_distilled(options, motion, drawn, 24, {});
  std::set<float> seen;
  for (size_t i = 0; i < motion.particles.size(); ++i) {
    const float factor = whole.motion.particles.young[i] / motion.particles.young[i];
    EXPECT_GT(factor, 0.005f);
    EXPECT_LT(factor, 2);
    seen.insert(factor);
  }
  EXPECT_GT(seen.size(), motion.particles.size() / 10);
  EXPECT_EQ(fit_distilled(options, motion, drawn, 24, stopped(options)).motion.particles.young,
            whole.motion.particles.young);
  options.seed = 1;
  EXPECT_NE(fit_distilled(options, motion, drawn, 24, {}).motion.particles.young, whole.motion.particles.young);
}

TEST_F(FitDistilled, StoppedAndContinuedItGivesTheBitsOfTheWhole) {
  relax();
  const DistilledFitOptions options = few(DistilledFitOptions::physics3d());
  const ClipFit whole = fit_distilled(options, motion, drawn, 24, {});
  const ClipFit rest = fit_distilled(options, motion, drawn, 24, stopped(options));
  EXPECT_EQ(rest.motion.particles.young, whole.motion.particles.young);
  for (size_t i = 0; i < motion.particles.size(); ++i)
    EXPECT_EQ(rest.motion.particles.material(i).branch_viscosity, whole.motion.particles.material(i).branch_viscosity);
}

TEST(UsualBranch, RelaxesInAHundredthOfASecond) {
  const RelaxingBranch branch = usual_branch(1e5, 0.3);
  EXPECT_NEAR(branch.viscosity / (2 * branch.shear), 0.01, 1e-6);
  EXPECT_NEAR(branch.shear, 1e5 / 2.6, 1);
}

}  // namespace
}  // namespace pliant
