// Weights that hang on a body: their pull at rest, their inertia, and who is refused.

#include "physics/simulate/weights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "gaussians/base/error.h"
#include "physics/simulate/simulate.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

constexpr double kPi = 3.14159265358979324, kMass = 0.02, kGravity = 9.81;

/// A bar that hangs from its upper end; nu = 0, so that it is a linear spring.
struct Spring {
  BasicParticles<double> particles = fixture::block<double>({0.02, 0.02, 0.06}, 0.01, 0.0, 2e4, 0.0, 50);
  SimulateOptions options;
  Interaction pin;

  explicit Spring(GridKind grid) {
    options.grid = grid;
    options.fps = 500;
    pin.type = InteractionType::kPin;
    pin.region = Region::half_space(Vec3d(0, 0, 0.05), Vec3d(0, 0, -1));
  }
  static Interaction at_the_end(InteractionType type) {
    Interaction it;
    it.type = type;
    it.region = Region::half_space(Vec3d(0, 0, 0.01), Vec3d(0, 0, 1));
    return it;
  }
  static Interaction weight() {
    Interaction it = at_the_end(InteractionType::kWeight);
    it.mass = kMass;
    return it;
  }
  /// Mean fall of the lower end, m, at every frame.
  std::vector<double> fall(const std::vector<Interaction>& interactions) const {
    std::vector<double> out;
    simulate<double>(options, particles, interactions, initial_state(particles),
                     [&](const BasicSimulationState<double>& s) {
                       double sum = 0;
                       int count = 0;
                       for (size_t i = 0; i < s.size(); ++i) {
                         if (!weight().region.contains(particles.position[i])) continue;
                         sum += particles.position[i].z() - s.x[i].z();
                         ++count;
                       }
                       out.push_back(sum / count);
                       return true;
                     });
    return out;
  }
  double fall_at_rest(std::vector<Interaction> script) {
    options.duration = 0.5;
    options.damping_time = 0.03;
    script.push_back(pin);
    const double out = fall(script).back();
    options.damping_time = 0;
    return out;
  }
};

class Weights : public testing::TestWithParam<GridKind> {};
INSTANTIATE_TEST_SUITE_P(OnBothGrids, Weights, testing::Values(GridKind::kEulerian, GridKind::kLagrangian));

TEST_P(Weights, AtRestAWeightPullsWithItsMassTimesGravity) {
  Spring spring(GetParam());
  Interaction force = Spring::at_the_end(InteractionType::kPointForce);
  force.vector = Vec3d(0, 0, -kMass * kGravity);
  const double pulled = spring.fall_at_rest({force}), hung = spring.fall_at_rest({Spring::weight()});
  EXPECT_NEAR(hung / pulled, 1, 1e-3);
  // E A / L, to what the clamp and half of the layer that the weight hangs on leave open.
  EXPECT_NEAR(hung, kMass * kGravity * 0.045 / (2e4 * 4e-4), 0.1 * hung);
}

// What is heavy in its region, be it the body or another weight, does not draw the pull of a weight to itself.
TEST_P(Weights, AtRestTheyPullWhereTheyHangWhateverElseIsHeavyThere) {
  Spring spring(GetParam());
  Interaction everywhere = Spring::weight();
  everywhere.region = Region::all();
  const double tip = spring.fall_at_rest({Spring::weight()}), all = spring.fall_at_rest({everywhere});
  EXPECT_NEAR(spring.fall_at_rest({everywhere, Spring::weight()}) / (tip + all), 1, 1e-2);
  for (size_t i = 0; i < spring.particles.size(); ++i)
    if (spring.particles.position[i].z() < 0.03) spring.particles.mass[i] *= 20;
  EXPECT_NEAR(spring.fall_at_rest({everywhere}) / all, 1, 1e-2);
}

// All of gravity acts when it is not that of the capture.
TEST_P(Weights, AtRestTheyPullAlikeUnderAnyGravity) {
  Spring spring(GetParam());
  const double hung = spring.fall_at_rest({Spring::weight()});
  Interaction gravity;
  gravity.type = InteractionType::kGravity;
  gravity.vector = 2 * spring.options.gravity;
  spring.options.duration = 0.5;
  spring.options.damping_time = 0.03;
  const double own = spring.fall({spring.pin, gravity}).back(),
               both = spring.fall({spring.pin, gravity, Spring::weight()}).back();
  EXPECT_NEAR((both - own) / (2 * hung), 1, 5e-3);
}

// omega^2 = k / (m + M / 3), k = m g / fall; Rayleigh 1877.
TEST_P(Weights, AMassOnASpringSwingsAtItsFrequency) {
  Spring spring(GetParam());
  const double stiffness = kMass * kGravity / spring.fall_at_rest({Spring::weight()}),
               own = 50 * 0.02 * 0.02 * 0.05;  // kg, of the free part
  const double expected = std::sqrt(stiffness / (kMass + own / 3)) / (2 * kPi);
  spring.options.duration = 0.08;
  const std::vector<double> y = spring.fall({spring.pin, Spring::weight()});
  size_t k = 1;
  while (k + 2 < y.size() && !(y[k] >= y[k - 1] && y[k] > y[k + 1])) ++k;
  const double slope = 0.5 * (y[k + 1] - y[k - 1]), bend = y[k + 1] - 2 * y[k] + y[k - 1];
  const double frequency = 0.5 * spring.options.fps / (static_cast<double>(k) - slope / bend);
  EXPECT_NEAR(frequency / expected, 1, 0.01);
}

TEST_P(Weights, ABodyWithAWeightFallsLikeOneWithout) {
  Spring spring(GetParam());
  spring.options.duration = 0.05;
  spring.options.substeps = 20;
  const double fallen = spring.fall({}).back();
  EXPECT_NEAR(spring.fall({Spring::weight()}).back() / fallen, 1, 1e-6);
  EXPECT_NEAR(fallen, 0.5 * kGravity * 0.05 * 0.05, 0.01 * fallen);
}

// Whether the body's own gravity is cancelled or not.
TEST_P(Weights, TheirImpulseIsTheirMassTimesGravityAndTime) {
  Spring spring(GetParam());
  spring.options.duration = 0.02;
  Interaction gravity;
  gravity.type = InteractionType::kGravity;
  gravity.vector = Vec3d(0.5, 0, -20);
  const Interaction weight = Spring::weight();
  for (const std::vector<Interaction>& script : std::vector<std::vector<Interaction>>{
           {weight}, {weight, spring.pin}, {weight, gravity}, {weight, spring.pin, gravity}}) {
    const auto frames =
        simulate<double>(spring.options, spring.particles, script, initial_state(spring.particles)).summary;
    Vec3d given = Vec3d::Zero();
    for (const auto& frame : frames.impulse_of_frame) given += frame[0];
    const Vec3d& acting = script.back().type == InteractionType::kGravity ? gravity.vector : spring.options.gravity;
    EXPECT_LT((given - 0.02 * kMass * acting).norm(), 1e-9) << script.size();
  }
}

TEST(WeightShares, AddUpAndGoBackByTheirTranspose) {
  const auto body = fixture::block<double>({0.02, 0.02, 0.06}, 0.01, 0.0, 2e4, 0.0, 50);
  const std::vector<Interaction> script = {Spring::at_the_end(InteractionType::kPointForce), Spring::weight()};
  const std::vector<double> mass = masses_with_weights(body, script);
  double sum = 0, paired = 0;
  std::vector<double> adj(mass.size());
  for (size_t i = 0; i < mass.size(); ++i) {
    adj[i] = std::sin(static_cast<double>(i));
    sum += mass[i] - body.mass[i];
    paired += adj[i] * (mass[i] - body.mass[i]);
  }
  EXPECT_NEAR(sum, kMass, 1e-12);
  const std::vector<double> by = weights_adjoint(body, script, adj);
  EXPECT_EQ(by[0], 0);
  EXPECT_NEAR(by[1] * kMass, paired, 1e-12);
}

TEST(WeightRules, RefuseWhatHangsOnNothingOrComesAndGoes) {
  const Spring spring(GridKind::kAutomatic);
  const auto field_of = [&](const std::function<void(Interaction&)>& change) -> std::string {
    Interaction weight = Spring::weight();
    change(weight);
    try {
      spring.fall({spring.pin, weight});
    } catch (const Error& error) {
      return error.field;
    }
    return "none";
  };
  EXPECT_EQ(field_of([](Interaction& w) { w.region = Region::sphere(Vec3d(1, 1, 1), 0.1); }), "region");
  EXPECT_EQ(field_of([](Interaction& w) { w.mass = 0; }), "mass");
  EXPECT_EQ(field_of([](Interaction& w) { w.mass = NAN; }), "mass");
  EXPECT_EQ(field_of([](Interaction& w) { w.start = 0.1; }), "start");
  EXPECT_EQ(field_of([](Interaction& w) { w.duration = 0.1; }), "duration");
}

}  // namespace
}  // namespace pliant
