#include "physics/mpm/mpm.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "physics/laws/elasticity.h"
#include "physics/laws/material.h"
#include "physics/laws/pack.h"
#include "physics/mpm/bspline.h"
#include "physics/mpm/team.h"

namespace pliant {
namespace {

constexpr int kPatch = BlockGrid::kPatch, kSide = BlockGrid::kSide;

template <class T>
inline Pack<T>& pack_at(T* lanes) {
  return *reinterpret_cast<Pack<T>*>(lanes);
}

/// sum += increment without losing what is below the last digit of sum (Kahan 1965): a slow strain of many small
/// substeps would otherwise stand still in single precision, and the body would creep.
template <class T>
inline void accumulate(T& sum, T& rest, T increment) {
  const T whole = increment + rest, next = sum + whole;
  rest = whole - (next - sum);
  sum = next;
}

}  // namespace

template <class T>
Mpm<T>::Mpm(const BasicParticles<T>& particles, double dx, const Vec3d& origin)
    : dx_(static_cast<T>(dx)),
      inverse_dx_(static_cast<T>(1 / dx)),
      origin_(origin.cast<T>()),
      low_(Vec3<T>::Constant(-INFINITY)),
      high_(Vec3<T>::Constant(INFINITY)),
      rest_(particles.size()) {
  for (size_t i = 0; i < particles.size(); ++i) {
    const Lame<T> law = lame(particles.young[i], particles.poisson[i]);
    Record& r = rest_[i];
    r = {};
    r.mass = particles.mass[i], r.volume = particles.volume[i], r.mu = law.mu, r.lambda = law.lambda;
    r.index = static_cast<int>(i);
  }
}

template <class T>
void Mpm<T>::set_load_bits(const std::vector<uint32_t>& bits) {
  CHECK(bits.size() == rest_.size());
  for (size_t i = 0; i < bits.size(); ++i) rest_[i].bits = bits[i];
}

template <class T>
BlockGrid::Coordinates Mpm<T>::block_of(const T* x) const {
  const auto along = [&](int k) {
    return static_cast<int>(std::floor((x[k] - origin_[k]) * inverse_dx_ - T(0.5))) >> 2;
  };
  static_assert(kSide == 4);
  return {along(0), along(1), along(2)};
}

template <class T>
void Mpm<T>::load(const BasicSimulationState<T>& state, const Vec3d& low, const Vec3d& high) {
  const size_t n = rest_.size();
  CHECK(state.size() == n);
  low_ = low.cast<T>(), high_ = high.cast<T>();
  std::vector<Record> records(rest_);
  block_.resize(n);
  strays_ = 0;
  for (size_t i = 0; i < n; ++i) {
    Record& r = records[i];
    for (int a = 0; a < 3; ++a) {
      const T inside = std::clamp(state.x[i][a], low_[a], high_[a]);
      strays_ += inside != state.x[i][a];
      r.x[a] = inside, r.v[a] = state.v[i][a];
      for (int b = 0; b < 3; ++b) r.C[3 * a + b] = state.C[i](a, b), r.F[3 * a + b] = state.F[i](a, b);
    }
    block_[i] = block_of(r.x);
  }
  // Records lie in memory as the blocks are walked.
  record_ = std::move(records);
  sort_blocks();
  std::vector<Record> sorted(n);
  std::vector<BlockGrid::Coordinates> sorted_block(n);
  slot_.resize(n);
  for (size_t s = 0; s < n; ++s) {
    const int i = grid_.order()[s];
    sorted[s] = record_[i], sorted_block[s] = block_[i];
    slot_[i] = static_cast<int>(s);
  }
  record_ = std::move(sorted), block_ = std::move(sorted_block);
  sort_blocks();
  finite_ = true;
}

template <class T>
void Mpm<T>::store(BasicSimulationState<T>& state) const {
  const size_t n = record_.size();
  state.x.resize(n), state.v.resize(n), state.C.resize(n), state.F.resize(n);
  for (const Record& r : record_) {
    for (int a = 0; a < 3; ++a) {
      state.x[r.index][a] = r.x[a], state.v[r.index][a] = r.v[a];
      for (int b = 0; b < 3; ++b) state.C[r.index](a, b) = r.C[3 * a + b], state.F[r.index](a, b) = r.F[3 * a + b];
    }
  }
}

template <class T>
void Mpm<T>::sort_blocks() {
  BlockGrid::Coordinates low = block_[0], high = block_[0];
  for (const auto& b : block_) {
    low = {std::min(low.x, b.x), std::min(low.y, b.y), std::min(low.z, b.z)};
    high = {std::max(high.x, b.x), std::max(high.y, b.y), std::max(high.z, b.z)};
  }
  grid_.build(block_, low, high);
  patch_.resize(static_cast<size_t>(grid_.particle_blocks()) * BlockGrid::kPatchNodes);
  node_.resize(static_cast<size_t>(grid_.node_blocks()) * BlockGrid::kNodes);
  report_.resize(grid_.particle_blocks());
}

template <class T>
void Mpm<T>::scatter_block(int b, T dt, const StepLoads<T>& loads) {
  using P = Pack<T>;
  Node<T>* patch = patch_.data() + static_cast<size_t>(b) * BlockGrid::kPatchNodes;
  std::fill_n(patch, BlockGrid::kPatchNodes, Node<T>{});
  const T stress_scale = -dt * 4 * inverse_dx_;  // times V0 tau, per cell of distance
  const int end = grid_.begin(b + 1);
  for (int first = grid_.begin(b); first < end; first += kLanes) {
    const int lanes = std::min(kLanes, end - first);
    // Stress of four particles at once; unused lanes repeat the last one.
    P F[9], mu, lambda;
    for (int l = 0; l < kLanes; ++l) {
      const Record& r = record_[grid_.order()[first + std::min(l, lanes - 1)]];
      for (int k = 0; k < 9; ++k) F[k][l] = r.F[k];
      mu[l] = r.mu, lambda[l] = r.lambda;
    }
    P tau[6];
    kirchhoff_stress_pack<T>(Law::kFixedCorotated, F, mu, lambda, tau);

    for (int l = 0; l < lanes; ++l) {
      const Record& r = record_[grid_.order()[first + l]];
      T txx = tau[0][l], tyy = tau[1][l], tzz = tau[2][l], tyz = tau[3][l], txz = tau[4][l], txy = tau[5][l];
      const T* C = r.C;
      if (loads.viscosity_time > T(0)) {
        // Kelvin-Voigt: the linear law applied to the strain rate.
        const T two_mu = 2 * r.mu * loads.viscosity_time;
        const T pressure = r.lambda * loads.viscosity_time * (C[0] + C[4] + C[8]);
        txx += two_mu * C[0] + pressure, tyy += two_mu * C[4] + pressure, tzz += two_mu * C[8] + pressure;
        tyz += T(0.5) * two_mu * (C[5] + C[7]), txz += T(0.5) * two_mu * (C[2] + C[6]);
        txy += T(0.5) * two_mu * (C[1] + C[3]);
      }
      T v[3] = {r.v[0], r.v[1], r.v[2]};
      if (r.bits != 0) {
        for (const BodyLoad<T>& load : loads.body) {
          if ((r.bits & load.bit) == 0) continue;
          for (int a = 0; a < 3; ++a) v[a] += dt * (load.acceleration[a] - load.drag * r.v[a]);
        }
      }
      const T s = stress_scale * r.volume, m = r.mass * dx_;
      const P along_x = {m * C[0] + s * txx, m * C[3] + s * txy, m * C[6] + s * txz, 0};
      const P along_y = {m * C[1] + s * txy, m * C[4] + s * tyy, m * C[7] + s * tyz, 0};
      const P along_z = {m * C[2] + s * txz, m * C[5] + s * tyz, m * C[8] + s * tzz, 0};

      const Spline<T> sx((r.x[0] - origin_[0]) * inverse_dx_), sy((r.x[1] - origin_[1]) * inverse_dx_),
          sz((r.x[2] - origin_[2]) * inverse_dx_);
      const P base = P{r.mass * v[0], r.mass * v[1], r.mass * v[2], r.mass} - along_x * sx.offset -
                     along_y * sy.offset - along_z * sz.offset;
      Node<T>* corner = patch + ((sx.base & 3) * kPatch + (sy.base & 3)) * kPatch + (sz.base & 3);
      for (int i = 0; i < 3; ++i) {
        const P plane = base + along_x * T(i);
        for (int j = 0; j < 3; ++j) {
          const P row0 = plane + along_y * T(j), row1 = row0 + along_z, row2 = row1 + along_z;
          const T w = sx.weight[i] * sy.weight[j];
          T* node = corner[(i * kPatch + j) * kPatch].lane;
          pack_at<T>(node) += row0 * (w * sz.weight[0]);
          pack_at<T>(node + 4) += row1 * (w * sz.weight[1]);
          pack_at<T>(node + 8) += row2 * (w * sz.weight[2]);
        }
      }
    }
  }
}

template <class T>
void Mpm<T>::sum_node_block(int n) {
  Node<T>* node = node_.data() + static_cast<size_t>(n) * BlockGrid::kNodes;
  std::fill_n(node, BlockGrid::kNodes, Node<T>{});
  for (int o = 0; o < 8; ++o) {
    const int source = grid_.sources_of(n)[o];
    if (source < 0) continue;
    // The patch of a lower neighbour reaches two nodes deep into this block.
    const int ox = (o >> 2) * kSide, oy = (o >> 1 & 1) * kSide, oz = (o & 1) * kSide;
    const int ex = ox ? 2 : kSide, ey = oy ? 2 : kSide, ez = oz ? 2 : kSide;
    Node<T>* patch = patch_.data() + static_cast<size_t>(source) * BlockGrid::kPatchNodes;
    for (int i = 0; i < ex; ++i)
      for (int j = 0; j < ey; ++j) {
        Node<T>* from = patch + ((i + ox) * kPatch + j + oy) * kPatch + oz;
        Node<T>* to = node + (i * kSide + j) * kSide;
        for (int k = 0; k < ez; ++k) pack_at<T>(to[k].lane) += pack_at<T>(from[k].lane);
      }
  }
}

template <class T>
void Mpm<T>::update_node_block(int n, T dt, const StepLoads<T>& loads) {
  Node<T>* node = node_.data() + static_cast<size_t>(n) * BlockGrid::kNodes;
  const Pack<T> fall = {dt * loads.gravity[0], dt * loads.gravity[1], dt * loads.gravity[2], 0};
  for (int k = 0; k < BlockGrid::kNodes; ++k) {
    const T mass = node[k].lane[3];
    if (!(mass > T(0))) continue;
    Pack<T>& v = pack_at<T>(node[k].lane);
    v = (v * (1 / mass) + fall) * loads.velocity_scale;
    node[k].lane[3] = mass;
  }
  const BlockGrid::Coordinates& block = grid_.node_block(n);
  const double dx = dx_;
  apply_node_conditions<T>(loads,
                           {node, origin_.template cast<double>() + dx * kSide * Vec3d(block.x, block.y, block.z), dx});
}

template <class T>
void Mpm<T>::gather_block(int b, T dt) {
  using P = Pack<T>;
  P patch[BlockGrid::kPatchNodes];
  for (int o = 0; o < 8; ++o) {
    Node<T>* node = node_.data() + static_cast<size_t>(grid_.nodes_of(b)[o]) * BlockGrid::kNodes;
    const int ox = (o >> 2) * kSide, oy = (o >> 1 & 1) * kSide, oz = (o & 1) * kSide;
    const int ex = ox ? 2 : kSide, ey = oy ? 2 : kSide, ez = oz ? 2 : kSide;
    for (int i = 0; i < ex; ++i)
      for (int j = 0; j < ey; ++j)
        for (int k = 0; k < ez; ++k)
          patch[((i + ox) * kPatch + j + oy) * kPatch + oz + k] = pack_at<T>(node[(i * kSide + j) * kSide + k].lane);
  }

  BlockReport report{{INT32_MAX, INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN, INT32_MIN}, T(0), 0, false, true};
  const T c_scale = 4 * inverse_dx_;
  for (int s = grid_.begin(b); s < grid_.begin(b + 1); ++s) {
    const int index = grid_.order()[s];
    Record& r = record_[index];
    const Spline<T> sx((r.x[0] - origin_[0]) * inverse_dx_), sy((r.x[1] - origin_[1]) * inverse_dx_),
        sz((r.x[2] - origin_[2]) * inverse_dx_);
    const P* corner = patch + ((sx.base & 3) * kPatch + (sy.base & 3)) * kPatch + (sz.base & 3);
    // Moments of the node velocities, row by row.
    P v{}, bx{}, by{}, bz{};
    const T z0 = -sz.offset * sz.weight[0], z1 = (1 - sz.offset) * sz.weight[1], z2 = (2 - sz.offset) * sz.weight[2];
    for (int i = 0; i < 3; ++i) {
      P plane{}, plane_y{}, plane_z{};
      for (int j = 0; j < 3; ++j) {
        const P* node = corner + (i * kPatch + j) * kPatch;
        const P row = node[0] * sz.weight[0] + node[1] * sz.weight[1] + node[2] * sz.weight[2];
        const P row_z = node[0] * z0 + node[1] * z1 + node[2] * z2;
        plane += row * sy.weight[j];
        plane_y += row * (sy.weight[j] * (T(j) - sy.offset));
        plane_z += row_z * sy.weight[j];
      }
      v += plane * sx.weight[i];
      bx += plane * (sx.weight[i] * (T(i) - sx.offset));
      by += plane_y * sx.weight[i];
      bz += plane_z * sx.weight[i];
    }
    T size = 0;
    for (int a = 0; a < 3; ++a) {
      r.v[a] = v[a];
      r.C[3 * a] = c_scale * bx[a], r.C[3 * a + 1] = c_scale * by[a], r.C[3 * a + 2] = c_scale * bz[a];
    }
    T dF[9];
    for (int a = 0; a < 3; ++a)
      for (int c = 0; c < 3; ++c)
        dF[3 * a + c] = dt * (r.C[3 * a] * r.F[c] + r.C[3 * a + 1] * r.F[3 + c] + r.C[3 * a + 2] * r.F[6 + c]);
    for (int k = 0; k < 9; ++k) {
      accumulate(r.F[k], r.F_rest[k], dF[k]);
      size += r.F[k] * r.F[k];
    }
    const T speed = r.v[0] * r.v[0] + r.v[1] * r.v[1] + r.v[2] * r.v[2];
    report.max_speed_squared = std::max(report.max_speed_squared, speed);
    if (!(size + speed < T(1e18))) {  // also false for NaN; such a frame is given up
      report.finite = false;
      continue;
    }
    for (int a = 0; a < 3; ++a) {
      accumulate(r.x[a], r.x_rest[a], dt * r.v[a]);
      const T inside = std::min(std::max(r.x[a], low_[a]), high_[a]);
      if (inside == r.x[a]) continue;
      r.x[a] = inside, r.x_rest[a] = 0, r.v[a] = 0;
      ++report.strays;
    }
    const BlockGrid::Coordinates block = block_of(r.x);
    report.moved |= !(block == block_[index]);
    block_[index] = block;
  }
  report_[b] = report;
}

template <class T>
void Mpm<T>::collect_reports() {
  bool moved = false;
  T speed = 0;
  for (const BlockReport& r : report_) {
    moved |= r.moved, finite_ &= r.finite, strays_ += r.strays;
    speed = std::max(speed, r.max_speed_squared);
  }
  max_speed_ = std::sqrt(static_cast<double>(speed));
  if (moved && finite_) sort_blocks();
}

template <class T>
bool Mpm<T>::advance(int count, T dt, StepLoads<T>& loads, const std::function<void(int)>& prepare,
                     const std::function<bool()>& check, StepTape<T>* tape) {
  constexpr int kParticlesPerThread = 1000;  // below this a thread costs more than it brings
  const int useful = static_cast<int>(std::min<size_t>(record_.size() / kParticlesPerThread, 1024));
  const int threads = std::clamp(omp_get_max_threads(), 1, std::max(1, useful));
  std::exception_ptr error;
  Queue scatter, update, gather;
  if (tape) tape->low = low_, tape->high = high_;
  bool going = true, good = true;
  // What one thread does between steps.
  const auto between = [&](int k) {
    try {
      if (k > 0) {
        collect_reports();
        good = finite_ && check();
      }
      going = good && k < count;
      if (going) prepare(k);
      if (going && tape) tape->begin_step(dt, loads, grid_);
    } catch (...) {
      error = std::current_exception(), going = false;
    }
    scatter.reset(), update.reset(), gather.reset();
  };
  std::unique_ptr<Barrier> barrier;
#pragma omp parallel num_threads(threads)
  {
#pragma omp single
    barrier = std::make_unique<Barrier>(omp_get_num_threads());
    for (int k = 0;; ++k) {
      if (omp_get_thread_num() == 0) between(k);
      barrier->wait();
      if (!going) break;
      for (int b; (b = scatter.take()) < grid_.particle_blocks();) {
        if (tape) record_block(b, tape->last());
        scatter_block(b, dt, loads);
      }
      barrier->wait();
      for (int n; (n = update.take()) < grid_.node_blocks();) {
        sum_node_block(n);
        if (tape) record_node_block(n, tape->last());
        update_node_block(n, dt, loads);
      }
      barrier->wait();
      for (int b; (b = gather.take()) < grid_.particle_blocks();) gather_block(b, dt);
      barrier->wait();
    }
  }
  if (error) std::rethrow_exception(error);
  return good;
}

template <class T>
void Mpm<T>::record_block(int b, TapeStep<T>& step) const {
  for (int s = grid_.begin(b); s < grid_.begin(b + 1); ++s) {
    const Record& r = record_[grid_.order()[s]];
    TapeParticle<T>& to = step.particle[s];
    step.index[s] = r.index;
    std::copy_n(r.x, 3, to.x), std::copy_n(r.v, 3, to.v), std::copy_n(r.C, 9, to.C), std::copy_n(r.F, 9, to.F);
  }
}

template <class T>
void Mpm<T>::record_node_block(int n, TapeStep<T>& step) const {
  const size_t first = static_cast<size_t>(n) * BlockGrid::kNodes;
  std::copy_n(node_.data() + first, BlockGrid::kNodes, step.node.data() + first);
}

template <class T>
typename Mpm<T>::Snapshot Mpm<T>::save() const {
  Snapshot snapshot;
  snapshot.record_ = record_, snapshot.block_ = block_;
  return snapshot;
}

template <class T>
void Mpm<T>::restore(const Snapshot& snapshot) {
  CHECK(snapshot.record_.size() == rest_.size());
  record_ = snapshot.record_, block_ = snapshot.block_;
  sort_blocks();
}

template <class T>
void Mpm<T>::particles_to_grid(T dt, const StepLoads<T>& loads) {
  for (int b = 0; b < grid_.particle_blocks(); ++b) scatter_block(b, dt, loads);
  for (int n = 0; n < grid_.node_blocks(); ++n) sum_node_block(n);
}

template <class T>
void Mpm<T>::update_grid(T dt, const StepLoads<T>& loads) {
  for (int n = 0; n < grid_.node_blocks(); ++n) update_node_block(n, dt, loads);
}

template <class T>
void Mpm<T>::grid_to_particles(T dt) {
  for (int b = 0; b < grid_.particle_blocks(); ++b) gather_block(b, dt);
  collect_reports();
}

template <class T>
typename Mpm<T>::Motion Mpm<T>::motion_of(std::span<const int> particles) const {
  Motion motion;
  for (const int i : particles) {
    const Record& r = record_[slot_[i]];
    const double m = r.mass;
    motion.mass += m;
    motion.centre += m * Vec3d(r.x[0], r.x[1], r.x[2]);
    motion.velocity += m * Vec3d(r.v[0], r.v[1], r.v[2]);
  }
  if (motion.mass > 0) motion.centre /= motion.mass, motion.velocity /= motion.mass;
  return motion;
}

template <class T>
Totals Mpm<T>::grid_totals(bool velocities) const {
  Totals totals;
  for (int n = 0; n < grid_.node_blocks(); ++n) {
    const BlockGrid::Coordinates& block = grid_.node_block(n);
    for (int k = 0; k < BlockGrid::kNodes; ++k) {
      const Node<T>& node = node_[static_cast<size_t>(n) * BlockGrid::kNodes + k];
      const double mass = node.lane[3];
      const Vec3d x = origin_.template cast<double>() + double(dx_) * Vec3d(kSide * block.x + k / (kSide * kSide),
                                                                            kSide * block.y + k / kSide % kSide,
                                                                            kSide * block.z + k % kSide);
      const Vec3d momentum = Vec3d(node.lane[0], node.lane[1], node.lane[2]) * (velocities ? mass : 1.0);
      totals.mass += mass, totals.momentum += momentum, totals.angular += x.cross(momentum);
    }
  }
  return totals;
}

template <class T>
Totals Mpm<T>::particle_totals() const {
  Totals totals;
  for (const Record& r : record_) {
    const double m = r.mass, inertia = 0.25 * m * dx_ * dx_;
    const Vec3d x(r.x[0], r.x[1], r.x[2]), v(r.v[0], r.v[1], r.v[2]);
    totals.mass += m, totals.momentum += m * v;
    totals.angular += m * x.cross(v) + inertia * Vec3d(r.C[7] - r.C[5], r.C[2] - r.C[6], r.C[3] - r.C[1]);
  }
  return totals;
}

template class Mpm<float>;
template class Mpm<double>;

}  // namespace pliant
