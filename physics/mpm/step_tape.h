#pragma once

#include <memory>
#include <vector>

#include "physics/laws/law.h"
#include "physics/loads/step_loads.h"
#include "physics/mpm/block_grid.h"
#include "physics/mpm/kernels/tape_particle.h"
#include "physics/mpm/node_conditions.h"

namespace pliant {

/// What one step read, enough to go back through it.
template <class T>
struct TapeStep {
  T dt;
  StepLoads<T> loads;
  std::shared_ptr<const BlockGrid> grid;  ///< shared by steps in which the set of blocks stayed the same
  std::vector<int> begin;                 ///< [particle blocks + 1] first particle of each
  std::vector<TapeParticle<T>> particle;  ///< [N] at the start, in the order of the blocks; not in Lagrangian runs
  std::vector<int> index;                 ///< [N] their numbers
  std::vector<Node<T>> node;              ///< [node blocks, 4, 4, 4] momentum and mass before the update, or impulse
  bool touching = false;                  ///< whether any particles of a Lagrangian run were near enough to touch
  T flip = 0;                             ///< as in GatherInput
  std::vector<Node<T>> old_node;          ///< [node blocks, 4, 4, 4] velocity before the step and mass, where flip > 0
  std::vector<Node<T>> node_displacement, node_velocity;  ///< [node blocks, 4, 4, 4] before the step, as in MpmData
  std::vector<LawMemory<T>> memory;                       ///< by ParticleRecord::side
  std::vector<T> given_stress;                            ///< [side, 6] as in MpmData

  bool lagrangian() const { return !node_velocity.empty(); }
};

/// Steps in the order in which they were taken.  Memory is kept for the next run.
template <class T>
class StepTape {
 public:
  int size() const { return size_; }
  const TapeStep<T>& operator[](int k) const { return step_[k]; }
  void clear() { size_ = 0; }

  Vec3<T> low, high;  ///< domain into which strays are put back, m

  /// Opens the next step; its particles, indices and nodes are filled in by the caller.
  void begin_step(T dt, const StepLoads<T>& loads, const BlockGrid& grid, size_t sides, T flip, bool lagrangian) {
    if (size_ == static_cast<int>(step_.size())) step_.emplace_back();
    TapeStep<T>& step = step_[size_];
    const bool same = size_ > 0 && step_[size_ - 1].grid->link_version() == grid.link_version();
    step.grid = same ? step_[size_ - 1].grid : std::make_shared<const BlockGrid>(grid);
    ++size_;
    step.dt = dt;
    step.loads = loads;
    step.flip = flip;
    step.begin.resize(grid.particle_blocks() + 1);
    for (int b = 0; b <= grid.particle_blocks(); ++b) step.begin[b] = grid.begin(b);
    step.particle.resize(lagrangian ? 0 : grid.order().size());
    step.index.resize(grid.order().size());
    step.memory.resize(sides);
    step.given_stress.resize(6 * sides);
    step.node.resize(static_cast<size_t>(grid.node_blocks()) * BlockGrid::kNodes);
    step.old_node.resize(flip > T(0) ? step.node.size() : 0);
    step.node_displacement.resize(lagrangian ? step.node.size() : 0);
    step.node_velocity.resize(step.node_displacement.size());
  }
  TapeStep<T>& last() { return step_[size_ - 1]; }

  size_t bytes() const {
    size_t sum = 0;
    for (const TapeStep<T>& s : step_)
      sum += s.particle.capacity() * (sizeof(TapeParticle<T>) + sizeof(int)) +
             (s.node.capacity() + s.old_node.capacity() + s.node_displacement.capacity() + s.node_velocity.capacity()) *
                 sizeof(Node<T>) +
             s.memory.capacity() * (sizeof(LawMemory<T>) + 6 * sizeof(T));
    return sum;
  }

 private:
  int size_ = 0;
  std::vector<TapeStep<T>> step_;
};

}  // namespace pliant
