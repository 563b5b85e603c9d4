// A motion without physics is found from what was seen of it, and what is held does not move.

#include "fitting/fit/fit_deformation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fitting/fields/hexplane_field.h"
#include "fitting/fields/triplane_field.h"
#include "fitting/fields/weighted_field.h"
#include "gaussians/base/error.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

constexpr double kAmplitude = 0.01;  // m

/// Mean over frames and particles of the squared distance from where they were seen, over the squared amplitude.
class SeenPlaces : public FrameLoss<float> {
 public:
  explicit SeenPlaces(std::vector<std::vector<Vec3d>> seen) : seen_(std::move(seen)) {}

  double value(int frame, const SimulationState& state) const override {
    StateGradient<float> unused = StateGradient<float>::zero(state.size());
    return value_adjoint(frame, state, 0, unused);
  }
  double value_adjoint(int frame, const SimulationState& state, double adj_value,
                       StateGradient<float>& gradient) const override {
    double sum = 0;
    const double share = 1 / (kAmplitude * kAmplitude * static_cast<double>(seen_.size() * state.size()));
    for (size_t i = 0; i < state.size(); ++i) {
      const Vec3d error = state.x[i].cast<double>() - seen_[frame][i];
      sum += share * error.squaredNorm();
      gradient.x[i] += (2 * share * adj_value * error).cast<float>();
    }
    return sum;
  }

 private:
  std::vector<std::vector<Vec3d>> seen_;  // [frames][N]
};

/// The same of all frames together.
class SeenTogether : public RolloutLoss<float> {
 public:
  explicit SeenTogether(std::shared_ptr<const FrameLoss<float>> of_frame) : of_frame_(std::move(of_frame)) {}

  double value(std::span<const SimulationState> frames) const override {
    double sum = 0;
    for (size_t k = 0; k < frames.size(); ++k) sum += of_frame_->value(static_cast<int>(k), frames[k]);
    return sum;
  }
  double value_adjoint(std::span<const SimulationState> frames, double adj_value,
                       std::span<StateGradient<float>> gradient) const override {
    double sum = 0;
    for (size_t k = 0; k < frames.size(); ++k)
      sum += of_frame_->value_adjoint(static_cast<int>(k), frames[k], adj_value, gradient[k]);
    return sum;
  }

 private:
  std::shared_ptr<const FrameLoss<float>> of_frame_;
};

/// A block 40 mm high, held below 10 mm, whose upper part bends and twists in six frames.
struct BentBlock {
  static constexpr int kFrames = 6;
  Particles particles = fixture::block<float>(Vec3d(0.02, 0.015, 0.04), 0.01, 0.7);
  std::vector<double> free;
  std::vector<std::vector<Vec3d>> seen;
  std::shared_ptr<const FrameLoss<float>> loss;

  BentBlock() {
    for (const Vec3f& x : particles.position) free.push_back(x.z() > 0.01f);
    for (int k = 0; k < kFrames; ++k) {
      const double t = double(k) / (kFrames - 1);
      seen.emplace_back();
      for (const Vec3f& x : particles.position) {
        const double s = std::max(0.0, (x.z() - 0.01) / 0.03);
        const Vec3d u(s * s * std::sin(5 * t), 0.5 * s * std::sin(3 * t), -0.3 * s * s * (1 - std::cos(5 * t)));
        seen.back().push_back(x.cast<double>() + kAmplitude * u);
      }
    }
    loss = std::make_shared<SeenPlaces>(seen);
  }

  WeightedField field() const {
    HexplaneOptions o;
    o.space_resolution = 8;
    o.time_resolution = 6;
    std::vector<double> times;
    for (int k = 0; k < kFrames; ++k) times.push_back(double(k) / (kFrames - 1));
    return {make_hexplane_field(o, particles.position, times), deformation_weight(free, kFrames, kAmplitude)};
  }

  Objective<float> objective() const {
    Objective<float> one;
    one.terms.push_back({1, loss});
    return one;
  }

  double loss_of(const std::vector<SimulationState>& frames) const {
    double sum = 0;
    for (size_t k = 0; k < frames.size(); ++k) sum += loss->value(static_cast<int>(k), frames[k]);
    return sum;
  }
};

class FitDeformationTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_triplane_fields()) GTEST_SKIP() << "built without libtorch";
  }
  BentBlock block;
};

DeformationFitOptions brief(int iterations) {
  DeformationFitOptions options;
  options.iterations = iterations;
  options.fps = 20;
  return options;
}

TEST_F(FitDeformationTest, ASmoothMotionIsFoundAndWhatIsHeldStaysWhereItIs) {
  const WeightedField field = block.field();
  const DeformationFit fit = fit_deformation(brief(200), block.particles, field, block.objective(), {});
  ASSERT_EQ(fit.frames.size(), size_t{BentBlock::kFrames});
  ASSERT_EQ(fit.iterations.size(), 200u);
  EXPECT_GT(std::sqrt(fit.iterations.front().loss), 0.3);
  EXPECT_LT(std::sqrt(block.loss_of(fit.frames)), 0.05);  // of the amplitude, root mean square
  double least = INFINITY;
  for (const GradientFitRow& row : fit.iterations) {
    EXPECT_EQ(row.frames, BentBlock::kFrames - 1);
    least = std::min(least, row.loss);
  }
  EXPECT_EQ(block.loss_of(fit.frames), least);
  size_t held = 0;
  for (const SimulationState& state : fit.frames) {
    const std::vector<Vec3f>& rest = block.particles.position;
    for (size_t i = 0; i < rest.size(); ++i) {
      const bool still = state.frame == 0 || block.free[i] == 0;
      EXPECT_EQ(state.x[i] == rest[i], still) << "frame " << state.frame << ", particle " << i;
      held += still;
    }
  }
  EXPECT_GT(held, 200u);
}

TEST_F(FitDeformationTest, StatesAreUnstrainedAndTheirVelocitiesLeadToTheNextFrame) {
  const WeightedField field = block.field();
  const DeformationFit fit = fit_deformation(brief(10), block.particles, field, block.objective(), {});
  for (int k = 0; k < BentBlock::kFrames; ++k) {
    const SimulationState& state = fit.frames[k];
    const int from = std::min(k, BentBlock::kFrames - 2);
    EXPECT_EQ(state.frame, k);
    EXPECT_NEAR(state.time, k / 20.0, 1e-12);
    for (size_t i = 0; i < state.size(); ++i) {
      EXPECT_NEAR((state.v[i] - 20 * (fit.frames[from + 1].x[i] - fit.frames[from].x[i])).norm(), 0, 1e-6);
      EXPECT_TRUE(state.F[i].isIdentity(0));
      EXPECT_TRUE(state.C[i].isZero(0));
    }
  }
}

TEST_F(FitDeformationTest, AStoppedFitContinuesToTheSameNumbersBitForBit) {
  const WeightedField field = block.field();
  const auto fitted = [&](GradientFitState state, const GradientFitSink& keep) {
    return fit_deformation(brief(20), block.particles, field, block.objective(), std::move(state), {}, keep);
  };
  const DeformationFit whole = fitted({}, {});
  GradientFitState kept;
  const auto stop = [&](const GradientFitState& state) {
    kept = state;
    return state.rows.size() < 9;
  };
  try {
    fitted({}, stop);
    ADD_FAILURE() << "it was not stopped";
  } catch (const Error& e) {
    EXPECT_EQ(e.failure, Failure::kInterrupted);
  }
  ASSERT_EQ(kept.rows.size(), 9u);
  EXPECT_FALSE(kept.now.velocity.empty());
  const DeformationFit rest = fitted(kept, {});
  ASSERT_EQ(rest.iterations.size(), whole.iterations.size());
  for (size_t k = 0; k < whole.iterations.size(); ++k) EXPECT_EQ(rest.iterations[k].loss, whole.iterations[k].loss);
  for (size_t k = 0; k < whole.frames.size(); ++k) EXPECT_EQ(rest.frames[k].x, whole.frames[k].x);
}

TEST_F(FitDeformationTest, TheLossNeverEndsAboveItsStartHoweverLargeTheRate) {
  const WeightedField field = block.field();
  DeformationFitOptions options = brief(15);
  options.rate = 3;
  const DeformationFit fit = fit_deformation(options, block.particles, field, block.objective(), {});
  double most = 0;
  for (const GradientFitRow& row : fit.iterations) most = std::max(most, row.loss);
  EXPECT_GT(most, fit.iterations.front().loss);
  EXPECT_LE(block.loss_of(fit.frames), fit.iterations.front().loss);
}

TEST_F(FitDeformationTest, TermsOfOneFrameAndOfAllCountAlike) {
  const WeightedField field = block.field();
  Objective<float> apart, together;
  apart.terms.push_back({2, block.loss});
  together.whole.push_back({2, std::make_shared<SeenTogether>(block.loss)});
  const DeformationFit first = fit_deformation(brief(5), block.particles, field, apart, {});
  const DeformationFit second = fit_deformation(brief(5), block.particles, field, together, {});
  for (size_t k = 0; k < first.frames.size(); ++k) EXPECT_EQ(first.frames[k].x, second.frames[k].x);
  for (size_t k = 0; k < 5; ++k) EXPECT_NEAR(first.iterations[k].loss, second.iterations[k].loss, 1e-12);
  EXPECT_NEAR(first.iterations[0].loss,
              2 * block.loss_of(std::vector<SimulationState>(BentBlock::kFrames, initial_state(block.particles))),
              1e-12);
}

TEST(DeformationWeight, IsNothingInTheFirstFrameAndTheUnitWhereFree) {
  EXPECT_EQ(deformation_weight(std::vector<double>{1, 0}, 3, 0.5), (std::vector<double>{0, 0, 0.5, 0, 0.5, 0}));
}

}  // namespace
}  // namespace pliant
