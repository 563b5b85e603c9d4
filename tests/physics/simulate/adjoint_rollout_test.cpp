// Gradients of whole roll-outs against differences, in double.

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>

#include "tests/check_adjoint.h"
#include "tests/physics/simulate/adjoint_rollout_case.h"

namespace pliant {
namespace {

using fixture::Input;
using Case = fixture::RolloutCase<double>;

/// Worst relative disagreement of the gradient with differences, input by input and along random directions.
AdjointCheck check(const Case& c, Input kind, const RolloutGradient<double>& gradient, double step = 1e-5) {
  AdjointCheckOptions options;
  options.step = step;
  options.random_cotangents = 0;
  options.inputs = 4;
  options.random_directions = 1;
  return check_adjoint([&](const std::vector<double>& u) { return std::vector<double>{c.with(kind, u).value()}; },
                       [&](const std::vector<double>&, const std::vector<double>& adj) {
                         std::vector<double> g = c.part(gradient, kind);
                         for (double& x : g) x *= adj[0];
                         return g;
                       },
                       c.get(kind), options);
}

/// The case on each grid that can carry it.
std::vector<Case> on_grids(Case c) {
  std::vector<Case> all;
  for (const GridKind grid : {GridKind::kEulerian, GridKind::kLagrangian}) {
    if (grid == GridKind::kLagrangian && !why_not_lagrangian(c.options.simulate, c.particles).empty()) continue;
    c.options.simulate.grid = grid;
    all.push_back(c);
  }
  return all;
}

void expect_gradient(const Case& any_grid) {
  for (const Case& c : on_grids(any_grid)) {
    const RolloutGradient<double> gradient = c.gradient();
    for (const auto& [kind, name] : fixture::kInputs) {
      if (c.get(kind).empty()) continue;
      const AdjointCheck result = check(c, kind, gradient);
      EXPECT_LT(result.worst, 1e-5) << (c.options.simulate.grid == GridKind::kEulerian ? "Eulerian " : "Lagrangian ")
                                    << name << ": " << result.message;
    }
  }
}

bool equal(const StateGradient<double>& a, const StateGradient<double>& b) {
  return a.x == b.x && a.v == b.v && a.C == b.C && a.F == b.F;
}

bool equal(const RolloutGradient<double>& a, const RolloutGradient<double>& b) {
  return equal(a.start, b.start) && a.young == b.young && a.poisson == b.poisson && a.mass == b.mass &&
         a.interaction == b.interaction && a.weight == b.weight && a.gravity == b.gravity &&
         a.damping_time == b.damping_time && a.viscosity_time == b.viscosity_time;
}

Case on_the_ground(double cells = 2.5) {
  Case c = fixture::moving_block<double>(cells);
  c.interactions.push_back(fixture::ground(0, 0.3));
  for (auto& v : c.start.v) v += Vec3d(0.5, 0.2, -0.6);
  return c;
}

TEST(AdjointRollout, SixtySubstepsOnAPinAgreeWithDifferences) {
  Case c = fixture::moving_block<double>();
  c.interactions.push_back(fixture::pin_below(0.004));
  c.interactions.back().duration = 0.01;  // then it falls
  expect_gradient(c);
}

TEST(AdjointRollout, SixtySubstepsOnTheGroundWithFrictionAgreeWithDifferences) {
  const Case c = on_the_ground();
  // The ground acts at all: without it the block ends elsewhere.
  Case free = c;
  free.interactions.pop_back();
  ASSERT_GT((rollout(c.options, c.particles, c.interactions, c.start).frames.back().x[0] -
             rollout(free.options, free.particles, free.interactions, free.start).frames.back().x[0])
                .norm(),
            1e-3);
  expect_gradient(c);
}

TEST(AdjointRollout, GravityThatTakesTurnsReachesTheRightNumbers) {
  Case c = fixture::moving_block<double>();
  Interaction gravity;
  gravity.type = InteractionType::kGravity;
  gravity.vector = {1, -2, 3};
  gravity.start = 0.005;
  gravity.duration = 0.005;
  c.interactions = {gravity};
  const RolloutGradient<double> gradient = c.gradient();
  for (const Input kind : {Input::kForces, Input::kGravity}) {
    const AdjointCheck result = check(c, kind, gradient);
    EXPECT_LT(result.worst, 1e-6) << result.message;
  }
}

TEST(AdjointRollout, SixtySubstepsUnderATorqueAgreeWithDifferences) {
  Case c = fixture::moving_block<double>(2);
  Interaction it;
  it.type = InteractionType::kTorque;
  it.vector = {1e-3, -2e-3, 1.5e-3};
  it.region = Region::sphere({0.015, 0.015, 0.015}, 0.01);
  it.start = 0.0012;
  it.duration = 0.01;
  c.interactions = {it};
  it.vector = {0, 0, 5e-4};
  it.region = Region::all();
  c.interactions.push_back(it);
  it.vector.setZero();  // what a torque would do
  c.interactions.push_back(it);
  // It turns the block at all.
  Case free = c;
  free.interactions.clear();
  ASSERT_GT((rollout(c.options, c.particles, c.interactions, c.start).frames.back().v[0] -
             rollout(free.options, free.particles, {}, free.start).frames.back().v[0])
                .norm(),
            1e-2);
  expect_gradient(c);
}

TEST(AdjointRollout, SixtySubstepsInTheWindAgreeWithDifferences) {
  Case c = fixture::moving_block<double>(2);
  Interaction it;
  it.type = InteractionType::kWind;
  it.vector = {8, -3, 2};
  it.region = Region::all();
  it.start = 0.0012;
  it.duration = 0.01;
  it.air_density = 100;  // air alone moves too little to see
  c.interactions = {it};
  c.interactions.push_back(fixture::pin_below(0.004));
  Case free = c;
  free.interactions.erase(free.interactions.begin());
  ASSERT_GT((rollout(c.options, c.particles, c.interactions, c.start).frames.back().v[0] -
             rollout(free.options, free.particles, free.interactions, free.start).frames.back().v[0])
                .norm(),
            1e-2);
  expect_gradient(c);
}

// On a pinned body, whose own gravity is cancelled, and on one that flies.
TEST(AdjointRollout, SixtySubstepsWithWeightsAgreeWithDifferences) {
  for (const bool pinned : {true, false}) {
    Case c = fixture::moving_block<double>(2);
    Interaction it;
    it.type = InteractionType::kWeight;
    it.mass = 2e-3;
    it.region = Region::sphere({0.015, 0.015, 0.015}, 0.01);
    c.interactions.push_back(it);
    it.mass = 5e-4;
    it.region = Region::all();
    c.interactions.push_back(it);
    if (pinned) c.interactions.push_back(fixture::pin_below(0.004));
    Case free = c;
    std::erase_if(free.interactions, [](const Interaction& one) { return one.type == InteractionType::kWeight; });
    ASSERT_GT((rollout(c.options, c.particles, c.interactions, c.start).frames.back().v[0] -
               rollout(free.options, free.particles, free.interactions, free.start).frames.back().v[0])
                  .norm(),
              1e-2);
    expect_gradient(c);
  }
}

/// The upper half is an object of its own, or two side by side, and slides on the lower one, which it is pressed to.
Case touching_objects(double cells, double friction, int objects = 2) {
  Case c = fixture::moving_block<double>(cells);
  const double middle = 0.5 * cells * c.particles.cell_size;
  for (size_t i = 0; i < c.particles.size(); ++i) {
    const Vec3d& x = c.particles.position[i];
    const int object = x.z() < middle ? 0 : x.x() < middle ? 1 : objects - 1;
    c.particles.object.push_back(static_cast<uint16_t>(object));
    c.start.v[i] += object == 0 ? Vec3d(0, 0, 0.2) : object == 1 ? Vec3d(0.3, 0.1, -0.4) : Vec3d(-0.2, 0.1, -0.5);
  }
  c.options.simulate.object_friction = friction;
  return c;
}

void expect_gradient_of_contact(const Case& c) {
  // Neither free of each other nor one body.
  const auto end = [](const Case& of) {
    return rollout(of.options, of.particles, of.interactions, of.start).frames.back().v[0];
  };
  Case other = c;
  other.options.simulate.object_friction = 0;
  EXPECT_GT((end(c) - end(other)).norm(), 1e-3);
  other.particles.object.clear();
  EXPECT_GT((end(c) - end(other)).norm(), 1e-3);
  expect_gradient(c);
}

TEST(AdjointRollout, SixtySubstepsOfTwoObjectsThatSlideOnEachOtherAgreeWithDifferences) {
  expect_gradient_of_contact(touching_objects(2, 0.3));
}

TEST(AdjointRollout, SixtySubstepsOfThreeObjectsThatMeetAgreeWithDifferences) {
  expect_gradient_of_contact(touching_objects(2, 2.0, 3));
}

TEST(AdjointRollout, ABlendWithFlipAgreesWithDifferences) {
  Case c = on_the_ground(2);
  c.options.simulate.duration = 0.01;
  c.options.simulate.flip_time = 0.002;
  expect_gradient(c);
}

TEST(AdjointRollout, DampedAffineVelocitiesAgreeWithDifferences) {
  Case c = fixture::moving_block<double>(2);
  c.options.simulate.duration = 0.01;
  c.options.simulate.substeps = 10;
  for (const bool pic : {false, true}) {
    c.options.simulate.strain_rate_damping = 150;
    c.options.simulate.pic = pic;
    const RolloutGradient<double> gradient = c.gradient();
    for (const Input kind : {Input::kX, Input::kF, Input::kYoung}) {
      const AdjointCheck result = check(c, kind, gradient, 1e-4);
      EXPECT_LT(result.worst, 1e-5) << pic << " " << result.message;
    }
  }
}

TEST(AdjointRollout, TheCheckRefusesAGradientWithOneWrongEntry) {
  Case c = fixture::moving_block<double>();
  c.options.simulate.duration = 0.005;
  const RolloutGradient<double> right = c.gradient();
  ASSERT_LT(check(c, Input::kV, right).worst, 1e-5);
  const std::vector<size_t> tried = check_adjoint_detail::sample(3 * c.particles.size(), 4, 2);
  RolloutGradient<double> wrong = right;
  wrong.start.v[tried[0] / 3][tried[0] % 3] *= 1 + 1e-4;
  EXPECT_GT(check(c, Input::kV, wrong).worst, 5e-5);
}

TEST(AdjointRollout, EqualsSimulateBitForBit) {
  const Case c = on_the_ground();
  const Rollout<double> r = rollout(c.options, c.particles, c.interactions, c.start);
  size_t k = 0;
  simulate<double>(c.options.simulate, c.particles, c.interactions, c.start, [&](const auto& s) {
    EXPECT_EQ(s.x, r.frames[k].x);
    EXPECT_EQ(s.v, r.frames[k].v);
    EXPECT_EQ(s.C, r.frames[k].C);
    EXPECT_EQ(s.F, r.frames[k].F);
    ++k;
    return true;
  });
  EXPECT_EQ(k, r.frames.size());
}

/// Over 1 to 4 threads.
void expect_equal_bits(const Case& any_grid) {
  ASSERT_GE(any_grid.particles.size(), 4000u);
  for (Case c : on_grids(any_grid)) {
    c.options.simulate.fps = 500;
    c.options.simulate.duration = 0.004;
    c.options.simulate.substeps = 8;
    const int before = omp_get_max_threads();
    omp_set_num_threads(1);
    const RolloutGradient<double> one = c.gradient();
    for (const int threads : {2, 3, 4}) {
      omp_set_num_threads(threads);
      EXPECT_TRUE(equal(one, c.gradient())) << threads;
    }
    omp_set_num_threads(before);
  }
}

TEST(AdjointRollout, EqualBitForBitForAnyNumberOfThreads) {
  expect_equal_bits(on_the_ground(8));
  Case c = touching_objects(8, 0.3);
  Interaction it;
  it.type = InteractionType::kTorque;
  it.vector = {0, 0, 1e-2};
  it.region = Region::sphere({0.04, 0.04, 0.08}, 0.02);
  c.interactions.push_back(it);
  it = {};
  it.type = InteractionType::kWind;
  it.vector = {8, -3, 2};
  it.air_density = 100;
  c.interactions.push_back(it);
  expect_equal_bits(c);
}

TEST(AdjointRollout, RecomputedSubstepsGiveTheBitsOfStoredOnes) {
  Case c = on_the_ground();
  const RolloutGradient<double> stored = c.gradient();
  for (const size_t memory : {stored.bytes / 2, stored.bytes / 6, size_t{0}}) {
    c.options.memory = memory;
    const RolloutGradient<double> again = c.gradient();
    EXPECT_TRUE(equal(stored, again));
    EXPECT_LT(again.bytes, stored.bytes);
  }
}

// L = sum of losses of frames.  With a window of one frame each loss sees only its own frame: the gradient by E is the
// sum over frames of roll-outs of one frame, whose start is given.
TEST(AdjointRollout, AWindowOfOneFrameEndsWhereTheFrameBegan) {
  for (const Case& c : on_grids(on_the_ground())) {
    const Rollout<double> r = rollout(c.options, c.particles, c.interactions, c.start);
    RolloutOptions options = c.options;
    options.gradient_window = 1;
    const auto windowed = rollout_adjoint<double>(options, c.particles, c.interactions, r, c.cotangent());
    std::vector<double> young(c.particles.size(), 0.0);
    for (int f = 1; f < static_cast<int>(r.frames.size()); ++f) {
      const Rollout<double> one{{r.frames[f - 1], r.frames[f]}, r.substeps, {}};
      const auto g =
          rollout_adjoint<double>(c.options, c.particles, c.interactions, one, [&](int k, StateGradient<double>& s) {
            if (k > 0) c.cotangent()(f, s);
          });
      for (size_t i = 0; i < young.size(); ++i) young[i] += g.young[i];
      if (f == 1) {
        StateGradient<double> start = g.start;
        c.cotangent()(0, start);
        EXPECT_TRUE(equal(windowed.start, start));
      }
    }
    double largest = 0;
    for (const double y : young) largest = std::max(largest, std::abs(y));
    for (size_t i = 0; i < young.size(); ++i) EXPECT_NEAR(windowed.young[i], young[i], 1e-12 * largest);
    // A window that spans everything cuts nothing, a shorter one does.
    options.gradient_window = 3;
    EXPECT_TRUE(equal(rollout_adjoint<double>(options, c.particles, c.interactions, r, c.cotangent()), c.gradient()));
    options.gradient_window = 2;
    EXPECT_FALSE(equal(rollout_adjoint<double>(options, c.particles, c.interactions, r, c.cotangent()), c.gradient()));
  }
}

// The state before the last substep of a frame counts as given: the same as a roll-out of that substep alone.
TEST(AdjointRollout, OneGradientSubstepIsThatOfARolloutOfTheLastSubstepAlone) {
  Case c = on_the_ground();
  c.interactions.clear();  // which begin and end on the clock of whole frames
  c.options.simulate.duration = 1 / c.options.simulate.fps;
  const int substeps = c.options.simulate.substeps;
  RolloutOptions cut = c.options, fine = c.options;
  cut.gradient_substeps = 1;
  fine.simulate.fps *= substeps;
  fine.simulate.substeps = 1;
  const Rollout<double> whole = rollout(c.options, c.particles, c.interactions, c.start),
                        steps = rollout(fine, c.particles, c.interactions, c.start);
  const auto of_last = [&](int last) {
    return [&, last](int k, StateGradient<double>& g) {
      if (k == last) c.cotangent()(1, g);
    };
  };
  const RolloutGradient<double> a = rollout_adjoint<double>(cut, c.particles, c.interactions, whole, of_last(1));
  const size_t n = steps.frames.size();
  const Rollout<double> last{{steps.frames[n - 2], steps.frames[n - 1]}, 1, {}};
  const RolloutGradient<double> b = rollout_adjoint<double>(fine, c.particles, c.interactions, last, of_last(1)),
                                full =
                                    rollout_adjoint<double>(c.options, c.particles, c.interactions, whole, of_last(1));
  double difference = 0, size = 0, all = 0;
  for (size_t i = 0; i < a.young.size(); ++i) {
    difference += std::pow(a.young[i] - b.young[i], 2);
    size += std::pow(b.young[i], 2);
    all += std::pow(full.young[i], 2);
  }
  EXPECT_LT(std::sqrt(difference / size), 1e-6);
  EXPECT_GT(std::sqrt(all), 2 * std::sqrt(size));
  EXPECT_TRUE(a.start.x[0].isZero() && a.start.F[0].isZero());
  cut.gradient_substeps = substeps;  // cuts nothing
  EXPECT_TRUE(equal(rollout_adjoint<double>(cut, c.particles, c.interactions, whole, of_last(1)), full));
  cut.gradient_substeps = -1;
  EXPECT_THROW(rollout_adjoint<double>(cut, c.particles, c.interactions, whole, of_last(1)), Error);
}

TEST(AdjointRollout, FloatAgreesWithDouble) {
  const Case c = on_the_ground();
  auto f = fixture::moving_block<float>();
  f.interactions = c.interactions;
  for (auto& v : f.start.v) v += Vec3f(0.5f, 0.2f, -0.6f);
  const RolloutGradient<double> a = c.gradient();
  const RolloutGradient<float> b = f.gradient();
  for (const auto& [kind, name] : fixture::kInputs) {
    if (c.get(kind).empty()) continue;
    const std::vector<double> u = c.part(a, kind), v = f.part(b, kind);
    double difference = 0, size = 0;
    for (size_t k = 0; k < u.size(); ++k) {
      difference += (u[k] - v[k]) * (u[k] - v[k]);
      size += u[k] * u[k];
    }
    EXPECT_LT(std::sqrt(difference / size), 1e-3) << name;
  }
}

}  // namespace
}  // namespace pliant
