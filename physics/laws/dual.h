#pragma once

#include <array>
#include <cmath>

namespace pliant {

/// A number together with its derivatives with respect to N inputs (forward mode; Clifford 1873).  Comparisons look at
/// the value alone, so a template that branches takes the branch of the value.
template <class T, int N>
struct Dual {
  T value = 0;
  std::array<T, N> slope{};

  Dual() = default;
  Dual(T constant) : value(constant) {}
  static Dual input(T value, int k) {
    Dual d(value);
    d.slope[k] = 1;
    return d;
  }
  /// f(a) of f and f' at the value of a.
  static Dual chain(T f, T derivative, const Dual& a) {
    Dual d(f);
    for (int k = 0; k < N; ++k) d.slope[k] = derivative * a.slope[k];
    return d;
  }

  friend Dual operator+(Dual a, const Dual& b) {
    a.value += b.value;
    for (int k = 0; k < N; ++k) a.slope[k] += b.slope[k];
    return a;
  }
  friend Dual operator-(Dual a, const Dual& b) {
    a.value -= b.value;
    for (int k = 0; k < N; ++k) a.slope[k] -= b.slope[k];
    return a;
  }
  friend Dual operator*(const Dual& a, const Dual& b) {
    Dual d(a.value * b.value);
    for (int k = 0; k < N; ++k) d.slope[k] = a.slope[k] * b.value + a.value * b.slope[k];
    return d;
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    Dual d(a.value / b.value);
    for (int k = 0; k < N; ++k) d.slope[k] = (a.slope[k] - d.value * b.slope[k]) / b.value;
    return d;
  }
  friend Dual operator-(const Dual& a) { return Dual() - a; }
  Dual& operator+=(const Dual& b) { return *this = *this + b; }

  friend bool operator<(const Dual& a, const Dual& b) { return a.value < b.value; }
  friend bool operator>(const Dual& a, const Dual& b) { return a.value > b.value; }

  friend Dual sqrt(const Dual& a) {
    const T root = std::sqrt(a.value);
    return chain(root, T(0.5) / root, a);
  }
  friend Dual exp(const Dual& a) {
    const T e = std::exp(a.value);
    return chain(e, e, a);
  }
  friend Dual log(const Dual& a) { return chain(std::log(a.value), 1 / a.value, a); }
};

}  // namespace pliant
