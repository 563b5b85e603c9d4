#include <algorithm>
#include <cmath>

#include "physics/laws/elasticity.h"
#include "physics/laws/pack.h"
#include "physics/mpm/bspline.h"
#include "physics/mpm/mpm.h"

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
void Mpm<T>::scatter_block(int b, T dt, const StepLoads<T>& loads) {
  using P = Pack<T>;
  Node<T>* patch = data_.patch.data() + static_cast<size_t>(b) * BlockGrid::kPatchNodes;
  std::fill_n(patch, BlockGrid::kPatchNodes, Node<T>{});
  const T stress_scale = -dt * 4 * data_.inverse_dx;  // times V0 tau, per cell of distance
  const int end = data_.grid.begin(b + 1);
  for (int first = data_.grid.begin(b); first < end; first += kLanes) {
    const int lanes = std::min(kLanes, end - first);
    // Stress of four particles at once; unused lanes repeat the last one.
    P F[9], mu, lambda;
    for (int l = 0; l < kLanes; ++l) {
      const ParticleRecord<T>& r = data_.record[data_.grid.order()[first + std::min(l, lanes - 1)]];
      for (int k = 0; k < 9; ++k) F[k][l] = r.F[k];
      mu[l] = r.mu, lambda[l] = r.lambda;
    }
    P tau[6];
    kirchhoff_stress_pack<T>(Law::kFixedCorotated, F, mu, lambda, tau);

    for (int l = 0; l < lanes; ++l) {
      const ParticleRecord<T>& r = data_.record[data_.grid.order()[first + l]];
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
      const T s = stress_scale * r.volume, m = r.mass * data_.dx;
      const P along_x = {m * C[0] + s * txx, m * C[3] + s * txy, m * C[6] + s * txz, 0};
      const P along_y = {m * C[1] + s * txy, m * C[4] + s * tyy, m * C[7] + s * tyz, 0};
      const P along_z = {m * C[2] + s * txz, m * C[5] + s * tyz, m * C[8] + s * tzz, 0};

      const Spline<T> sx((r.x[0] - data_.origin[0]) * data_.inverse_dx), sy((r.x[1] - data_.origin[1]) * data_.inverse_dx),
          sz((r.x[2] - data_.origin[2]) * data_.inverse_dx);
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
  Node<T>* node = data_.node.data() + static_cast<size_t>(n) * BlockGrid::kNodes;
  std::fill_n(node, BlockGrid::kNodes, Node<T>{});
  for (int o = 0; o < 8; ++o) {
    const int source = data_.grid.sources_of(n)[o];
    if (source < 0) continue;
    // The patch of a lower neighbour reaches two nodes deep into this block.
    const int ox = (o >> 2) * kSide, oy = (o >> 1 & 1) * kSide, oz = (o & 1) * kSide;
    const int ex = ox ? 2 : kSide, ey = oy ? 2 : kSide, ez = oz ? 2 : kSide;
    Node<T>* patch = data_.patch.data() + static_cast<size_t>(source) * BlockGrid::kPatchNodes;
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
  Node<T>* node = data_.node.data() + static_cast<size_t>(n) * BlockGrid::kNodes;
  const Pack<T> fall = {dt * loads.gravity[0], dt * loads.gravity[1], dt * loads.gravity[2], 0};
  for (int k = 0; k < BlockGrid::kNodes; ++k) {
    const T mass = node[k].lane[3];
    if (!(mass > T(0))) continue;
    Pack<T>& v = pack_at<T>(node[k].lane);
    v = (v * (1 / mass) + fall) * loads.velocity_scale;
    node[k].lane[3] = mass;
  }
}

template <class T>
void Mpm<T>::apply_conditions(int n, const StepLoads<T>& loads) {
  const BlockGrid::Coordinates& block = data_.grid.node_block(n);
  const double dx = data_.dx;
  const Vec3d first = data_.origin.template cast<double>() + dx * kSide * Vec3d(block.x, block.y, block.z);
  apply_node_conditions<T>(loads, {data_.node.data() + static_cast<size_t>(n) * BlockGrid::kNodes, first, dx});
}

template <class T>
void Mpm<T>::gather_block(int b, T dt) {
  using P = Pack<T>;
  P patch[BlockGrid::kPatchNodes];
  for (int o = 0; o < 8; ++o) {
    Node<T>* node = data_.node.data() + static_cast<size_t>(data_.grid.nodes_of(b)[o]) * BlockGrid::kNodes;
    const int ox = (o >> 2) * kSide, oy = (o >> 1 & 1) * kSide, oz = (o & 1) * kSide;
    const int ex = ox ? 2 : kSide, ey = oy ? 2 : kSide, ez = oz ? 2 : kSide;
    for (int i = 0; i < ex; ++i)
      for (int j = 0; j < ey; ++j)
        for (int k = 0; k < ez; ++k)
          patch[((i + ox) * kPatch + j + oy) * kPatch + oz + k] = pack_at<T>(node[(i * kSide + j) * kSide + k].lane);
  }

  BlockReport report{T(0), 0, 0, true};
  const T c_scale = 4 * data_.inverse_dx;
  for (int s = data_.grid.begin(b); s < data_.grid.begin(b + 1); ++s) {
    const int index = data_.grid.order()[s];
    ParticleRecord<T>& r = data_.record[index];
    const Spline<T> sx((r.x[0] - data_.origin[0]) * data_.inverse_dx), sy((r.x[1] - data_.origin[1]) * data_.inverse_dx),
        sz((r.x[2] - data_.origin[2]) * data_.inverse_dx);
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
      const T inside = std::min(std::max(r.x[a], data_.low[a]), data_.high[a]);
      if (inside == r.x[a]) continue;
      r.x[a] = inside, r.x_rest[a] = 0, r.v[a] = 0;
      ++report.strays;
    }
    if (!(block_of(r) == data_.grid.block(b))) moved_[data_.grid.begin(b) + report.moves++] = s;
  }
  report_[b] = report;
}

template class Mpm<float>;
template class Mpm<double>;

}  // namespace pliant
