#include "physics/mpm/mpm.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

StressKind stress_kind(Law law) {
  if (law == Law::kFixedCorotated) return StressKind::kFixedCorotated;
  return law == Law::kNeoHookean ? StressKind::kNeoHookean : StressKind::kGiven;
}

}  // namespace

template <class T>
Mpm<T>::Mpm(const BasicParticles<T>& particles, double dx, const Vec3d& origin)
    : rest_(particles.size()), kernels_(&mpm_kernels<T>(best_instruction_set())) {
  data_.dx = static_cast<T>(dx), data_.inverse_dx = static_cast<T>(1 / dx);
  data_.origin = origin.cast<T>();
  for (size_t i = 0; i < particles.size(); ++i) {
    const Lame<T> law = lame(particles.young[i], particles.poisson[i]);
    ParticleRecord<T>& r = rest_[i];
    r = {};
    r.mass = particles.mass[i], r.volume = particles.volume[i], r.mu = law.mu, r.lambda = law.lambda;
    r.index = static_cast<int>(i);
    r.material = particles.material_index.empty() ? 0 : particles.material_index[i];
    r.object = particles.object.empty() ? 0 : particles.object[i];
    const StressKind kind = stress_kind(particles.material(i).law);
    r.stress_kind = static_cast<T>(static_cast<int>(kind));
    if (i == 0) uniform_ = kind;
    if (kind != uniform_) uniform_ = StressKind::kGiven;
  }
}

template <class T>
void Mpm<T>::set_load_bits(const std::vector<uint32_t>& bits) {
  CHECK(bits.size() == rest_.size());
  for (size_t i = 0; i < bits.size(); ++i) rest_[i].bits = bits[i];
}

template <class T>
BlockGrid::Coordinates Mpm<T>::block_of(const ParticleRecord<T>& r) const {
  const auto along = [&](int k) {
    return static_cast<int>(std::floor((r.x[k] - data_.origin[k]) * data_.inverse_dx - T(0.5))) >> 2;
  };
  static_assert(BlockGrid::kSide == 4);
  return {along(0), along(1), along(2), r.object};
}

template <class T>
void Mpm<T>::load(const BasicSimulationState<T>& state, const Vec3d& low, const Vec3d& high) {
  const size_t n = rest_.size();
  CHECK(state.size() == n);
  const Vec3d centre = data_.origin.template cast<double>();
  const Vec3d reach = Vec3d::Constant(static_cast<double>(data_.dx) * (BlockGrid::kSide * BlockGrid::kReach - 8));
  data_.low = low.cwiseMax(centre - reach).template cast<T>();
  data_.high = high.cwiseMin(centre + reach).template cast<T>();
  strays_ = 0;
  std::vector<ParticleRecord<T>> records(rest_);
  std::vector<BlockGrid::Coordinates> block(n);
  for (size_t i = 0; i < n; ++i) {
    ParticleRecord<T>& r = records[i];
    for (int a = 0; a < 3; ++a) {
      const T inside = std::clamp(state.x[i][a], data_.low[a], data_.high[a]);
      strays_ += inside != state.x[i][a];
      r.x[a] = inside, r.v[a] = state.v[i][a];
      for (int b = 0; b < 3; ++b) r.C[3 * a + b] = state.C[i](a, b), r.F[3 * a + b] = state.F[i](a, b);
    }
    block[i] = block_of(r);
  }
  // Records lie in memory as the blocks are walked.
  data_.grid.build(block);
  data_.record.resize(n), data_.slot.resize(n);
  for (size_t s = 0; s < n; ++s) {
    int& i = data_.grid.order()[s];
    data_.record[s] = records[i];
    data_.slot[i] = static_cast<int>(s);
    i = static_cast<int>(s);
  }
  moved_.resize(n);
  fit_blocks();
  finite_ = true;
}

template <class T>
void Mpm<T>::store(BasicSimulationState<T>& state) const {
  const size_t n = data_.record.size();
  state.x.resize(n), state.v.resize(n), state.C.resize(n), state.F.resize(n);
  for (const ParticleRecord<T>& r : data_.record) {
    for (int a = 0; a < 3; ++a) {
      state.x[r.index][a] = r.x[a], state.v[r.index][a] = r.v[a];
      for (int b = 0; b < 3; ++b) state.C[r.index](a, b) = r.C[3 * a + b], state.F[r.index](a, b) = r.F[3 * a + b];
    }
  }
}

template <class T>
void Mpm<T>::fit_blocks() {
  data_.patch.resize(static_cast<size_t>(data_.grid.particle_blocks()) * BlockGrid::kPatchNodes);
  data_.node.resize(static_cast<size_t>(data_.grid.node_blocks()) * BlockGrid::kNodes);
  report_.resize(data_.grid.particle_blocks());
}

template <class T>
void Mpm<T>::collect_reports() {
  T speed = 0;
  std::vector<BlockGrid::Move> moves;
  for (int b = 0; b < data_.grid.particle_blocks(); ++b) {
    const GatherReport<T>& r = report_[b];
    finite_ &= r.finite, strays_ += r.strays;
    speed = std::max(speed, r.max_speed_squared);
    for (int m = 0; m < r.moves && finite_; ++m) {
      const int begin = data_.grid.begin(b), place = begin + moved_[begin + m];
      moves.push_back({place, block_of(data_.record[data_.grid.order()[place]])});
    }
  }
  max_speed_ = std::sqrt(static_cast<double>(speed));
  if (moves.empty() || !finite_) return;
  data_.grid.move(moves);
  fit_blocks();
}

template class Mpm<float>;
template class Mpm<double>;

}  // namespace pliant
