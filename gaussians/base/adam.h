#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"

namespace pliant {

/// Adam (Kingma and Ba 2015, algorithm 1) over one array of parameters.  The small epsilon is that of the reference
/// 3DGS code: gradients of blended attributes are tiny, and a larger one would slow rarely seen Gaussians down.
template <class T>
class Adam {
 public:
  explicit Adam(size_t size, T beta1 = T(0.9), T beta2 = T(0.999), T epsilon = T(1e-15))
      : beta1_(beta1), beta2_(beta2), epsilon_(epsilon), first_(size, T(0)), second_(size, T(0)) {}

  /// Continues after `steps` steps that left these moments; the other constants are the defaults.
  Adam(std::vector<T> first_moment, std::vector<T> second_moment, long steps) : Adam(0) {
    first_ = std::move(first_moment);
    second_ = std::move(second_moment);
    steps_ = steps;
  }

  const std::vector<T>& first_moment() const { return first_; }
  const std::vector<T>& second_moment() const { return second_; }

  /// parameter -= rate * m_hat / (sqrt(v_hat) + epsilon).
  void step(std::span<T> parameter, std::span<const T> gradient, T rate) {
    CHECK(parameter.size() == first_.size() && gradient.size() == first_.size());
    ++steps_;
    const T scale = rate / (T(1) - std::pow(beta1_, T(steps_)));
    const T correction = T(1) / std::sqrt(T(1) - std::pow(beta2_, T(steps_)));
    constexpr std::ptrdiff_t kChunk = 16384;
    const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(first_.size());
    using Array = Eigen::Array<T, Eigen::Dynamic, 1>;
    parallel_for((n + kChunk - 1) / kChunk, [&](std::ptrdiff_t chunk) {
      const std::ptrdiff_t begin = chunk * kChunk, count = std::min(kChunk, n - begin);
      Eigen::Map<const Array> g(gradient.data() + begin, count);
      Eigen::Map<Array> x(parameter.data() + begin, count), m(first_.data() + begin, count),
          v(second_.data() + begin, count);
      m = beta1_ * m + (T(1) - beta1_) * g;
      v = beta2_ * v + (T(1) - beta2_) * g.square();
      x -= scale * m / (v.sqrt() * correction + epsilon_);
    });
  }

 private:
  T beta1_, beta2_, epsilon_;
  long steps_ = 0;
  std::vector<T> first_, second_;
};

}  // namespace pliant
