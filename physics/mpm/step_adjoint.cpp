#include "physics/mpm/step_adjoint.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "physics/laws/pack.h"
#include "physics/mpm/node_update_adjoint.h"
#include "physics/mpm/team.h"

namespace pliant {
namespace adjoint_baseline {
extern const AdjointKernels<float> kAdjointFloat;
extern const AdjointKernels<double> kAdjointDouble;
}  // namespace adjoint_baseline

namespace {

constexpr int kPatch = BlockGrid::kPatch, kSide = BlockGrid::kSide;

template <class T>
const AdjointKernels<T>& kernels();
template <>
const AdjointKernels<float>& kernels<float>() {
  return adjoint_baseline::kAdjointFloat;
}
template <>
const AdjointKernels<double>& kernels<double>() {
  return adjoint_baseline::kAdjointDouble;
}

/// Rows of nodes that a patch shares with the node block at offset o: call(node in the patch, node in the block, count).
template <class Call>
void for_shared_rows(int o, Call&& call) {
  const int ox = (o >> 2) * kSide, oy = (o >> 1 & 1) * kSide, oz = (o & 1) * kSide;
  const int ex = ox ? 2 : kSide, ey = oy ? 2 : kSide, ez = oz ? 2 : kSide;
  for (int i = 0; i < ex; ++i)
    for (int j = 0; j < ey; ++j) call(((i + ox) * kPatch + j + oy) * kPatch + oz, (i * kSide + j) * kSide, ez);
}

/// The nodes of a particle block's patch, out of its eight node blocks.
template <class T>
void collect_patch(const BlockGrid& grid, int b, const std::vector<Node<T>>& nodes, Node<T>* patch) {
  for (int o = 0; o < 8; ++o) {
    const Node<T>* from = nodes.data() + static_cast<size_t>(grid.nodes_of(b)[o]) * BlockGrid::kNodes;
    for_shared_rows(o, [&](int p, int n, int count) { std::copy_n(from + n, count, patch + p); });
  }
}

}  // namespace

template <class T>
StepAdjoint<T>::StepAdjoint(const BasicParticles<T>& particles, const MpmData<T>& solver,
                            const std::vector<uint32_t>& bits)
    : dx_(solver.dx),
      inverse_dx_(solver.inverse_dx),
      origin_(solver.origin),
      kernels_(kernels<T>()),
      record_(particles.size()),
      slot_(particles.size()) {
  for (size_t i = 0; i < particles.size(); ++i) {
    const Lame<T> law = lame(particles.young[i], particles.poisson[i]);
    AdjointRecord<T>& r = record_[i];
    r = {};
    r.mass = particles.mass[i], r.volume = particles.volume[i], r.mu = law.mu, r.lambda = law.lambda;
    r.bits = bits[i];
    r.index = static_cast<int>(i);
    slot_[i] = static_cast<int>(i);
  }
}

template <class T>
void StepAdjoint<T>::load(const StateGradient<T>& gradient, const BasicSimulationState<T>& state,
                          const StepTape<T>& tape) {
  CHECK(tape.size() > 0 && gradient.x.size() == record_.size() && state.size() == record_.size());
  // Records lie in memory as the blocks are walked.
  const TapeStep<T>& last = tape[tape.size() - 1];
  std::vector<AdjointRecord<T>> sorted(record_.size());
  for (size_t s = 0; s < record_.size(); ++s) sorted[s] = record_[slot_[last.index[s]]];
  record_ = std::move(sorted);
  for (size_t s = 0; s < record_.size(); ++s) {
    AdjointRecord<T>& r = record_[s];
    const int i = r.index;
    slot_[i] = static_cast<int>(s);
    r.put_back = 0;
    for (int a = 0; a < 3; ++a) {
      r.x[a] = gradient.x[i][a], r.v[a] = gradient.v[i][a];
      r.v_after[a] = state.v[i][a];
      r.put_back |= static_cast<uint32_t>(state.x[i][a] == tape.low[a] || state.x[i][a] == tape.high[a]) << a;
      for (int c = 0; c < 3; ++c) {
        r.C[3 * a + c] = gradient.C[i](a, c), r.F[3 * a + c] = gradient.F[i](a, c);
        r.C_after[3 * a + c] = state.C[i](a, c);
      }
    }
  }
}

template <class T>
void StepAdjoint<T>::store(StateGradient<T>& gradient) const {
  for (const AdjointRecord<T>& r : record_) {
    for (int a = 0; a < 3; ++a) {
      gradient.x[r.index][a] = r.x[a], gradient.v[r.index][a] = r.v[a];
      for (int c = 0; c < 3; ++c)
        gradient.C[r.index](a, c) = r.C[3 * a + c], gradient.F[r.index](a, c) = r.F[3 * a + c];
    }
  }
}

template <class T>
typename StepAdjoint<T>::Motion StepAdjoint<T>::motion_of(const TapeStep<T>& step, std::span<const int> particles) {
  place_.resize(record_.size());
  for (size_t s = 0; s < step.index.size(); ++s) place_[step.index[s]] = static_cast<int>(s);
  Motion motion;
  for (const int i : particles) {
    const TapeParticle<T>& p = step.particle[place_[i]];
    const double m = record_[slot_[i]].mass;
    motion.mass += m;
    motion.centre += m * Vec3d(p.x[0], p.x[1], p.x[2]);
    motion.velocity += m * Vec3d(p.v[0], p.v[1], p.v[2]);
  }
  motion.centre /= motion.mass, motion.velocity /= motion.mass;
  return motion;
}

template <class T>
void StepAdjoint<T>::motion_adjoint(const TapeStep<T>& step, std::span<const int> particles, const Motion& motion,
                                    const Vec3d& by_centre, const Vec3d& by_velocity) {
  for (const int i : particles) {
    const TapeParticle<T>& p = step.particle[place_[i]];
    AdjointRecord<T>& r = record_[slot_[i]];
    const double share = r.mass / motion.mass;
    double by_mass = 0;
    for (int a = 0; a < 3; ++a) {
      r.x[a] += static_cast<T>(share * by_centre[a]), r.v[a] += static_cast<T>(share * by_velocity[a]);
      by_mass += by_centre[a] * (p.x[a] - motion.centre[a]) + by_velocity[a] * (p.v[a] - motion.velocity[a]);
    }
    r.by_mass += static_cast<T>(by_mass / motion.mass);
  }
}

template <class T>
ParticleGradient<T> StepAdjoint<T>::particle_gradient() const {
  const size_t n = record_.size();
  ParticleGradient<T> result{std::vector<T>(n), std::vector<T>(n), std::vector<T>(n)};
  for (const AdjointRecord<T>& r : record_)
    result.mass[r.index] = r.by_mass, result.mu[r.index] = r.by_mu, result.lambda[r.index] = r.by_lambda;
  return result;
}

template <class T>
size_t StepAdjoint<T>::bytes() const {
  return record_.capacity() * (sizeof(AdjointRecord<T>) + sizeof(int)) +
         (velocity_.capacity() + adj_node_.capacity() + patch_.capacity()) * sizeof(Node<T>);
}

template <class T>
AdjointView<T> StepAdjoint<T>::view_of(const StepTape<T>& tape, const TapeStep<T>& step) {
  AdjointView<T> view{};
  view.dt = step.dt, view.dx = dx_, view.inverse_dx = inverse_dx_, view.viscosity_time = step.loads.viscosity_time;
  for (int a = 0; a < 3; ++a) view.origin[a] = origin_[a], view.low[a] = tape.low[a], view.high[a] = tape.high[a];
  view.particle = step.particle.data(), view.index = step.index.data(), view.slot = slot_.data();
  view.record = record_.data();
  body_.clear();
  for (const BodyLoad<T>& load : step.loads.body)
    body_.push_back({load.bit, {load.acceleration[0], load.acceleration[1], load.acceleration[2]}, load.drag});
  view.body = body_.data(), view.bodies = static_cast<int>(body_.size());
  const BlockGrid& grid = *step.grid;
  velocity_.resize(step.node.size()), adj_node_.resize(step.node.size());
  patch_.resize(static_cast<size_t>(grid.particle_blocks()) * BlockGrid::kPatchNodes);
  block_sums_.resize(static_cast<size_t>(grid.particle_blocks()) * kAdjointSums(view.bodies));
  node_sums_.resize(grid.node_blocks());
  return view;
}

template <class T>
NodeBlock<T> StepAdjoint<T>::node_block(const BlockGrid& grid, std::vector<Node<T>>& nodes, int n) const {
  const BlockGrid::Coordinates& block = grid.node_block(n);
  const double dx = dx_;
  return {nodes.data() + static_cast<size_t>(n) * BlockGrid::kNodes,
          origin_.template cast<double>() + dx * kSide * Vec3d(block.x, block.y, block.z), dx};
}

template <class T>
void StepAdjoint<T>::find_velocities(const TapeStep<T>& step, int n) {
  const NodeBlock<T> block = node_block(*step.grid, velocity_, n);
  node_velocities(step.dt, step.loads, step.node.data() + static_cast<size_t>(n) * BlockGrid::kNodes, block.node);
  apply_node_conditions(step.loads, block);
}

template <class T>
void StepAdjoint<T>::reverse_gather(const TapeStep<T>& step, const AdjointView<T>& view, int b) {
  alignas(64) Node<T> velocity[BlockGrid::kPatchNodes];
  collect_patch(*step.grid, b, velocity_, velocity);
  Node<T>* patch = patch_.data() + static_cast<size_t>(b) * BlockGrid::kPatchNodes;
  std::fill_n(patch, BlockGrid::kPatchNodes, Node<T>{});
  kernels_.gather(view, step.begin[b], step.begin[b + 1], velocity, patch);
}

template <class T>
void StepAdjoint<T>::reverse_update(const TapeStep<T>& step, int n) {
  const NodeBlock<T> block = node_block(*step.grid, adj_node_, n);
  std::fill_n(block.node, BlockGrid::kNodes, Node<T>{});
  for (int o = 0; o < 8; ++o) {
    const int source = step.grid->sources_of(n)[o];
    if (source < 0) continue;
    const Node<T>* patch = patch_.data() + static_cast<size_t>(source) * BlockGrid::kPatchNodes;
    for_shared_rows(o, [&](int p, int to, int count) {
      for (int k = 0; k < count; ++k)
        reinterpret_cast<Pack<T>&>(block.node[to + k].lane) += reinterpret_cast<const Pack<T>&>(patch[p + k].lane);
    });
  }
  node_sums_[n] = {};
  reverse_node_update(step.dt, step.loads, block, step.node.data() + static_cast<size_t>(n) * BlockGrid::kNodes,
                      node_sums_[n]);
}

template <class T>
void StepAdjoint<T>::reverse_scatter(const TapeStep<T>& step, const AdjointView<T>& view, int b) {
  alignas(64) Node<T> patch[BlockGrid::kPatchNodes];
  collect_patch(*step.grid, b, adj_node_, patch);
  const int count = kAdjointSums(view.bodies);
  double* sums = block_sums_.data() + static_cast<size_t>(b) * count;
  std::fill_n(sums, count, 0.0);
  kernels_.scatter(view, step.begin[b], step.begin[b + 1], patch, sums);
}

template <class T>
StepLoadsGradient StepAdjoint<T>::sum_loads(const TapeStep<T>& step) const {
  StepLoadsGradient sum;
  for (const StepLoadsGradient& s : node_sums_) sum.gravity += s.gravity, sum.velocity_scale += s.velocity_scale;
  const int count = kAdjointSums(static_cast<int>(step.loads.body.size()));
  sum.body.resize(step.loads.body.size());
  for (size_t first = 0; first < block_sums_.size(); first += count) {
    const double* s = block_sums_.data() + first;
    sum.viscosity_time += s[0];
    for (size_t l = 0; l < sum.body.size(); ++l) {
      sum.body[l].acceleration += Vec3d(s[1 + 4 * l], s[2 + 4 * l], s[3 + 4 * l]);
      sum.body[l].drag += s[4 + 4 * l];
    }
  }
  return sum;
}

template <class T>
void StepAdjoint<T>::reverse(const StepTape<T>& tape, const std::function<void(int, const StepLoadsGradient&)>& loads) {
  constexpr int kParticlesPerThread = 1000;  // below this a thread costs more than it brings
  const int useful = static_cast<int>(std::min<size_t>(record_.size() / kParticlesPerThread, 1024));
  const int threads = std::clamp(omp_get_max_threads(), 1, std::max(1, useful));
  std::exception_ptr error;
  Queue forward, gather, update, scatter;
  AdjointView<T> view;
  bool going = true;
  const auto between = [&](int k) {
    try {
      if (k + 1 < tape.size()) loads(k + 1, sum_loads(tape[k + 1]));
      going = k >= 0;
      if (going) view = view_of(tape, tape[k]);
    } catch (...) {
      error = std::current_exception(), going = false;
    }
    forward.reset(), gather.reset(), update.reset(), scatter.reset();
  };
  std::unique_ptr<Barrier> barrier;
#pragma omp parallel num_threads(threads)
  {
#pragma omp single
    barrier = std::make_unique<Barrier>(omp_get_num_threads());
    for (int k = tape.size() - 1;; --k) {
      if (omp_get_thread_num() == 0) between(k);
      barrier->wait();
      if (!going) break;
      const TapeStep<T>& step = tape[k];
      const int blocks = step.grid->particle_blocks(), node_blocks = step.grid->node_blocks();
      for (int n; (n = forward.take()) < node_blocks;) find_velocities(step, n);
      barrier->wait();
      for (int b; (b = gather.take()) < blocks;) reverse_gather(step, view, b);
      barrier->wait();
      for (int n; (n = update.take()) < node_blocks;) reverse_update(step, n);
      barrier->wait();
      for (int b; (b = scatter.take()) < blocks;) reverse_scatter(step, view, b);
      barrier->wait();
    }
  }
  if (error) std::rethrow_exception(error);
}

template class StepAdjoint<float>;
template class StepAdjoint<double>;

}  // namespace pliant
