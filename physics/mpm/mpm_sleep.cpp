// Blocks at rest are left out of the transfers: their patches stay as they are and are still summed into the nodes, so
// that neighbours see them; nodes that move, or that are accelerated otherwise than when the block fell asleep, wake
// it.

#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/mpm/mpm.h"

namespace pliant {
namespace {

/// A block wakes when its nodes' acceleration changes by this many times sleep_speed / sleep_time, below which it was
/// while it came to rest.
constexpr double kWakeFactor = 10;

/// What holds or drives the nodes, besides gravity.
template <class T>
std::vector<int> conditions(const StepLoads<T>& loads) {
  std::vector<int> all = {static_cast<int>(loads.pins.size()), static_cast<int>(loads.colliders.size())};
  all.insert(all.end(), loads.acting.begin(), loads.acting.end());
  return all;
}

}  // namespace

/// A block has been quiet as long as the least quiet of its particles.
template <class T>
void Mpm<T>::load_rest(const BasicSimulationState<T>& state) {
  rest_of_block_.assign(data_.grid.particle_blocks(), {});
  last_conditions_.clear();
  if (state.quiet_time.size() != data_.record.size()) return;
  for (int b = 0; b < data_.grid.particle_blocks(); ++b) {
    T least = std::numeric_limits<T>::infinity();
    for (int s = data_.grid.begin(b); s < data_.grid.begin(b + 1); ++s)
      least = std::min(least, state.quiet_time[data_.record[data_.grid.order()[s]].index]);
    rest_of_block_[b].quiet_time = least;
    rest_of_block_[b].asleep = least >= static_cast<T>(options_.sleep_time);
  }
}

template <class T>
void Mpm<T>::store_rest(BasicSimulationState<T>& state) const {
  state.quiet_time.resize(sleeping() ? data_.record.size() : 0);
  if (!sleeping()) return;
  for (int b = 0; b < data_.grid.particle_blocks(); ++b)
    for (int s = data_.grid.begin(b); s < data_.grid.begin(b + 1); ++s)
      state.quiet_time[data_.record[data_.grid.order()[s]].index] = rest_of_block_[b].quiet_time;
}

/// After the set of blocks has changed: numbers are new and patches have to be written again.
template <class T>
void Mpm<T>::carry_rest() {
  std::vector<BlockRest<T>> next(data_.grid.particle_blocks());
  for (int b = 0; b < data_.grid.particle_blocks(); ++b) {
    const int previous = data_.grid.previous(b);
    if (previous >= 0) next[b] = rest_of_block_[previous];
    next[b].patch_dt = 0;
  }
  rest_of_block_ = std::move(next);
}

template <class T>
void Mpm<T>::wake_on_change(const StepLoads<T>& loads) {
  std::vector<int> now = conditions(loads);
  const bool same = last_conditions_.empty() || (last_gravity_ == loads.gravity && last_conditions_ == now);
  last_gravity_ = loads.gravity;
  last_conditions_ = std::move(now);
  if (same) return;
  for (BlockRest<T>& rest : rest_of_block_) rest = {};
}

template <class T>
bool Mpm<T>::scatter_can_wait(int b, T dt, const StepLoads<T>& loads) {
  BlockRest<T>& rest = rest_of_block_[b];
  if (!rest.asleep) return false;
  uint32_t active = 0;
  // Springs of pins hold what is at rest where it is.
  for (const auto& load : loads.body)
    if (load.pressure != T(0) || load.drag != T(0) || !load.acceleration.isZero(0) || !load.angular.isZero(0) ||
        !load.per_volume.isZero(0))
      active |= load.bit;
  for (int s = data_.grid.begin(b); active != 0 && s < data_.grid.begin(b + 1); ++s)
    if (data_.record[data_.grid.order()[s]].bits & active) {
      rest = {};
      active = 0;
    }
  if (rest.asleep && rest.patch_dt == dt) return true;
  // A new time step changes the impulses of the nodes a little; they are compared with these from then on.
  rest.patch_dt = dt;
  rest.settled = false;
  return false;
}

template <class T>
void Mpm<T>::measure_motion(int n) {
  NodeMotion<T> motion;
  for (int k = 0; k < BlockGrid::kNodes; ++k) {
    const T* v = data_.node[static_cast<size_t>(n) * BlockGrid::kNodes + k].lane;
    motion.speed_squared = std::max(motion.speed_squared, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int a = 0; a < 3; ++a) motion.sum[a] += v[a];
  }
  node_motion_[n] = motion;
}

template <class T>
bool Mpm<T>::gather_can_wait(int b, T dt) {
  BlockRest<T>& rest = rest_of_block_[b];
  if (!rest.asleep) return false;
  const T speed = static_cast<T>(options_.sleep_speed);
  const T change = static_cast<T>(kWakeFactor * BlockGrid::kNodes * options_.sleep_speed / options_.sleep_time) * dt;
  bool moves = false;
  for (int o = 0; o < 8; ++o) {
    const NodeMotion<T>& now = node_motion_[data_.grid.nodes_of(b)[o]];
    NodeMotion<T>& then = rest.at_sleep[o];
    moves |= now.speed_squared > speed * speed;
    if (rest.settled)
      for (int a = 0; a < 3; ++a) moves |= std::abs(now.sum[a] - then.sum[a]) > change;
    else
      then = now;
  }
  rest.settled = true;
  if (moves) {
    rest = {};
    return false;
  }
  report_[b] = {rest.max_speed_squared, 0, 0, 0, true};
  return true;
}

template <class T>
void Mpm<T>::watch_rest(int b, T dt) {
  BlockRest<T>& rest = rest_of_block_[b];
  const T limit = static_cast<T>(options_.sleep_speed * options_.sleep_speed);
  bool quiet = report_[b].max_speed_squared <= limit && report_[b].moves == 0;
  for (int o = 0; o < 8; ++o) quiet &= node_motion_[data_.grid.nodes_of(b)[o]].speed_squared <= limit;
  rest.quiet_time = quiet ? rest.quiet_time + dt : T(0);
  rest.asleep = rest.quiet_time >= static_cast<T>(options_.sleep_time);
  rest.max_speed_squared = report_[b].max_speed_squared;
}

template class Mpm<float>;
template class Mpm<double>;

}  // namespace pliant
