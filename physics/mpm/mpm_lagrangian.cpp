// Nodes of Lagrangian runs: they belong to the body at rest and move with it.

#include "gaussians/base/portable.h"
#include "physics/mpm/bspline.h"
#include "physics/mpm/mpm.h"

namespace pliant {

template <class T>
void exact_piola(StressKind kind, const T* F, T mu, T lambda, T* P) {
  static const Material kMaterial[2] = {{.law = Law::kFixedCorotated}, {.law = Law::kNeoHookean}};
  using RowMajor = Eigen::Matrix<T, 3, 3, Eigen::RowMajor>;
  Eigen::Map<RowMajor>{P} =
      piola_stress<T>({&kMaterial[static_cast<int>(kind)], mu, lambda}, Eigen::Map<const RowMajor>(F));
}
template void exact_piola(StressKind, const float*, float, float, float*);
template void exact_piola(StressKind, const double*, double, double, double*);

template <class T>
void Mpm<T>::move_nodes(int n, T dt) {
  const size_t first = static_cast<size_t>(n) * BlockGrid::kNodes;
  for (int k = 0; k < BlockGrid::kNodes; ++k) {
    const T* v = data_.node[first + k].lane;
    data_.node_displacement[first + k] += dt * Vec3<T>(v[0], v[1], v[2]);
    data_.node_velocity[first + k] = data_.node[first + k];
  }
}

template <class T>
void Mpm<T>::begin_step() {
  whole_ = !options_.lagrangian || steps_ % options_.transfer_every == 0;
  ++steps_;
}

/// Rest positions by slot, and the displacements of the nodes from those of the particles, as velocities are
/// transferred: u_i = sum w m (u + (F - I) d) / sum w m.
template <class T>
void Mpm<T>::find_node_displacements(const BasicSimulationState<T>& state) {
  constexpr int kPatch = BlockGrid::kPatch;
  data_.rest_place.resize(4 * data_.record.size());
  data_.node_displacement.resize(data_.node.size());
  data_.node_velocity.assign(data_.node.size(), Node<T>{});
  gain_.assign(data_.record.size(), Vec3<T>::Zero());
  parallel_for(data_.grid.particle_blocks(), [&](std::ptrdiff_t b) {
    Node<T>* patch = data_.patch.data() + static_cast<size_t>(b) * BlockGrid::kPatchNodes;
    std::fill_n(patch, BlockGrid::kPatchNodes, Node<T>{});
    for (int s = data_.grid.begin(static_cast<int>(b)); s < data_.grid.begin(static_cast<int>(b) + 1); ++s) {
      const ParticleRecord<T>& r = data_.record[s];
      const Vec3<T>& X = data_.reference[r.index];
      for (int a = 0; a < 3; ++a) data_.rest_place[4 * static_cast<size_t>(s) + a] = X[a];
      data_.rest_place[4 * static_cast<size_t>(s) + 3] = 0;
      const Vec3<T> u = Vec3<T>(r.x[0], r.x[1], r.x[2]) - X;
      const Mat3<T> strain = state.F[r.index] - Mat3<T>::Identity();
      const auto along = [&](int a) { return Spline<T>((X[a] - data_.origin[a]) * data_.inverse_dx); };
      const Spline<T> sx = along(0), sy = along(1), sz = along(2);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          for (int k = 0; k < 3; ++k) {
            const Vec3<T> d(T(i) - sx.offset, T(j) - sy.offset, T(k) - sz.offset);
            const T m = r.mass * sx.weight[i] * sy.weight[j] * sz.weight[k];
            const Vec3<T> at_node = m * (u + data_.dx * (strain * d));
            T* lane = patch[(((sx.base & 3) + i) * kPatch + (sy.base & 3) + j) * kPatch + (sz.base & 3) + k].lane;
            for (int a = 0; a < 3; ++a) lane[a] += at_node[a];
            lane[3] += m;
          }
    }
  });
  parallel_for(data_.grid.node_blocks(), [&](std::ptrdiff_t n) {
    sum_node_block(static_cast<int>(n));
    const size_t first = static_cast<size_t>(n) * BlockGrid::kNodes;
    for (int k = 0; k < BlockGrid::kNodes; ++k) {
      const T* sum = data_.node[first + k].lane;
      data_.node_displacement[first + k] =
          sum[3] > T(0) ? Vec3<T>(Vec3<T>(sum[0], sum[1], sum[2]) / sum[3]) : Vec3<T>(Vec3<T>::Zero());
    }
  });
}

template class Mpm<float>;
template class Mpm<double>;

}  // namespace pliant
