#include "fitting/fields/kan_field.h"

#include <algorithm>
#include <array>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

constexpr int kIntervals = 5, kSpline = kIntervals + 3;  // of [-1, 1], and the cubic splines that reach into it
constexpr int kEdge = 1 + kSpline;                       // parameters of an edge
constexpr double kNoise = 0.1;                           // standard deviation of the first layer's coefficients

/// What a function on an edge is made of, at one place.
struct Basis {
  double silu, silu_slope;
  int first;  // of the four splines that are not 0 there; some of them may lie outside
  std::array<double, 4> spline, slope;
};

Basis basis_at(double x) {
  Basis out;
  const double gate = 1 / (1 + std::exp(-x));
  out.silu = x * gate;
  out.silu_slope = gate * (1 + x * (1 - gate));
  constexpr double kPerUnit = kIntervals / 2.0;
  const double along = std::clamp((x + 1) * kPerUnit, -4.0, kIntervals + 4.0), cell = std::floor(along);
  const double t = along - cell, s = 1 - t;
  out.first = static_cast<int>(cell);
  out.spline = {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (3 * s * s * s - 6 * s * s + 4) / 6, t * t * t / 6};
  out.slope = {-s * s / 2, (3 * t * t - 4 * t) / 2, -(3 * s * s - 4 * s) / 2, t * t / 2};
  for (double& slope : out.slope) slope *= kPerUnit;
  return out;
}

/// Calls `each` with the number of a parameter of an edge, its factor there and the slope of that.
template <class Each>
void visit(const Basis& basis, Each&& each) {
  each(0, basis.silu, basis.silu_slope);
  for (int k = 0; k < 4; ++k)
    if (const int j = basis.first + k; j >= 0 && j < kSpline) each(1 + j, basis.spline[k], basis.slope[k]);
}

double edge(const double* parameters, const Basis& basis) {
  double sum = 0;
  visit(basis, [&](int j, double factor, double) { sum += parameters[j] * factor; });
  return sum;
}

/// Adds `adj` times the derivatives by the parameters; returns that by the place.
double edge_adjoint(const double* parameters, const Basis& basis, double adj, double* adj_parameters) {
  double by_place = 0;
  visit(basis, [&](int j, double factor, double slope) {
    adj_parameters[j] += adj * factor;
    by_place += parameters[j] * slope;
  });
  return adj * by_place;
}

double bounded(double z, double bound) { return std::isinf(bound) ? z : bound * std::tanh(z / bound); }

double bounded_adjoint(double z, double bound, double adj) {
  if (std::isinf(bound)) return adj;
  const double t = std::tanh(z / bound);
  return adj * (1 - t * t);
}

/// The network at one place.
struct Evaluation {
  std::array<Basis, 3> in;
  std::vector<Basis> hidden;
  double sum = 0;

  Evaluation(int hidden_count, const double* parameters, const Vec3d& place) : hidden(hidden_count) {
    for (int a = 0; a < 3; ++a) in[a] = basis_at(place[a]);
    const double* second = parameters + 3 * kEdge * hidden_count;
    sum = second[kEdge * hidden_count];
    for (int h = 0; h < hidden_count; ++h) {
      double node = 0;
      for (int a = 0; a < 3; ++a) node += edge(parameters + kEdge * (3 * h + a), in[a]);
      hidden[h] = basis_at(node);
      sum += edge(second + kEdge * h, hidden[h]);
    }
  }
};

}  // namespace

KanField::KanField(const KanFieldOptions& options, std::span<const Vec3f> points) : options_(options) {
  if (options.hidden < 1) throw usage_error("KAN field", "hidden", "is not positive", "use at least 1");
  if (!(options.bound > 0)) throw usage_error("KAN field", "bound", "is not positive", "use one above 0");
  if (points.empty()) throw usage_error("KAN field", "points", "there are none", "give at least one point");
  Box box;
  for (const Vec3f& x : points) box.add(x);
  const Vec3d centre = box.centre().cast<double>(), half = 0.5 * box.size().cast<double>().cwiseMax(1e-30f);
  for (const Vec3f& x : points) place_.push_back((x.cast<double>() - centre).cwiseQuotient(half));
}

size_t KanField::parameters() const { return static_cast<size_t>(4 * kEdge * options_.hidden + 1); }

std::vector<double> KanField::constant(std::span<const double> value) const {
  CHECK(value.size() == 1);
  std::vector<double> p(parameters(), 0.0);
  const double bound = 1 / std::sqrt(3.0);
  for (int e = 0; e < 3 * options_.hidden; ++e) {
    Random random(options_.seed, static_cast<uint64_t>(e));
    p[kEdge * e] = random.uniform(-bound, bound);
    for (int j = 1; j < kEdge; ++j) p[kEdge * e + j] = kNoise * random.normal();
  }
  const double share = std::clamp(value[0] / options_.bound, -1 + 1e-6, 1 - 1e-6);
  p.back() = std::isinf(options_.bound) ? value[0] : options_.bound * std::atanh(share);
  return p;
}

std::vector<double> KanField::values(std::span<const double> parameters) const {
  CHECK(parameters.size() == this->parameters());
  std::vector<double> out;
  out.reserve(place_.size());
  for (const Vec3d& x : place_)
    out.push_back(bounded(Evaluation(options_.hidden, parameters.data(), x).sum, options_.bound));
  return out;
}

std::vector<double> KanField::values_adjoint(std::span<const double> parameters,
                                             std::span<const double> adj_values) const {
  CHECK(parameters.size() == this->parameters() && adj_values.size() == place_.size());
  std::vector<double> adj(parameters.size(), 0.0);
  const double* first = parameters.data();
  const double* second = first + 3 * kEdge * options_.hidden;
  double* adj_second = adj.data() + 3 * kEdge * options_.hidden;
  for (size_t i = 0; i < place_.size(); ++i) {
    const Evaluation at(options_.hidden, first, place_[i]);
    const double adj_sum = bounded_adjoint(at.sum, options_.bound, adj_values[i]);
    adj.back() += adj_sum;
    for (int h = 0; h < options_.hidden; ++h) {
      const double adj_node = edge_adjoint(second + kEdge * h, at.hidden[h], adj_sum, adj_second + kEdge * h);
      for (int a = 0; a < 3; ++a) {
        const int e = kEdge * (3 * h + a);
        edge_adjoint(first + e, at.in[a], adj_node, adj.data() + e);
      }
    }
  }
  return adj;
}

}  // namespace pliant
