#include "fitting/modal/modes.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "gaussians/base/error.h"
#include "tests/fitting/twin_stem.h"

namespace pliant {
namespace {

using namespace fixture;

using Stem = TwinStem;

TEST(VibrationModes, ShapesAreOrthonormalInMassAndFrequenciesFollowTheRootOfE) {
  Stem stem;
  const VibrationModes soft = vibration_modes({}, stem.particles, stem.pins);
  ASSERT_GE(soft.size(), 3u);
  for (size_t a = 0; a < soft.size(); ++a)
    for (size_t b = 0; b <= a; ++b) {
      double product = 0;
      for (size_t i = 0; i < stem.particles.size(); ++i)
        product += stem.particles.mass[i] * soft.shape[a][i].dot(soft.shape[b][i]);
      EXPECT_NEAR(product, a == b ? 1 : 0, 1e-6);
    }
  for (float& E : stem.particles.young) E *= 16;
  const VibrationModes stiff = vibration_modes({}, stem.particles, stem.pins);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(stiff.omega[k] / soft.omega[k], 4, 0.004);
}

TEST(VibrationModes, PartsThatAreNotLinkedSwayAsIfAlone) {
  const Stem alone;
  Stem two;
  const size_t n = alone.particles.size();
  const float apart = 0.02f + 0.3f * alone.particles.cell_size;
  Particles& both = two.particles;
  for (size_t i = 0; i < n; ++i) both.position.push_back(both.position[i] + Vec3f(apart, 0, 0));
  for (std::vector<float>* values : {&both.volume, &both.mass, &both.young, &both.poisson})
    for (size_t i = 0; i < n; ++i) values->push_back((*values)[i]);
  // Bending towards each other is stiffer where they are one.
  const double glued = vibration_modes({}, both, two.pins).omega[1];
  for (const int first : {0, static_cast<int>(n)})
    for (int i = 0; i < static_cast<int>(n); ++i)
      for (int k = 0; k < i; ++k)
        if ((both.position[first + i] - both.position[first + k]).norm() < both.cell_size)
          both.links.push_back({first + k, first + i});
  std::sort(both.links.begin(), both.links.end());
  const double own = vibration_modes({}, alone.particles, alone.pins).omega[1];
  EXPECT_NEAR(vibration_modes({}, both, two.pins).omega[1] / own, 1, 0.03);
  EXPECT_GT(glued / own, 1.2);
}

TEST(VibrationModes, ABodyReleasedInItsLowestModeSwingsAtItsFrequency) {
  const Stem stem;
  const VibrationModes modes = vibration_modes({}, stem.particles, stem.pins);
  SimulationState start = initial_state(stem.particles);
  for (size_t i = 0; i < start.size(); ++i) start.v[i] = (1e-4 * modes.omega[0] * modes.shape[0][i]).cast<float>();
  SimulateOptions options;
  options.gravity.setZero();
  options.fps = 400;
  options.duration = 5.0 / (modes.omega[0] / 6.2832);
  // Every second passage through rest ends a period.
  std::vector<double> passages;
  double before = 0, time_before = 0;
  simulate<float>(options, stem.particles, stem.pins, start, [&](const SimulationState& state) {
    double along = 0;
    for (size_t i = 0; i < state.size(); ++i)
      along += stem.particles.mass[i] * modes.shape[0][i].dot((state.x[i] - stem.particles.position[i]).cast<double>());
    if (before < 0 && along >= 0)
      passages.push_back(time_before + (state.time - time_before) * before / (before - along));
    before = along;
    time_before = state.time;
    return true;
  });
  ASSERT_GE(passages.size(), 3u);
  const double period = (passages.back() - passages.front()) / (passages.size() - 1);
  EXPECT_NEAR(2 * M_PI / period / modes.omega[0], 1, 0.01);
}

TEST(VibrationModes, ABodyThatNothingHoldsIsRefused) {
  const Stem stem;
  EXPECT_THROW(vibration_modes({}, stem.particles, {}), Error);
}

}  // namespace
}  // namespace pliant
