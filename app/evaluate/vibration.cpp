#include "app/evaluate/vibration.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "app/evaluate/metrics.h"
#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"

namespace pliant {
namespace {

/// Least squares of the linear part for one frequency and decay.
struct LinearFit {
  double left = 0;       // sum of squares that remains
  double amplitude = 0;  // of the oscillation at the first value
};

LinearFit fit_linear(const std::vector<double>& values, double rate, double frequency, double decay) {
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  const double duration = static_cast<double>(values.size()) / rate;
  const auto basis = [&](size_t i) {
    const double t = static_cast<double>(i) / rate, envelope = std::exp(-decay * t), phase = 2 * M_PI * frequency * t;
    return Eigen::Vector4d(1, t / duration, envelope * std::cos(phase), envelope * std::sin(phase));
  };
  for (size_t i = 0; i < values.size(); ++i) {
    const Eigen::Vector4d row = basis(i);
    A += row * row.transpose();
    b += values[i] * row;
  }
  A += 1e-12 * A.trace() * Eigen::Matrix4d::Identity();
  const Eigen::Vector4d x = solve_symmetric(A, b);
  LinearFit fit;
  for (size_t i = 0; i < values.size(); ++i) fit.left += std::pow(values[i] - basis(i).dot(x), 2);
  fit.amplitude = std::hypot(x[2], x[3]);
  return fit;
}

double squares_about_line(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double mean = 0, slope = 0, spread = 0, sum = 0;
  for (const double value : values) mean += value / n;
  for (size_t i = 0; i < values.size(); ++i) {
    const double t = static_cast<double>(i) - 0.5 * (n - 1);
    slope += t * (values[i] - mean);
    spread += t * t;
  }
  for (size_t i = 0; i < values.size(); ++i)
    sum += std::pow(values[i] - mean - slope / spread * (static_cast<double>(i) - 0.5 * (n - 1)), 2);
  return sum;
}

}  // namespace

DampedOscillation fit_oscillation(const std::vector<double>& values, double rate) {
  DampedOscillation best;
  if (values.size() < 8) return best;
  const double all = squares_about_line(values), duration = static_cast<double>(values.size()) / rate;
  if (!(all > 1e-20)) return best;
  // Around the peak of the spectrum, whose width is 1 / duration, and from half a period in the record on.
  const double peak = dominant_frequency(values, rate);
  double frequency = 0, decay = 0, least = INFINITY, frequency_step = 0.1 / duration, decay_step = 0.4 / duration;
  const auto try_at = [&](double f, double d) {
    if (f < 0.5 / duration || f > 0.5 * rate || d < -1 / duration || d > 20 / duration) return;
    const double left = fit_linear(values, rate, f, d).left;
    if (left < least) {
      least = left;
      frequency = f;
      decay = d;
    }
  };
  for (int i = -15; i <= 15; ++i)
    for (int k = -2; k <= 30; ++k) try_at(peak + i * frequency_step, k * decay_step);
  for (int round = 0; round < 40; ++round) {
    const double f = frequency, d = decay, before = least;
    for (int i = -1; i <= 1; ++i)
      for (int k = -1; k <= 1; ++k)
        if (i != 0 || k != 0) try_at(f + i * frequency_step, d + k * decay_step);
    if (least == before) {
      frequency_step *= 0.5;
      decay_step *= 0.5;
    }
  }
  best.frequency = frequency;
  best.decay = decay;
  best.explained = 1 - least / all;
  best.amplitude = fit_linear(values, rate, frequency, decay).amplitude;
  return best;
}

Vibration describe_vibration(const PointMotion& motion, int& first) {
  const auto T = static_cast<Eigen::Index>(motion.frames()), K = static_cast<Eigen::Index>(motion.points()),
             D = static_cast<Eigen::Index>(motion.dims);
  CHECK(T >= 2 && K >= 1);
  Eigen::MatrixXd u(T, K * D);
  for (Eigen::Index t = 0; t < T; ++t)
    for (Eigen::Index i = 0; i < K * D; ++i) u(t, i) = motion.displacement[t][i] * std::sqrt(motion.weight[i / D]);
  u.rowwise() -= u.colwise().mean().eval();
  const SymmetricEigen components = symmetric_eigen(Eigen::MatrixXd(u * u.transpose()));
  Vibration out;
  const double largest = components.values[T - 1], total = components.values.sum();
  out.share = total > 0 ? largest / total : 0;
  double weights = 0;
  for (const double w : motion.weight) weights += w;
  const double scale = std::sqrt(std::max(largest, 0.0) / std::max(weights, 1e-12));
  const Eigen::VectorXd course = components.vectors.col(T - 1) * scale;
  out.course.assign(course.data(), course.data() + T);

  std::vector<double> reach;
  for (Eigen::Index k = 0; k < K; ++k) {
    if (!(motion.weight[k] > 0)) continue;
    const Eigen::MatrixXd own = u.middleCols(k * D, D) / std::sqrt(motion.weight[k]);
    const SymmetricEigen axes = symmetric_eigen(Eigen::MatrixXd(own.transpose() * own));
    const Eigen::VectorXd along = own * axes.vectors.col(D - 1);
    reach.push_back(0.5 * (along.maxCoeff() - along.minCoeff()));
  }
  std::sort(reach.begin(), reach.end());
  if (!reach.empty()) out.amplitude = reach[static_cast<size_t>(0.95 * static_cast<double>(reach.size() - 1))];

  if (first < 0) {
    first = 0;
    for (Eigen::Index t = 0; t < T; ++t)
      if (std::abs(course[t]) > std::abs(course[first])) first = static_cast<int>(t);
    if (2 * first > T) first = 0;
  }
  const auto from = [&](size_t begin) {
    return fit_oscillation(
        {out.course.begin() + static_cast<std::ptrdiff_t>(std::min(begin, out.course.size())), out.course.end()},
        motion.rate);
  };
  out.oscillation = from(first);
  // About the place where it ends, which the mean of a motion that dies away is not.
  double end = 0, most = 0;
  const size_t frames = out.course.size(), tail = std::max<size_t>(1, frames / 4);
  for (size_t t = frames - tail; t < frames; ++t) end += out.course[t] / static_cast<double>(tail);
  size_t begin = first;
  for (size_t t = first; t < frames; ++t) most = std::max(most, std::abs(out.course[t] - end));
  for (size_t t = first; t < frames; ++t)
    if (std::abs(out.course[t] - end) > most / 3) begin = t + 1;
  const double left = begin < frames ? static_cast<double>(frames - begin) / motion.rate : 0;  // s
  if (left * out.oscillation.frequency >= 3) out.small = from(begin);
  return out;
}

}  // namespace pliant
