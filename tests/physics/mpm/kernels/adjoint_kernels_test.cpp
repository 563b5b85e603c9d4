// The parts of a reverse step, each alone, against differences of plain loops in double, for every instruction set.

#include <gtest/gtest.h>

#include "physics/laws/law.h"
#include "physics/mpm/adjoint/node_update_adjoint.h"
#include "physics/mpm/bspline.h"
#include "physics/mpm/kernels/step_adjoint_view.h"
#include "tests/check_adjoint.h"
#include "tests/instruction_sets.h"

namespace pliant {
namespace {

using Row3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using List = std::vector<double>;

constexpr int kCount = 3, kPatchNodes = BlockGrid::kPatchNodes;
constexpr double kDx = 0.5, kDt = 0.02, kOrigin[3] = {0.1, -0.2, 0.3}, kVolume = 0.05;

void exact_stress(StressKind kind, const double* F, double mu, double lambda, double* tau) {
  const Material material{.law = kind == StressKind::kNeoHookean ? Law::kNeoHookean : Law::kFixedCorotated};
  const Mat3d t = kirchhoff_stress<double>({&material, mu, lambda}, Eigen::Map<const Row3>(F), {});
  const int row[6] = {0, 1, 2, 1, 0, 0}, column[6] = {0, 1, 2, 2, 2, 1};
  for (int k = 0; k < 6; ++k) tau[k] = t(row[k], column[k]);
}
void exact_adjoint(StressKind kind, const double* F, double mu, double lambda, const double* s, double* by_F,
                   double* by_lame) {
  const Material material{.law = kind == StressKind::kNeoHookean ? Law::kNeoHookean : Law::kFixedCorotated};
  Mat3d S;
  S << s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2];
  const auto g = kirchhoff_stress_adjoint<double>({&material, mu, lambda}, Eigen::Map<const Row3>(F), {}, S);
  Eigen::Map<Row3>{by_F} = g.F;
  by_lame[0] = g.mu;
  by_lame[1] = g.lambda;
}

/// Calls visit(node of the patch, weight, node minus particle [cells]) for the 27 nodes around x.
template <class Visit>
void for_nodes(const double* x, Visit&& visit) {
  const Spline<double> s[3] = {Spline<double>((x[0] - kOrigin[0]) / kDx), Spline<double>((x[1] - kOrigin[1]) / kDx),
                               Spline<double>((x[2] - kOrigin[2]) / kDx)};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k)
        visit((((s[0].base & 3) + i) * 6 + (s[1].base & 3) + j) * 6 + (s[2].base & 3) + k,
              s[0].weight[i] * s[1].weight[j] * s[2].weight[k],
              Vec3d(i - s[0].offset, j - s[1].offset, k - s[2].offset));
}

/// Random x, F, v, C [24] of particles of one block, away from the places where a spline changes its nodes.
List random_particles(double spread) {
  List u;
  for (int p = 0; p < kCount; ++p) {
    Random random(5, p);
    for (int a = 0; a < 3; ++a)
      u.push_back(kOrigin[a] + kDx * (0.6 + static_cast<double>(random.below(4)) + 0.8 * random.uniform()));
    for (int k = 0; k < 9; ++k) u.push_back((k % 4 == 0) + spread * random.normal());
    for (int k = 0; k < 12; ++k) u.push_back(random.normal());
  }
  return u;
}

struct OneBlock {
  std::vector<TapeParticle<double>> particle{kCount};
  std::vector<AdjointRecord<double>> record{kCount};
  std::vector<int> index = {0, 1, 2}, slot = {2, 0, 1};
  AdjointRun<double> run{};

  explicit OneBlock(const List& u, size_t stride) {
    for (int p = 0; p < kCount; ++p) {
      std::copy_n(u.data() + p * stride, 24, particle[p].x);
      at(p) = {};
      at(p).volume = kVolume;
    }
    run.particle = particle.data();
    run.record = record.data();
    run.index = index.data();
    run.slot = slot.data();
    run.count = kCount;
    run.dt = kDt;
    run.dx = kDx;
    run.inverse_dx = 1 / kDx;
    for (int a = 0; a < 3; ++a) {
      run.origin[a] = kOrigin[a];
      run.low[a] = -1e9;
      run.high[a] = 1e9;
    }
    run.exact_stress = exact_stress;
    run.exact_adjoint = exact_adjoint;
  }
  AdjointRecord<double>& at(int p) { return record[slot[p]]; }
};

AdjointCheckOptions few() {
  AdjointCheckOptions options;
  options.unit_cotangents = 6;
  options.inputs = 40;
  return options;
}

// x, F, v, C [24] of each particle and the node velocities after and before the step [2, 216, 3]  ->  x, F, v, C [24].
struct Gather {
  double flip;
  static constexpr int kStride = 24;

  List operator()(const List& u) const {
    List out;
    const double *node = u.data() + kStride * kCount, *old = node + 3 * kPatchNodes;
    for (int p = 0; p < kCount; ++p) {
      const double* x = u.data() + kStride * p;
      Vec3d pic = Vec3d::Zero(), before = pic;
      Mat3d C = Mat3d::Zero(), C_before = C;
      for_nodes(x, [&](int n, double w, const Vec3d& d) {
        const Vec3d vi = Eigen::Map<const Vec3d>(node + 3 * n), old_vi = Eigen::Map<const Vec3d>(old + 3 * n);
        pic += w * vi;
        C += 4 / kDx * w * vi * d.transpose();
        before += w * old_vi;
        C_before += 4 / kDx * w * old_vi * d.transpose();
      });
      const Vec3d v = pic + flip * (Eigen::Map<const Vec3d>(x + 12) - before);
      const Row3 F = (Mat3d::Identity() + kDt * C) * Eigen::Map<const Row3>(x + 3);
      const Row3 rows = C + flip * (Eigen::Map<const Row3>(x + 15) - C_before);
      for (int a = 0; a < 3; ++a) out.push_back(x[a] + kDt * pic[a]);
      out.insert(out.end(), F.data(), F.data() + 9);
      out.insert(out.end(), v.data(), v.data() + 3);
      out.insert(out.end(), rows.data(), rows.data() + 9);
    }
    return out;
  }

  List adjoint(InstructionSet set, const List& u, const List& adj) const {
    const List after = Gather{0.0}(u);  // of the grid
    OneBlock block(u, kStride);
    block.run.flip = flip;
    for (int p = 0; p < kCount; ++p) {
      std::copy_n(adj.data() + 24 * p, 24, block.at(p).x);
      std::copy_n(after.data() + 24 * p + 12, 12, block.at(p).v_after);
    }
    alignas(64) double node[2][4 * kPatchNodes] = {}, by_node[2][4 * kPatchNodes] = {};
    for (int k = 0; k < 6 * kPatchNodes; ++k)
      node[k / (3 * kPatchNodes)][k / 3 % kPatchNodes * 4 + k % 3] = u[kStride * kCount + k];
    adjoint_kernels<double>(set).gather(block.run, node[0], by_node[0], node[1], by_node[1]);
    List by;
    for (int p = 0; p < kCount; ++p) {
      by.insert(by.end(), block.at(p).x, block.at(p).x + 12);
      const double* v_and_C = block.at(p).v;
      for (int k = 0; k < 12; ++k) by.push_back(flip > 0 ? v_and_C[k] : 0.0);
    }
    for (int k = 0; k < 6 * kPatchNodes; ++k)
      by.push_back(by_node[k / (3 * kPatchNodes)][k / 3 % kPatchNodes * 4 + k % 3]);
    return by;
  }
};

TEST(AdjointKernels, GatherAgreesWithDifferences) {
  List u = random_particles(0.3);
  for (int k = 0; k < 6 * kPatchNodes; ++k) u.push_back(Random(6, k).normal());
  AdjointCheckOptions options = few();
  options.inputs = 100;
  for (const InstructionSet set : fixture::instruction_sets())
    for (const Gather gather : {Gather{0.0}, Gather{0.7}}) {
      const AdjointCheck check = check_adjoint(
          gather, [&](const List& at, const List& adj) { return gather.adjoint(set, at, adj); }, u, options);
      EXPECT_LT(check.worst, 1e-6) << name_of(set) << " " << check.message;
    }
}

// x, F, v, C, mass, mu, lambda, damping rate [28] of each particle, viscosity time  ->  momentum and mass of the nodes,
// with stress and of the inertia alone [2, 216, 4].
struct Scatter {
  StressKind kind;
  bool any;  // with damping, viscosity and velocities that loads have changed
  double flip = 0;
  static constexpr int kStride = 28;

  /// What loads gave to particle p.
  Vec3d gain(int p) const { return any ? Vec3d(0.3 * p, -0.2, 0.1) : Vec3d(Vec3d::Zero()); }

  List operator()(const List& u) const {
    List node(8 * kPatchNodes);
    const double* extra = u.data() + kStride * kCount;
    for (int p = 0; p < kCount; ++p) {
      const double *x = u.data() + kStride * p, mass = x[24], mu = x[25], lambda = x[26];
      const Mat3d F = Eigen::Map<const Row3>(x + 3), C = Eigen::Map<const Row3>(x + 15);
      const Vec3d v = Eigen::Map<const Vec3d>(x + 12) + gain(p);
      const Material material{.law = kind == StressKind::kNeoHookean ? Law::kNeoHookean : Law::kFixedCorotated};
      Mat3d tau = kirchhoff_stress<double>({&material, mu, lambda}, F, {});
      double kept = 1;
      if (any) {
        tau += extra[0] * (mu * (C + C.transpose()) + lambda * C.trace() * Mat3d::Identity());
        kept = std::exp(-kDt * x[27]);
      }
      for_nodes(x, [&](int n, double w, const Vec3d& d) {
        const Vec3d inertia = mass * (v + kDx * C * d), force = -kDt * kVolume * 4 / kDx * tau * d;
        for (int old = 0; old < (flip > 0 ? 2 : 1); ++old) {
          double* to = node.data() + 4 * (n + old * kPatchNodes);
          for (int a = 0; a < 3; ++a) to[a] += w * (old ? inertia[a] : kept * inertia[a] + force[a]);
          to[3] += w * mass;
        }
      });
    }
    return node;
  }

  List adjoint(InstructionSet set, const List& u, const List& adj) const {
    const double* extra = u.data() + kStride * kCount;
    OneBlock block(u, kStride);
    List loaded_v;
    for (int p = 0; p < kCount; ++p) {
      AdjointRecord<double>& r = block.at(p);
      const double* x = u.data() + kStride * p;
      r.mass = x[24];
      r.mu = x[25];
      r.lambda = x[26];
      r.damping_rate = any ? x[27] : 0;
      r.stress_kind = static_cast<double>(static_cast<int>(kind));
      for (int a = 0; a < 3; ++a) loaded_v.push_back(x[12 + a] + gain(p)[a]);
    }
    if (any) {
      block.run.viscosity_time = extra[0];
      block.run.loaded_v = loaded_v.data();
    }
    alignas(64) double node[2][4 * kPatchNodes];
    std::copy(adj.begin(), adj.end(), node[0]);
    block.run.flip = flip;
    adjoint_kernels<double>(set).scatter[any ? 2 : static_cast<int>(kind)](block.run, node[0], node[1]);
    List by;
    double by_time = 0;
    for (int p = 0; p < kCount; ++p) {
      const AdjointRecord<double>& r = block.at(p);
      by.insert(by.end(), r.x, r.x + 24);
      by.insert(by.end(), {r.by_mass, r.by_mu, r.by_lambda, r.by_damping_rate});
      by_time += r.by_viscosity_time;
    }
    by.push_back(by_time);
    return by;
  }
};

void check_scatter(const Scatter& scatter, double spread) {
  List u;
  const List particles = random_particles(spread);
  for (int p = 0; p < kCount; ++p) {
    u.insert(u.end(), particles.begin() + 24 * p, particles.begin() + 24 * p + 24);
    u.insert(u.end(), {1.5 - 0.3 * p, 2.0 + p, 3.0, 0.7});
  }
  u.push_back(0.05);
  for (const InstructionSet set : fixture::instruction_sets()) {
    const AdjointCheck check = check_adjoint(
        scatter, [&](const List& at, const List& adj) { return scatter.adjoint(set, at, adj); }, u, few());
    EXPECT_LT(check.worst, 1e-6) << name_of(set) << " " << static_cast<int>(scatter.kind) << " " << check.message;
  }
}

TEST(AdjointKernels, ScatterOfEachLawAgreesWithDifferences) {
  check_scatter({StressKind::kFixedCorotated, false}, 0.1);
  check_scatter({StressKind::kNeoHookean, false}, 0.1);
}

TEST(AdjointKernels, ScatterWithDampingViscosityAndLoadsAgreesWithDifferences) {
  check_scatter({StressKind::kFixedCorotated, true}, 0.1);
  check_scatter({StressKind::kNeoHookean, true}, 0.1);
}

TEST(AdjointKernels, ScatterForFlipAgreesWithDifferences) {
  check_scatter({StressKind::kFixedCorotated, false, 0.7}, 0.1);
  check_scatter({StressKind::kNeoHookean, true, 0.7}, 0.1);
}

TEST(AdjointKernels, ScatterOfStretchedAndInvertedParticlesAgreesWithDifferences) {
  const List particles = random_particles(0.8);
  int inverted = 0;
  for (int p = 0; p < kCount; ++p) inverted += Eigen::Map<const Row3>(particles.data() + 24 * p + 3).determinant() < 0;
  ASSERT_GT(inverted, 0);
  check_scatter({StressKind::kFixedCorotated, false}, 0.8);
  check_scatter({StressKind::kNeoHookean, true}, 0.8);
}

TEST(AdjointKernels, NodeUpdateWithPinsAndFrictionAgreesWithDifferences) {
  StepLoads<double> loads;
  loads.velocity_scale = 0.9;
  loads.pins = {Region::half_space(Vec3d(0, 0, -0.2), Vec3d(0, 0, 1))};
  Collider ground;
  ground.kind = ContactKind::kSeparating;
  ground.friction = 0.4;
  ground.shape = Region::half_space(Vec3d(0.6, 0, 0), Vec3d(1, 0, 0));
  loads.colliders = {ground};
  const auto block_of = [](Node<double>* node) { return NodeBlock<double>{node, Vec3d(0, 0, 0), kDx}; };
  constexpr int n = BlockGrid::kNodes;
  List u;  // momentum, mass of each node; gravity; velocity scale
  for (int k = 0; k < n; ++k) {
    Random random(8, k);
    for (int a = 0; a < 3; ++a) u.push_back(random.normal() - (a == 0 ? 2 : 0));  // towards the ground
    u.push_back(k % 7 == 0 ? 0.0 : 1 + random.uniform());
  }
  u.insert(u.end(), {1, -2, 3, 0.9});
  const auto loads_of = [&](const List& at) {
    StepLoads<double> l = loads;
    l.gravity = Vec3d(at[4 * n], at[4 * n + 1], at[4 * n + 2]);
    l.velocity_scale = at[4 * n + 3];
    return l;
  };
  const auto sums_of = [&](const List& at, Node<double>* node) {
    for (int k = 0; k < 4 * n; ++k) node[k / 4].lane[k % 4] = k / 4 % 7 == 0 ? 0.0 : at[k];  // a node without mass
  };
  const auto forward = [&](const List& at) {
    alignas(64) Node<double> node[n];
    sums_of(at, node);
    const StepLoads<double> l = loads_of(at);
    List out;
    for (Node<double>& one : node)
      if (one.lane[3] > 0)
        for (int a = 0; a < 3; ++a) one.lane[a] = (one.lane[a] / one.lane[3] + kDt * l.gravity[a]) * l.velocity_scale;
    apply_node_conditions(l, block_of(node));
    for (const Node<double>& one : node) out.insert(out.end(), one.lane, one.lane + 3);
    return out;
  };
  for (const InstructionSet set : fixture::instruction_sets()) {
    const auto adjoint = [&](const List& at, const List& adj) {
      alignas(64) Node<double> sums[n], by[n] = {};
      sums_of(at, sums);
      for (int k = 0; k < 3 * n; ++k) by[k / 3].lane[k % 3] = adj[k];
      StepLoadsGradient by_loads;
      const StepLoads<double> l = loads_of(at);
      alignas(64) Node<double> updated[n];
      std::copy_n(sums, n, updated);
      const Vec3d fall = kDt * l.gravity;
      mpm_kernels<double>(set).update_nodes(updated->lane, fall.data(), l.velocity_scale);
      apply_node_conditions_adjoint(l, block_of(updated), by);
      reverse_node_update(kDt, l, sums, by, by_loads);
      List out;
      for (const Node<double>& one : by) out.insert(out.end(), one.lane, one.lane + 4);
      out.insert(out.end(), by_loads.gravity.data(), by_loads.gravity.data() + 3);
      out.push_back(by_loads.velocity_scale);
      return out;
    };
    AdjointCheckOptions options = few();
    options.step = 1e-3;
    options.inputs = 300;
    const AdjointCheck check = check_adjoint(forward, adjoint, u, options);
    EXPECT_LT(check.worst, 1e-6) << name_of(set) << " " << check.message;
  }
}

}  // namespace
}  // namespace pliant
