#include <cmath>

#include "app/evaluate/evaluate.h"
#include "app/evaluate/self_test.h"
#include "app/store/material.h"
#include "app/store/trajectory.h"
#include "gaussians/base/random.h"
#include "gaussians/io/images/image_io.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

/// A damped swing.
struct Swing {
  double frequency = 1.5, decay = 0.4, amplitude = 0.1;  // Hz, 1/s, m or px

  double at(double t) const { return amplitude * std::exp(-decay * t) * std::cos(2 * M_PI * frequency * t); }
};

/// A rod of height 1, of which the higher parts swing farther; at rest in the first frame.
fs::path write_rod(const fs::path& file, const Swing& swing) {
  TrajectoryFile t;
  t.fps = 30;
  t.up = {0, 0, 1};
  for (int f = 0; f < 90; ++f) {
    TrajectoryFile::Frame frame;
    frame.time = f / 30.0;
    for (int p = 0; p <= 20; ++p) {
      const double z = p / 20.0;
      frame.position.push_back(Vec3d(z * (swing.at(frame.time) - swing.at(0)), 0, z).cast<float>());
    }
    frame.velocity.assign(21, Vec3f::Zero());
    frame.F.assign(21, Mat3f::Identity());
    t.frames.push_back(std::move(frame));
  }
  write_trajectory(file, t, "{}");
  return file;
}

/// Frames in which a smooth texture moves sideways as a whole by shift(frame) px.
template <class F>
fs::path write_frames(const SelfTest& test, const std::string& name, int frames, F&& shift, double brighter = 0) {
  for (int f = 0; f < frames; ++f) {
    ImageF picture(96, 72, 3);
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x) {
        double sum = 0;
        for (int k = 0; k < 6; ++k) {
          Random random(20, k);
          const double angle = 2 * M_PI * random.uniform(), length = 9 + 18 * random.uniform(),
                       phase = 2 * M_PI * random.uniform();
          sum += std::sin(2 * M_PI * ((x - shift(f)) * std::cos(angle) + y * std::sin(angle)) / length + phase);
        }
        for (int c = 0; c < 3; ++c) picture(x, y, c) = static_cast<float>(0.45 + 0.06 * sum + brighter);
      }
    write_image(test.place(name + "/" + std::to_string(f) + ".png"), picture);
  }
  return test.place(name);
}

}  // namespace

void check_material(SelfTest& test) {
  const auto write = [&](const std::string& name, float young, float poisson, float density) {
    MaterialFile m;
    m.young.assign(5, young);
    m.poisson.assign(5, poisson);
    m.density.assign(5, density);
    for (int i = 0; i < 5; ++i) m.position.push_back(Vec3f(static_cast<float>(i), 0, 0));
    m.volume.assign(5, 1.0f);
    write_material(test.place(name), m, "{}");
    return test.place(name);
  };
  const json found =
      evaluate_material(write("material/ours.h5", 1e6f, 0.4f, 1500), write("material/truth.h5", 1e5f, 0.3f, 1000));
  test.check_metric("material", "log10_young_error", "E ten times too large", 1, found, 1e-6);
  test.check_metric("material", "log10_young_bias", "E ten times too large", 1, found, 1e-6);
  test.check_metric("material", "poisson_error", "0.4 for 0.3", 0.1, found, 1e-6);
  test.check_metric("material", "density_relative_error", "1.5 times the density", 0.5, found, 1e-6);
}

void check_trajectory(SelfTest& test) {
  const Swing truth;
  Swing wide = truth, fast = truth;
  wide.amplitude *= 1.5;
  fast.frequency *= 1.1;
  const fs::path theirs = write_rod(test.place("trajectory/truth.h5"), truth);
  const json found = evaluate_trajectory(write_rod(test.place("trajectory/wide.h5"), wide), theirs);
  // Half the true displacement, over particles (the mean of their heights is 1/2) and frames.
  double mean = 0;
  for (int f = 0; f < 90; ++f) mean += std::abs(truth.at(f / 30.0) - truth.at(0)) / 90;
  test.check_metric("trajectory", "position_error_mean", "1.5 times the amplitude", 0.5 * 0.5 * mean, found, 1e-6);
  test.check_metric("trajectory", "relative_error", "1.5 times the amplitude", 0.5, found, 1e-6);
  // The tip are the highest 2 of 21 particles, at heights 1 and 0.95.
  test.check_metric("trajectory", "tip_error_mean", "1.5 times the amplitude", 0.5 * 0.975 * mean, found, 1e-6);
  test.check_metric("trajectory", "peak_error", "1.5 times the amplitude", 0.5, found, 1e-5);
  test.check_metric("trajectory", "frequency_error", "1.5 times the amplitude", 0, found, 1e-6);
  test.check_metric("trajectory", "frequency_error", "swings a tenth faster", 0.1,
                    evaluate_trajectory(write_rod(test.place("trajectory/fast.h5"), fast), theirs), 0.02);
}

void check_motion(SelfTest& test) {
  const Swing truth;
  Swing other{1.1 * truth.frequency, 1.5 * truth.decay, 1.2 * truth.amplitude};
  const json rods = evaluate_motion(write_rod(test.place("motion/other.h5"), other),
                                    write_rod(test.place("motion/truth.h5"), truth), {{}, 0});
  test.check_metric("motion", "truth.frequency_hz", "trajectory: 1.5 Hz", 1.5, rods, 1e-3);
  test.check_metric("motion", "truth.decay_per_s", "trajectory: 0.4 / s", 0.4, rods, 1e-3);
  test.check_metric("motion", "frequency_error", "a tenth faster", 0.1, rods, 1e-3);
  test.check_metric("motion", "damping_error", "1.5 times the damping", 0.5, rods, 5e-3);
  const double half_way = [](const Swing& s) { return 1 + std::exp(-0.5 * s.decay / s.frequency); }(other) /
                          (1 + std::exp(-0.5 * truth.decay / truth.frequency));
  test.check_metric("motion", "amplitude_error", "swings a fifth farther", 1.2 * half_way - 1, rods, 5e-3);

  // Three swings, of which the last has 1/8000 of the amplitude: all within the first third of the record.
  const fs::path brief = write_rod(test.place("motion/brief.h5"), {3, 9, 0.1});
  const json damped = evaluate_motion(write_rod(test.place("motion/briefer.h5"), {3, 12, 0.1}), brief, {{}, 0});
  test.check_metric("motion", "truth.frequency_hz", "dies out at once: 3 Hz", 3, damped, 1e-3);
  test.check_metric("motion", "truth.decay_per_s", "dies out at once: 9 / s", 9, damped, 1e-2);
  test.check_metric("motion", "damping_error", "4/3 of the damping", 1.0 / 3, damped, 5e-3);

  MotionScore score;
  score.fps = 30;
  Swing film{1.6, 0.5, 4};
  const auto swing = [&](int f) { return film.at(f / 30.0) - film.at(0); };
  const fs::path moving = write_frames(test, "motion/film", 40, swing);
  json found = evaluate_motion(moving, moving, score);
  test.check_metric("motion", "truth.frequency_hz", "film: 1.6 Hz", 1.6, found, 0.03);
  test.check_metric("motion", "flow_error", "film against itself", 0, found, 0);
  found = evaluate_motion(write_frames(test, "motion/frozen", 40, [](int) { return 0.0; }), moving, score);
  test.check_metric("motion", "prediction.frequency_hz", "frozen film", nullptr, found, 0);
  test.check_metric("motion", "amplitude_error", "frozen film", 1, found, 0.05);
  test.check_metric("motion", "flow_error", "frozen film", 1, found, 0.05);
}

void check_slices(SelfTest& test) {
  const auto still = [](int) { return 0.0; };
  ClipPart part;
  part.fps = 10;
  const json found =
      evaluate_slices(write_frames(test, "slices/a", 6, still), {write_frames(test, "slices/b", 6, still, 20 / 255.0)},
                      {part, {}, {}}, test.place("slices/slices.png"));
  test.check_metric("slices", "row_rmse", "20 of 255 levels brighter", 20 / 255.0, found, 1e-4);
  test.check_metric("slices", "column_rmse", "20 of 255 levels brighter", 20 / 255.0, found, 1e-4);
}

}  // namespace pliant
