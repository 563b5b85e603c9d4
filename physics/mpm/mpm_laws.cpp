// Laws that no kernel knows: after the gather their particles are mapped back to what the law allows, one by one, and
// their stress is written where the next scatter reads it.

#include "physics/mpm/mpm.h"

namespace pliant {
namespace {

template <class T>
using RowMajor = Eigen::Matrix<T, 3, 3, Eigen::RowMajor>;

}  // namespace

template <class T>
void Mpm<T>::set_given_stress(const ParticleRecord<T>& r, const Mat3<T>& F) {
  const LawPoint<T> point{&data_.materials[r.material], r.mu, r.lambda};
  const Mat3<T> tau = kirchhoff_stress(point, F, data_.side[r.side].memory);
  T* stress = data_.given_stress.data() + size_t{6} * static_cast<size_t>(r.side);
  stress[0] = tau(0, 0);
  stress[1] = tau(1, 1);
  stress[2] = tau(2, 2);
  stress[3] = tau(1, 2);
  stress[4] = tau(0, 2);
  stress[5] = tau(0, 1);
}

/// `grid_C` [count, 9] moved F; null where it is the C that the particles keep.
template <class T>
void Mpm<T>::apply_laws(int b, T dt, const T* grid_C) {
  for (int s = data_.grid.begin(b); s < data_.grid.begin(b + 1); ++s) {
    ParticleRecord<T>& r = data_.record[data_.grid.order()[s]];
    if (r.side < 0) continue;
    Eigen::Map<RowMajor<T>> stored(r.F);
    Mat3<T> F = stored;
    const LawPoint<T> point{&data_.materials[r.material], r.mu, r.lambda};
    if (has_memory(point.material->law)) {
      // F has advanced with the gather; the other deformations follow with the same velocity gradient.
      LawSide<T>& side = data_.side[r.side];
      LawMemory<T>& memory = side.memory;
      const Mat3<T> rate = dt * Eigen::Map<const RowMajor<T>>(grid_C ? grid_C + 9 * (s - data_.grid.begin(b)) : r.C),
                    total = rate * memory.F_total;
      for (int k = 0; k < 9; ++k) {
        T& sum = memory.F_total(k / 3, k % 3);
        const T whole = total(k / 3, k % 3) + side.total_rest[k], next = sum + whole;
        side.total_rest[k] = whole - (next - sum);
        sum = next;
      }
      memory.F_viscous += (rate * memory.F_viscous).eval();
      const Mat3<T> trial = F;
      return_map(point, dt, F, memory);
      if (F != trial) {
        stored = F;
        std::fill_n(r.F_rest, 9, T(0));
      }
    }
    set_given_stress(r, F);
  }
}

template class Mpm<float>;
template class Mpm<double>;

}  // namespace pliant
