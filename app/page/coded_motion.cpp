#include "app/page/coded_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

/// Residuals of `count` numbers a frame, or false where one does not fit.
template <class Get>
bool code(size_t frames, size_t count, double step, const Get& get, std::vector<int16_t>& out) {
  out.assign(frames * count, 0);
  for (size_t k = 0; k < count; ++k) {
    int64_t before = 0, last = 0;
    for (size_t t = 0; t < frames; ++t) {
      const double steps = get(t, k) / step;
      if (!(std::abs(steps) < 1e9)) return false;
      const int64_t q = std::llround(steps), residual = q - (2 * last - before);
      if (std::abs(residual) > std::numeric_limits<int16_t>::max()) return false;
      out[t * count + k] = static_cast<int16_t>(residual);
      before = last;
      last = q;
    }
  }
  return true;
}

/// A step with which the largest number has 16 bits.
template <class Get>
double finest_step(size_t frames, size_t count, const Get& get) {
  double largest = 0;
  for (size_t t = 0; t < frames; ++t)
    for (size_t k = 0; k < count; ++k) largest = std::max(largest, std::abs(get(t, k)));
  return largest > 0 ? largest / std::numeric_limits<int16_t>::max() : 1;
}

/// The smallest power of two times `step` with which all residuals fit.
template <class Get>
double code_with_step(size_t frames, size_t count, double step, const Get& get, std::vector<int16_t>& out) {
  constexpr int kDoublings = 64;
  if (!(step > 0)) step = finest_step(frames, count, get);
  for (int k = 0; k < kDoublings; ++k, step *= 2)
    if (code(frames, count, step, get, out)) return step;
  throw input_error("trajectory.h5", "position", "holds numbers without bound", "simulate again");
}

double sum_up_to(const std::vector<int16_t>& residuals, size_t count, size_t k, size_t t) {
  int64_t before = 0, last = 0;
  for (size_t f = 0; f <= t; ++f) {
    const int64_t q = residuals[f * count + k] + 2 * last - before;
    before = last;
    last = q;
  }
  return static_cast<double>(last);
}

}  // namespace

CodedMotion code_motion(const MotionCoding& coding, std::span<const Vec3f> rest, std::span<const DriverFrame> frames) {
  CodedMotion out;
  out.frames = frames.size();
  out.drivers = rest.size();
  const size_t m = rest.size();
  out.position_step = code_with_step(
      frames.size(), 3 * m, coding.position_step,
      [&](size_t t, size_t k) -> double { return frames[t].position[k % m][k / m] - rest[k % m][k / m]; },
      out.position);
  out.gradient_step = code_with_step(
      frames.size(), 9 * m, coding.gradient_step,
      [&](size_t t, size_t k) -> double {
        const size_t row = k / m / 3, column = k / m % 3;
        return frames[t].F[k % m](row, column) - (row == column);
      },
      out.gradient);
  return out;
}

DriverFrame decoded(const CodedMotion& motion, std::span<const Vec3f> rest, size_t t) {
  DriverFrame frame;
  const size_t m = motion.drivers;
  for (size_t i = 0; i < m; ++i) {
    Vec3f x = rest[i];
    for (int a = 0; a < 3; ++a)
      x[a] += static_cast<float>(motion.position_step * sum_up_to(motion.position, 3 * m, a * m + i, t));
    Mat3f F = Mat3f::Identity();
    for (int k = 0; k < 9; ++k)
      F(k / 3, k % 3) += static_cast<float>(motion.gradient_step * sum_up_to(motion.gradient, 9 * m, k * m + i, t));
    frame.position.push_back(x);
    frame.F.push_back(F);
  }
  return frame;
}

void add_motion(ClipFile& clip, const CodedMotion& motion) {
  const auto add = [&](const std::string& name, size_t components, const std::vector<int16_t>& values) {
    std::vector<uint8_t> low, high;
    for (const int16_t v : values) {
      low.push_back(static_cast<uint8_t>(v & 255));
      high.push_back(static_cast<uint8_t>(static_cast<uint16_t>(v) >> 8));
    }
    const std::vector<size_t> shape = {motion.frames, components, motion.drivers};
    clip.add("motion", "motion." + name + "_low", shape, std::span<const uint8_t>(low));
    clip.add("motion", "motion." + name + "_high", shape, std::span<const uint8_t>(high));
  };
  add("position", 3, motion.position);
  add("gradient", 9, motion.gradient);
  clip.header["motion"] = {{"position_step", motion.position_step}, {"gradient_step", motion.gradient_step}};
}

}  // namespace pliant
