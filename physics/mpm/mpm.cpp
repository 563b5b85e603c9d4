#include "physics/mpm/mpm.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"

namespace pliant {
namespace {

StressKind stress_kind(Law law, bool lagrangian) {
  if (law == Law::kFixedCorotated) return StressKind::kFixedCorotated;
  if (law == Law::kNeoHookean) return StressKind::kNeoHookean;
  return law == Law::kHencky && lagrangian ? StressKind::kHencky : StressKind::kGiven;
}

}  // namespace

const Material& plain_material(StressKind kind) {
  static const Material kFixedCorotated{.law = Law::kFixedCorotated}, kNeoHookean{.law = Law::kNeoHookean},
      kHencky{.law = Law::kHencky};
  CHECK(kind != StressKind::kGiven);
  if (kind == StressKind::kHencky) return kHencky;
  return kind == StressKind::kNeoHookean ? kNeoHookean : kFixedCorotated;
}

template <class T>
Mpm<T>::Mpm(const BasicParticles<T>& particles, double dx, const Vec3d& origin, const MpmOptions& options)
    : rest_(particles.size()), kernels_(&mpm_kernels<T>(best_instruction_set())), options_(options) {
  data_.dx = static_cast<T>(dx);
  data_.inverse_dx = static_cast<T>(1 / dx);
  data_.origin = origin.cast<T>();
  data_.materials = particles.materials;
  data_.reference = particles.position;
  if (options.lagrangian) links_ = particles.links;
  int given = 0;
  bool plain = true;
  for (size_t i = 0; i < particles.size(); ++i) {
    const Lame<T> law = lame(particles.young[i], particles.poisson[i]);
    const Material& material = particles.material(i);
    ParticleRecord<T>& r = rest_[i];
    r = {};
    r.mass = particles.mass[i];
    r.volume = particles.volume[i];
    r.mu = law.mu;
    r.lambda = law.lambda;
    r.index = static_cast<int>(i);
    r.material = particles.material_index.empty() ? 0 : particles.material_index[i];
    r.object = particles.object.empty() ? 0 : particles.object[i];
    const Viscosity<T> viscous = viscosity<T>({&material, law.mu, law.lambda});
    r.shear_viscosity = viscous.shear;
    r.bulk_viscosity = viscous.bulk;
    r.damping_rate = material.damping_time > 0 ? static_cast<T>(2 / material.damping_time) : T(0);
    const StressKind kind = stress_kind(material.law, options.lagrangian);
    r.stress_kind = static_cast<T>(static_cast<int>(kind));
    r.side = kind == StressKind::kGiven ? given++ : -1;
    if (i == 0) uniform_ = kind;
    viscous_ |= r.shear_viscosity != 0 || r.bulk_viscosity != 0;
    plain &= kind == uniform_ && !viscous_ && (options.lagrangian || r.damping_rate == 0);
  }
  if (!plain || uniform_ == StressKind::kHencky) uniform_ = StressKind::kGiven;
  data_.side.resize(given);
  data_.given_stress.resize(6 * static_cast<size_t>(given));
  CHECK_MSG(!options.lagrangian || (given == 0 && !(options.flip_time > 0) && !sleeping()),
            "only elastic laws have a reference configuration");
}

template <class T>
void Mpm<T>::set_load_bits(const std::vector<uint32_t>& bits) {
  CHECK(bits.size() == rest_.size());
  for (size_t i = 0; i < bits.size(); ++i) rest_[i].bits = bits[i];
}

template <class T>
std::array<int, 3> Mpm<T>::corner_of(const T* x) const {
  const auto along = [&](int k) {
    return static_cast<int>(std::floor((x[k] - data_.origin[k]) * data_.inverse_dx - T(0.5)));
  };
  return {along(0), along(1), along(2)};
}

template <class T>
BlockGrid::Coordinates Mpm<T>::block_of(const T* x, int object) const {
  static_assert(BlockGrid::kSide == 4);
  const auto [i, j, k] = corner_of(x);
  return {i >> 2, j >> 2, k >> 2, object};
}

template <class T>
void Mpm<T>::load(const BasicSimulationState<T>& state, const Vec3d& low, const Vec3d& high) {
  const size_t n = rest_.size();
  CHECK(state.size() == n && (state.memory.empty() || state.memory.size() == n));
  const Vec3d centre = data_.origin.template cast<double>();
  const Vec3d reach = Vec3d::Constant(static_cast<double>(data_.dx) * (BlockGrid::kSide * BlockGrid::kReach - 8));
  data_.low = low.cwiseMax(centre - reach).template cast<T>();
  data_.high = high.cwiseMin(centre + reach).template cast<T>();
  if (options_.lagrangian) {  // the grid does not have to reach to where particles are
    data_.low.setConstant(-std::numeric_limits<T>::infinity());
    data_.high = -data_.low;
  }
  strays_ = 0;
  finite_ = true;
  moves_since_reorder_ = 0;
  if (options_.lagrangian && !data_.slot.empty()) {  // stencils and all that hangs on them stay
    for (size_t s = 0; s < n; ++s) load_record(data_.record[s].index, state, data_.record[s]);
    load_nodes(state);
    return;
  }
  std::vector<BlockGrid::Coordinates> block(n);
  std::vector<uint8_t> corner(links_.empty() ? 0 : n);
  for (size_t i = 0; i < n; ++i) {
    const Vec3<T> inside = state.x[i].cwiseMax(data_.low).cwiseMin(data_.high);
    strays_ += (inside.array() != state.x[i].array()).count();
    const T* place = options_.lagrangian ? data_.reference[i].data() : inside.data();
    block[i] = block_of(place, rest_[i].object);
    if (links_.empty()) continue;
    const auto [a, b, c] = corner_of(place);
    corner[i] = static_cast<uint8_t>((a & 3) << 4 | (b & 3) << 2 | (c & 3));
  }
  // Records lie in memory as the blocks are walked.
  if (links_.empty())
    data_.grid.build(block);
  else
    data_.grid.build_linked(block, corner, links_);
  data_.record.resize(n);
  data_.slot.resize(n);
  constexpr std::ptrdiff_t kChunk = 4096;
  parallel_for((static_cast<std::ptrdiff_t>(n) + kChunk - 1) / kChunk, [&](std::ptrdiff_t c) {
    for (size_t s = c * kChunk; s < std::min<size_t>(n, (c + 1) * kChunk); ++s) {
      int& i = data_.grid.order()[s];
      load_record(i, state, data_.record[s]);
      data_.slot[i] = static_cast<int>(s);
      i = static_cast<int>(s);
    }
  });
  moved_.resize(n);
  fit_blocks();
  if (options_.lagrangian) {
    find_rest_constants();
    load_nodes(state);
  }
  if (sleeping()) load_rest(state);
}

template <class T>
void Mpm<T>::load_record(int i, const BasicSimulationState<T>& state, ParticleRecord<T>& r) {
  r = rest_[i];
  for (int a = 0; a < 3; ++a) {
    r.x[a] = std::clamp(state.x[i][a], data_.low[a], data_.high[a]);
    r.v[a] = state.v[i][a];
    for (int b = 0; b < 3; ++b) {
      r.C[3 * a + b] = state.C[i](a, b);
      r.F[3 * a + b] = state.F[i](a, b);
    }
  }
  if (r.side < 0) return;
  data_.side[r.side] = {};
  if (!state.memory.empty()) data_.side[r.side].memory = state.memory[i];
  set_given_stress(r, state.F[i]);
}

template <class T>
void Mpm<T>::store(BasicSimulationState<T>& state) const {
  const size_t n = data_.record.size();
  state.x.resize(n);
  state.v.resize(n);
  state.C.resize(n);
  state.F.resize(n);
  const bool memory =
      std::any_of(data_.materials.begin(), data_.materials.end(), [](const Material& m) { return has_memory(m.law); });
  state.memory.resize(memory ? n : 0);
  store_rest(state);
  if (options_.lagrangian) return store_nodes(state);
  for (const ParticleRecord<T>& r : data_.record) {
    for (int a = 0; a < 3; ++a) {
      state.x[r.index][a] = r.x[a];
      state.v[r.index][a] = r.v[a];
      for (int b = 0; b < 3; ++b) {
        state.C[r.index](a, b) = r.C[3 * a + b];
        state.F[r.index](a, b) = r.F[3 * a + b];
      }
    }
    if (!memory) continue;
    if (r.side >= 0) state.memory[r.index] = data_.side[r.side].memory;
    // Without a memory nothing is permanent: the elastic part is the whole.
    if (!has_memory(data_.materials[r.material].law)) state.memory[r.index].F_total = state.F[r.index];
  }
}

template <class T>
void Mpm<T>::fit_blocks() {
  data_.patch.resize(static_cast<size_t>(data_.grid.particle_blocks()) * BlockGrid::kPatchNodes);
  data_.node.resize(static_cast<size_t>(data_.grid.node_blocks()) * BlockGrid::kNodes);
  report_.resize(data_.grid.particle_blocks());
  if (options_.lagrangian) node_report_.resize(data_.grid.node_blocks());
  if (options_.flip_time > 0) {
    data_.old_patch.resize(data_.patch.size());
    data_.old_node.resize(data_.node.size());
  }
  if (sleeping()) node_motion_.resize(data_.grid.node_blocks());
}

template <class T>
void Mpm<T>::set_exposure(std::vector<Vec3<T>> exposure) {
  CHECK(exposure.size() == rest_.size());
  data_.exposure = std::move(exposure);
}

template <class T>
void Mpm<T>::clear_impulses(const StepLoads<T>& loads) {
  const size_t held = loads.colliders.size() + loads.pins.size(), loaded = loads.body.size();
  impulse_.assign(held + loaded, Vec3d::Zero());
  node_impulse_.assign(held * data_.grid.node_blocks(), Vec3d::Zero());
  particle_impulse_.assign(loaded * data_.grid.particle_blocks(), Vec3d::Zero());
}

template <class T>
void Mpm<T>::collect_reports() {
  if (!node_impulse_.empty() || !particle_impulse_.empty()) {
    const size_t held = node_impulse_.size() / data_.grid.node_blocks(), loaded = impulse_.size() - held;
    for (size_t k = 0; k < node_impulse_.size(); ++k) impulse_[k % held] += node_impulse_[k];
    for (size_t k = 0; k < particle_impulse_.size(); ++k) impulse_[held + k % loaded] += particle_impulse_[k];
  }
  if (options_.lagrangian) return collect_node_reports();
  T speed = 0;
  std::vector<BlockGrid::Move> moves;
  for (int b = 0; b < data_.grid.particle_blocks(); ++b) {
    const GatherReport<T>& report = report_[b];
    finite_ &= report.finite;
    strays_ += report.strays;
    updates_ += report.particles;
    speed = std::max(speed, report.max_speed_squared);
    for (int m = 0; m < report.moves && finite_; ++m) {
      const int begin = data_.grid.begin(b), place = begin + moved_[begin + m];
      const ParticleRecord<T>& r = data_.record[data_.grid.order()[place]];
      moves.push_back({place, block_of(r.x, r.object)});
    }
  }
  max_speed_ = std::sqrt(static_cast<double>(speed));
  if (moves.empty() || !finite_) return;
  moves_since_reorder_ += static_cast<int64_t>(moves.size());
  const int64_t version = data_.grid.link_version();
  data_.grid.move(moves);
  if (version != data_.grid.link_version()) {
    fit_blocks();
    if (sleeping()) carry_rest();
  }
  if (!sleeping()) return;
  for (const BlockGrid::Move& m : moves) rest_of_block_[data_.grid.find(m.to)] = {};
}

template class Mpm<float>;
template class Mpm<double>;

}  // namespace pliant
