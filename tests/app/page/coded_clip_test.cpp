// Laws of the numbers in a clip.html: what is decoded lies within half a step of what was coded, and of the background
// that stays which is seen.

#include <gtest/gtest.h>

#include "app/page/clip_budget.h"
#include "app/page/coded_motion.h"
#include "app/page/coded_splats.h"
#include "app/page/page_stage.h"
#include "gaussians/base/error.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

Vec3f random_vector(Random& random, double low, double high) {
  return Vec3d(random.uniform(low, high), random.uniform(low, high), random.uniform(low, high)).cast<float>();
}

GaussianCloud random_cloud(size_t count, int sh_degree) {
  Random random(3);
  GaussianCloud cloud;
  cloud.sh_degree = sh_degree;
  cloud.resize(count);
  for (size_t i = 0; i < count; ++i) {
    cloud.position[i] = random_vector(random, -2, 5);
    cloud.log_scale[i] = random_vector(random, -7, -1);
    for (int k = 0; k < 4; ++k) cloud.rotation[i][k] = static_cast<float>(random.uniform(-1, 1));
    cloud.opacity_logit[i] = static_cast<float>(random.uniform(-4, 6));
  }
  for (float& c : cloud.sh) c = static_cast<float>(random.uniform(-0.5, 0.5));
  return cloud;
}

TEST(CodedSplats, EveryNumberLiesWithinHalfAStep) {
  for (const bool fine : {true, false}) {
    const GaussianCloud cloud = random_cloud(700, 3);
    const CodedSplats coded = code_splats({3, fine}, cloud);
    const GaussianCloud back = decoded(coded);
    ASSERT_EQ(back.size(), cloud.size());
    const double steps = fine ? 65535 : 255, half = 0.5 / steps, rounding = 1e-6;
    for (size_t i = 0; i < cloud.size(); ++i) {
      for (int a = 0; a < 3; ++a) {
        const double chunk = coded.chunk_size[i / kSplatChunk * 3 + a];
        EXPECT_NEAR(back.position[i][a], cloud.position[i][a], chunk * 0.5 / 65535 + rounding);
        EXPECT_NEAR(back.log_scale[i][a], cloud.log_scale[i][a],
                    half * (coded.log_scale_range.high - coded.log_scale_range.low) + rounding);
        EXPECT_NEAR(back.sh_of(i)[a], cloud.sh_of(i)[a],
                    half * (coded.colour_range.high - coded.colour_range.low) + rounding);
      }
      EXPECT_NEAR(sigmoid(back.opacity_logit[i]), sigmoid(cloud.opacity_logit[i]), half + rounding);
      for (size_t k = 3; k < 48; ++k)
        EXPECT_NEAR(back.sh_of(i)[k], std::clamp<double>(cloud.sh_of(i)[k], coded.sh_range.low, coded.sh_range.high),
                    0.5 / 255 * (coded.sh_range.high - coded.sh_range.low) + rounding);
      const Mat3f difference = rotation_matrix(back.rotation[i]) - rotation_matrix(cloud.rotation[i]);
      EXPECT_LT(difference.norm(), 0.006) << "10 bits for each of three components";
    }
  }
}

TEST(CodedSplats, ALowerDegreeKeepsTheLowerCoefficients) {
  const GaussianCloud cloud = random_cloud(50, 3);
  const GaussianCloud back = decoded(code_splats({1, true}, cloud));
  EXPECT_EQ(back.sh_degree, 1);
  for (size_t i = 0; i < cloud.size(); ++i)
    for (int k = 0; k < 12; ++k) EXPECT_NEAR(back.sh_of(i)[k], cloud.sh_of(i)[k], 0.003);
}

TEST(CodedSplats, EmptyCloudsAndExtremeNumbersAreKept) {
  EXPECT_EQ(decoded(code_splats({}, GaussianCloud{})).size(), 0);
  GaussianCloud cloud = random_cloud(3, 0);
  cloud.rotation[0].setZero();
  cloud.log_scale[1] = Vec3f::Constant(-80);
  cloud.opacity_logit[2] = 90;
  const GaussianCloud back = decoded(code_splats({}, cloud));
  EXPECT_EQ(rotation_matrix(back.rotation[0]), Mat3f(Mat3f::Identity()));
  EXPECT_NEAR(back.log_scale[1][0], -14, 1e-5);
  EXPECT_GT(sigmoid(back.opacity_logit[2]), 0.9999f);
}

TEST(CodedSplats, AFewExtremeGaussiansDoNotRoundTheOthersMore) {
  for (const bool seen : {false, true}) {
    GaussianCloud cloud = random_cloud(4000, 0);
    const CodedSplats usual = code_splats({0, false}, cloud);
    cloud.opacity_logit[7] = seen ? 3 : -20;
    cloud.sh_of(7)[1] = 3e4f;
    if (!seen) cloud.log_scale[7] = Vec3f::Constant(60);
    const CodedSplats coded = code_splats({0, false}, cloud);
    const auto width = [](const CodedSplats::Range& range) { return range.high - range.low; };
    EXPECT_LT(width(coded.colour_range), 1.01 * width(usual.colour_range)) << seen;
    EXPECT_LT(width(coded.log_scale_range), 1.01 * width(usual.log_scale_range)) << seen;
    EXPECT_NEAR(decoded(coded).sh_of(7)[1], coded.colour_range.high, 1e-5) << "as far as it goes";
  }
  GaussianCloud invisible = random_cloud(5, 0);
  for (float& logit : invisible.opacity_logit) logit = -20;
  EXPECT_NEAR(decoded(code_splats({0, true}, invisible)).sh_of(2)[0], invisible.sh_of(2)[0], 1e-4);
}

TEST(CodedMotion, EveryFrameLiesWithinHalfAStepHoweverFast) {
  Random random(5);
  const size_t drivers = 20;
  std::vector<Vec3f> rest;
  for (size_t i = 0; i < drivers; ++i) rest.push_back(random_vector(random, -1, 1));
  for (const double speed : {0.01, 3.0, 1e4}) {
    std::vector<DriverFrame> frames;
    for (int t = 0; t < 12; ++t) {
      DriverFrame frame;
      for (size_t i = 0; i < drivers; ++i) {
        frame.position.push_back(rest[i] + random_vector(random, -speed, speed));
        frame.F.push_back(Mat3f::Identity() + Mat3f::Constant(static_cast<float>(random.uniform(-speed, speed))));
      }
      frames.push_back(frame);
    }
    const CodedMotion coded = code_motion({1e-4, 1e-3}, rest, frames);
    EXPECT_EQ(coded.position_step > 1e-4, speed > 2) << "residuals have 16 bits";
    for (const size_t t : {0, 5, 11}) {
      const DriverFrame back = decoded(coded, rest, t);
      for (size_t i = 0; i < drivers; ++i) {
        EXPECT_LT((back.position[i] - frames[t].position[i]).cwiseAbs().maxCoeff(),
                  0.501 * coded.position_step + 1e-6 * speed);
        EXPECT_LT((back.F[i] - frames[t].F[i]).cwiseAbs().maxCoeff(), 0.501 * coded.gradient_step + 1e-6 * speed);
      }
    }
  }
  std::vector<DriverFrame> broken(2, DriverFrame{rest, std::vector<Mat3f>(drivers, Mat3f::Identity())});
  broken[1].position[3].x() = NAN;
  EXPECT_THROW(code_motion({}, rest, broken), Error);
}

// As of an object of one Gaussian, whose places span nothing.
TEST(CodedMotion, WithoutAStepHasTheFinestThatFits) {
  const std::vector<Vec3f> rest = {Vec3f(1, 2, 3), Vec3f(-1, 0, 2)};
  std::vector<DriverFrame> frames;
  for (int t = 0; t < 10; ++t) {
    const Vec3f moved = Vec3f(std::sin(0.7f * static_cast<float>(t)), 0.3f, 0);
    frames.push_back({{rest[0] + moved, rest[1] - moved}, std::vector<Mat3f>(2, Mat3f::Identity())});
  }
  const CodedMotion coded = code_motion({0, 0}, rest, frames);
  EXPECT_GT(coded.position_step, 0);
  EXPECT_LT(coded.position_step, 1e-3);
  EXPECT_GT(coded.gradient_step, 0) << "of what does not change";
  for (size_t t = 0; t < frames.size(); ++t)
    for (size_t i = 0; i < rest.size(); ++i)
      EXPECT_LT((decoded(coded, rest, t).position[i] - frames[t].position[i]).cwiseAbs().maxCoeff(),
                0.501 * coded.position_step + 1e-6);
}

TEST(PageViews, GoAllAroundInEqualStepsOrToBothEndsOfASwing) {
  const Vec3d centre(1, 2, 3), up = Vec3d::UnitZ();
  constexpr double kRadius = 4;
  const Camera first = look_at(centre + Vec3d(0, -kRadius, 1), centre, up, 64, 48, 60);
  const std::vector<Camera> around = page_views(first, centre, up, true);
  ASSERT_EQ(around.size(), 8u);
  EXPECT_TRUE(around[0].cam_from_world.isApprox(first.cam_from_world, 1e-12));
  for (size_t k = 0; k < 8; ++k)
    EXPECT_NEAR((around[(k + 1) % 8].centre() - around[k].centre()).norm(), 2 * kRadius * std::sin(M_PI / 8), 1e-9)
        << k;
  const std::vector<Camera> swing = page_views(first, centre, up, false);
  ASSERT_EQ(swing.size(), 8u);
  const auto degrees = [&](size_t k) {
    const Vec3d away = swing[k].centre() - centre;
    return std::atan2(away.x(), -away.y()) * 180 / M_PI;
  };
  EXPECT_NEAR(std::abs(degrees(2)), 25, 1e-9);
  EXPECT_NEAR(degrees(6), -degrees(2), 1e-9);
}

TEST(ClipCoder, KeepsOfTheBackgroundWhatIsSeen) {
  MovingScene moving;
  moving.background = random_cloud(40, 0);
  Random random(4);
  for (size_t i = 0; i < 40; ++i) {
    moving.background.position[i] = random_vector(random, -0.3, 0.3) + Vec3f(0, 0, i % 2 == 0 ? 2.0f : -2.0f);
    moving.background.log_scale[i] = Vec3f::Constant(-3);
    moving.background.opacity_logit[i] = -2;
  }
  moving.object = random_cloud(1, 0);
  moving.binding.driver.assign(Binding::kCount, -1);
  moving.binding.weight.assign(Binding::kCount, 0);
  moving.particles.driving_position = moving.object.position;
  moving.trajectory.frames.resize(2);
  for (TrajectoryFile::Frame& frame : moving.trajectory.frames) {
    frame.position = moving.object.position;
    frame.F.assign(1, Mat3f::Identity());
  }
  const Scene scene = Scene();
  ClipCoder coder(std::move(moving), scene, {look_at({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 64, 48, 60)});
  ClipChoice choice;
  choice.object.sh_degree = choice.background.sh_degree = 0;
  choice.background_share = 0.5;
  choice.motion = {1e-4, 1e-3};
  const GaussianCloud kept = decoded(coder.code(choice).background);
  ASSERT_EQ(kept.size(), 20u);
  for (const Vec3f& x : kept.position) EXPECT_GT(x.z(), 0) << "behind the camera";
}

TEST(ClipFile, DriversHaveNumbersOf16Bits) {
  Binding binding;
  binding.driver.assign(Binding::kCount, -1);
  binding.weight.assign(Binding::kCount, 0);
  ClipFile file;
  binding.driver[0] = 65534;
  EXPECT_NO_THROW(add_level(file, "motion", 0, {}, binding));
  binding.driver[0] = 65535;
  EXPECT_THROW(add_level(file, "motion", 1, {}, binding), std::logic_error);
}

TEST(ClipFile, ArraysBeginAtMultiplesOfFourAndSayTheirShape) {
  ClipFile file;
  const std::vector<uint8_t> three = {1, 2, 3};
  const std::vector<float> two = {4, 5};
  file.add("a", "bytes", {3}, std::span<const uint8_t>(three), {-1, 1});
  file.add("a", "numbers", {2, 1}, std::span<const float>(two));
  EXPECT_EQ(file.sections["a"].size(), 12);
  const nlohmann::json& rows = file.header["arrays"];
  EXPECT_EQ(rows[0]["type"], "u8");
  EXPECT_EQ(rows[0]["high"], 1);
  EXPECT_EQ(rows[1]["offset"], 4);
  EXPECT_EQ(rows[1]["type"], "f32");
  EXPECT_EQ(rows[1]["shape"], nlohmann::json::array({2, 1}));
}

}  // namespace
}  // namespace pliant
