#include "app/evaluate/vibration.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"

namespace pliant {
namespace {

/// Evenly sampled values without their least-squares line, to which damped oscillations are fitted.
class OscillationFit {
 public:
  OscillationFit(const std::vector<double>& values, double rate)
      : rate_(rate), middle_(0.5 * (static_cast<double>(values.size()) - 1)), values_(values) {
    const double n = count();
    double mean = 0, slope = 0;
    for (const double value : values) mean += value / n;
    for (size_t i = 0; i < values.size(); ++i) {
      const double t = static_cast<double>(i) - middle_;
      slope += t * (values[i] - mean);
      spread_ += t * t;
    }
    for (size_t i = 0; i < values.size(); ++i) {
      values_[i] -= mean + slope / spread_ * (static_cast<double>(i) - middle_);
      squares_ += values_[i] * values_[i];
    }
  }

  double count() const { return static_cast<double>(values_.size()); }
  double duration() const { return count() / rate_; }
  double squares() const { return squares_; }  // about the line

  struct Linear {
    double left = 0;       // sum of squares that remains
    double amplitude = 0;  // of the oscillation at the first value
  };
  /// Least squares of the linear part for one frequency and decay.
  Linear at(double frequency, double decay) const {
    const double shrink = std::exp(-decay / rate_), turn = 2 * M_PI * frequency / rate_;
    const double step_c = shrink * std::cos(turn), step_s = shrink * std::sin(turn);
    // Sums of exp(-decay t) cos and of exp(-decay t) sin, with t and with the values, and of their products.
    double c = 1, s = 0, sum_c = 0, sum_s = 0, line_c = 0, line_s = 0, y_c = 0, y_s = 0, cc = 0, ss = 0, cs = 0;
    for (size_t i = 0; i < values_.size(); ++i) {
      const double t = static_cast<double>(i) - middle_;
      sum_c += c;
      sum_s += s;
      line_c += t * c;
      line_s += t * s;
      y_c += values_[i] * c;
      y_s += values_[i] * s;
      cc += c * c;
      ss += s * s;
      cs += c * s;
      const double next = c * step_c - s * step_s;
      s = c * step_s + s * step_c;
      c = next;
    }
    // The line fits its share of either anew.
    cc -= sum_c * sum_c / count() + line_c * line_c / spread_;
    ss -= sum_s * sum_s / count() + line_s * line_s / spread_;
    cs -= sum_c * sum_s / count() + line_c * line_s / spread_;
    const double determinant = cc * ss - cs * cs;
    if (!(determinant > 1e-12 * cc * ss)) return {squares_, 0};
    const double a = (y_c * ss - y_s * cs) / determinant, b = (y_s * cc - y_c * cs) / determinant;
    return {std::max(0.0, squares_ - a * y_c - b * y_s), std::hypot(a, b)};
  }

 private:
  double rate_ = 0, middle_ = 0, spread_ = 0, squares_ = 0;
  std::vector<double> values_;
};

/// A frequency and a decay, with what the fit leaves there.
struct Candidate {
  double frequency = 0, decay = 0, left = INFINITY;
};

/// What fit_oscillation looks for.
struct SearchBounds {
  double lowest = 0, highest = 0;                   // Hz
  double least_decay = 0, most_decay = 0;           // 1/s
  static constexpr double kMostDecayPerRadian = 4;  // at 1 a swing has 0.2 % of the one before

  double most_decay_of(double frequency) const {
    return std::min(most_decay, kMostDecayPerRadian * 2 * M_PI * frequency);
  }
  static constexpr double kNear = 1e-4;

  bool is_slowest(const Candidate& c) const { return c.frequency < (1 + kNear) * lowest; }
  /// Whether the best fit may lie beyond, at frequencies or decays that are too high.
  bool exceeds(const Candidate& c) const {
    return c.frequency > (1 - kNear) * highest || c.decay > (1 - kNear) * most_decay_of(c.frequency);
  }
};

/// The best place of a neighbourhood that closes in from a candidate; as wide in rad/s as in 1/s, like the valley.
Candidate descend(const OscillationFit& fit, const SearchBounds& bounds, Candidate best, double step, int halvings) {
  while (halvings > 0) {
    const Candidate from = best;
    for (int i = -1; i <= 1; ++i)
      for (int k = -1; k <= 1; ++k) {
        if (i == 0 && k == 0) continue;
        const double f = std::clamp(from.frequency + i * step / (2 * M_PI), bounds.lowest, bounds.highest);
        const double d = std::clamp(from.decay + k * step, bounds.least_decay, bounds.most_decay_of(f));
        const double left = fit.at(f, d).left;
        if (left < best.left) best = {f, d, left};
      }
    if (best.left < from.left) continue;
    step *= 0.5;
    --halvings;
  }
  return best;
}

}  // namespace

DampedOscillation fit_oscillation(const std::vector<double>& values, double rate) {
  if (values.size() < 8) return {};
  const OscillationFit fit(values, rate);
  if (!(fit.squares() > 1e-20)) return {};
  const double duration = fit.duration();
  const SearchBounds bounds{0.5 / duration, 0.5 * rate - 0.5 / duration, -1 / duration, 0.5 * rate};
  // The valley of the sum of squares is as wide as the spectrum of what has not yet died out, so that each decay has a
  // scan of its own over all frequencies, and the best of each is followed down.
  Candidate best;
  double best_width = 0;
  for (double decay = 0; decay <= bounds.most_decay; decay = 1.6 * decay + 1 / duration) {
    const double width = 1 / duration + decay / (2 * M_PI);
    Candidate start;
    for (double f = bounds.lowest; f <= bounds.highest; f += 0.25 * width) {
      if (decay > bounds.most_decay_of(f)) continue;
      const double left = fit.at(f, decay).left;
      if (left < start.left) start = {f, decay, left};
    }
    if (std::isinf(start.left)) continue;
    start = descend(fit, bounds, start, width, 8);
    if (start.left < best.left) {
      best = start;
      best_width = width;
    }
  }
  best = descend(fit, bounds, best, best_width / 128, 24);
  DampedOscillation out;
  if (bounds.exceeds(best)) return out;
  if (bounds.is_slowest(best)) {
    out.slower_than = bounds.lowest;
    return out;
  }
  out.frequency = best.frequency;
  out.decay = best.decay;
  out.explained = 1 - best.left / fit.squares();
  out.amplitude = fit.at(best.frequency, best.decay).amplitude;
  return out;
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
