#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"

namespace pliant {

struct AdjointCheckOptions {
  double step = 0.01;        ///< largest step, times max(1, |x_i|); the function must be smooth within it
  int unit_cotangents = 64;  ///< outputs tried one by one; beyond that many, a sample of so many
  int random_cotangents = 4;
  int inputs = 1 << 30;       ///< inputs tried one by one; beyond that many, a sample of so many
  int random_directions = 2;  ///< directions in which all inputs change together
  uint64_t seed = 1;
};

/// Largest disagreement between an adjoint and differences (to 1 %); `worst` is relative, see `check_adjoint`.
struct AdjointCheck {
  double worst = 0;
  std::string message;  ///< where it is, with both values
};

namespace check_adjoint_detail {

/// Derivatives of all `values(t)` at t = 0 by central differences at steps h, h/4, h/16, h/64 with Richardson
/// extrapolation up to order 8 (Ridders 1982); of all entries of the table, the one with the least estimated error.
template <class Values>
std::vector<double> extrapolated_derivative(Values&& values, double h) {
  constexpr int kLevels = 4;
  std::vector<double> table[kLevels][kLevels], best;
  double least = INFINITY;
  for (int level = 0; level < kLevels; ++level, h /= 4) {
    const std::vector<double> plus = values(h), minus = values(-h);
    std::vector<double>& first = table[level][0];
    for (size_t k = 0; k < plus.size(); ++k) first.push_back((plus[k] - minus[k]) / (2 * h));
    for (int order = 1; order <= level; ++order) {
      const std::vector<double>&finer = table[level][order - 1], &coarser = table[level - 1][order - 1];
      std::vector<double>& entry = table[level][order];
      const double factor = std::pow(16.0, order);
      double error = 0;
      for (size_t k = 0; k < plus.size(); ++k) {
        entry.push_back((factor * finer[k] - coarser[k]) / (factor - 1));
        error += std::pow(std::max(std::abs(entry[k] - finer[k]), std::abs(entry[k] - coarser[k])), 2);
      }
      if (error < least) {
        least = error;
        best = entry;
      }
    }
  }
  return best.empty() ? table[kLevels - 1][0] : best;
}

/// Numbers 0..n-1, or `count` of them drawn without order when there are more.
inline std::vector<size_t> sample(size_t n, int count, uint64_t seed) {
  std::vector<size_t> chosen(n);
  for (size_t i = 0; i < n; ++i) chosen[i] = i;
  if (n <= static_cast<size_t>(std::max(count, 0))) return chosen;
  Random random(seed);
  for (int i = 0; i < count; ++i) std::swap(chosen[i], chosen[i + random.below(n - i)]);
  chosen.resize(std::max(count, 0));
  return chosen;
}

}  // namespace check_adjoint_detail

/// Compares adjoint(x, adj_y) = J^T adj_y with differences of y = f(x), for unit and random cotangents adj_y, input by
/// input and along random directions.  Both map std::vector<double> to std::vector<double>.  The error of an entry is
/// relative to the largest of: the entry, 1 % of the largest entry of its gradient, 0.01 % of the largest entry of all
/// gradients; so small entries are held to nearly the tolerance of large ones without asking for digits that
/// differences do not have.  An entry that is not finite counts as infinitely wrong.
template <class Function, class Adjoint>
AdjointCheck check_adjoint(Function&& f, Adjoint&& adjoint, const std::vector<double>& x,
                           const AdjointCheckOptions& options = {}) {
  using namespace check_adjoint_detail;
  const size_t n = x.size(), m = f(x).size();
  std::vector<std::vector<double>> cotangents, gradients;
  std::vector<std::string> names;
  for (const size_t output : sample(m, options.unit_cotangents, options.seed)) {
    cotangents.emplace_back(m, 0.0).at(output) = 1;
    names.push_back("output " + std::to_string(output));
  }
  for (int r = 0; r < options.random_cotangents; ++r) {
    cotangents.emplace_back();
    for (size_t k = 0; k < m; ++k) cotangents.back().push_back(Random(options.seed, k, r).normal());
    names.push_back("random cotangent " + std::to_string(r));
  }
  std::vector<double> largest;  // entry of each gradient
  for (const auto& cotangent : cotangents) {
    gradients.push_back(adjoint(x, cotangent));
    CHECK_MSG(gradients.back().size() == n, "the adjoint returns one derivative per input");
    largest.push_back(0);
    for (const double g : gradients.back()) largest.back() = std::max(largest.back(), std::abs(g));
  }

  // One row per probe: the step of every input (a single one, or all), and the derivative along it by differences.
  struct Probe {
    std::string name;
    std::vector<double> step;
    std::vector<double> numeric;  // [cotangents]
  };
  std::vector<Probe> probes;
  for (const size_t i : sample(n, options.inputs, options.seed + 1)) {
    probes.push_back({"input " + std::to_string(i), std::vector<double>(n, 0.0), {}});
    probes.back().step[i] = 1;
  }
  for (int r = 0; r < options.random_directions; ++r) {
    probes.push_back({"random direction " + std::to_string(r), {}, {}});
    double norm = 0;
    for (size_t i = 0; i < n; ++i) {
      probes.back().step.push_back(Random(options.seed + 2, i, r).normal());
      norm += probes.back().step[i] * probes.back().step[i];
    }
    for (double& s : probes.back().step) s /= std::sqrt(norm);
  }
  const auto along = [](const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
  };
  for (Probe& probe : probes) {
    double size = 1;
    for (size_t i = 0; i < n; ++i)
      if (probe.step[i] == 1) size = std::max(1.0, std::abs(x[i]));
    probe.numeric = extrapolated_derivative(
        [&](double t) {
          std::vector<double> moved = x, values;
          for (size_t i = 0; i < n; ++i) moved[i] += t * probe.step[i];
          const std::vector<double> y = f(moved);
          for (const auto& cotangent : cotangents) values.push_back(along(cotangent, y));
          return values;
        },
        options.step * size);
    for (size_t k = 0; k < cotangents.size(); ++k) largest[k] = std::max(largest[k], std::abs(probe.numeric[k]));
  }

  const double overall = largest.empty() ? 0 : *std::max_element(largest.begin(), largest.end());
  AdjointCheck result;
  result.message = "exact";
  for (const Probe& probe : probes) {
    for (size_t k = 0; k < cotangents.size(); ++k) {
      const double analytic = along(gradients[k], probe.step), numeric = probe.numeric[k];
      double squares = 0;  // the entry itself, or what the entries along a direction add up to without cancelling
      for (size_t i = 0; i < n; ++i) squares += std::pow(gradients[k][i] * probe.step[i], 2);
      const double scale = std::max({std::sqrt(squares), std::abs(numeric), 1e-2 * largest[k], 1e-4 * overall, 1e-300});
      double error = std::abs(analytic - numeric) / scale;
      if (!std::isfinite(error)) error = INFINITY;
      if (!(error > 1.01 * result.worst)) continue;  // of about equal ones the first, which is the simplest
      result.worst = error;
      char text[256];
      std::snprintf(text, sizeof text, "relative error %.3g at %s, %s: analytic %.12g, numeric %.12g", error,
                    probe.name.c_str(), names[k].c_str(), analytic, numeric);
      result.message = text;
    }
  }
  return result;
}

}  // namespace pliant
