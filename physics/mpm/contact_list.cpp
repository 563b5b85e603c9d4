#include "physics/mpm/contact_list.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pliant {
namespace {

/// Whether two blocks of particles have nodes in common.
bool share_nodes(const BlockGrid& grid, int a, int b) {
  for (const int n : grid.nodes_of(a))
    for (const int m : grid.nodes_of(b))
      if (n == m) return true;
  return false;
}

using Place = std::array<int, 3>;

uint64_t key_of(const Place& p) {
  constexpr int kHalf = 1 << 20;
  uint64_t key = 0;
  for (const int c : p) key = key << 21 | static_cast<uint64_t>(std::clamp(c + kHalf, 0, 2 * kHalf - 1));
  return key;
}

}  // namespace

/// Particles that are in one cell of space now, and a ball around where they lie at rest.
template <class T>
struct ContactList<T>::Cell {
  Place place;
  Vec3<T> centre = Vec3<T>::Zero();
  T radius = 0;
  int block = -1;  // of all of them, or -1
  int object = -1;
};

template <class T>
bool ContactList<T>::hang_together(const MpmData<T>& data, int s, int other) {
  const ParticleRecord<T>&a = data.record[s], &b = data.record[other];
  if (a.object != b.object) return false;
  const T apart = static_cast<T>(kApart) * data.dx;
  if (!((data.reference[a.index] - data.reference[b.index]).squaredNorm() < apart * apart)) return false;
  return !data.grid.linked() || share_nodes(data.grid, data.block_of_slot[s], data.block_of_slot[other]);
}

template <class T>
bool ContactList<T>::hang_together(const MpmData<T>& data, const Cell& a, const Cell& b) {
  if (a.object < 0 || a.object != b.object) return false;
  if (!((a.centre - b.centre).norm() + a.radius + b.radius < static_cast<T>(kApart) * data.dx)) return false;
  return !data.grid.linked() || (a.block >= 0 && b.block >= 0 && share_nodes(data.grid, a.block, b.block));
}

template <class T>
void ContactList<T>::build(const MpmData<T>& data, std::span<const Vec3<T>> x) {
  const int slots = static_cast<int>(x.size());
  const T side = static_cast<T>(kReach + kSlack) * data.dx;
  const auto rest = [&](int s) -> const Vec3<T>& { return data.reference[data.record[s].index]; };
  // Particles by cell.
  BlockTable table;
  table.clear(static_cast<size_t>(slots) / 4);
  std::vector<Cell> cell;
  std::vector<int> cell_of(slots), begin, order(slots);
  for (int s = 0; s < slots; ++s) {
    Place place;
    for (int a = 0; a < 3; ++a)
      place[a] = static_cast<int>(std::floor(std::clamp((x[s][a] - data.origin[a]) / side, T(-1e6), T(1e6))));
    cell_of[s] = table.insert(key_of(place), static_cast<int>(cell.size()));
    const ParticleRecord<T>& r = data.record[s];
    const int block = data.block_of_slot[s];
    if (cell_of[s] == static_cast<int>(cell.size())) {
      cell.push_back({place, Vec3<T>::Zero(), T(0), block, r.object});
      begin.push_back(0);
    }
    Cell& c = cell[cell_of[s]];
    c.centre += rest(s);
    if (c.block != block) c.block = -1;
    if (c.object != r.object) c.object = -1;
    ++begin[cell_of[s]];
  }
  int sum = 0;
  for (size_t c = 0; c < cell.size(); ++c) {
    cell[c].centre /= static_cast<T>(begin[c]);
    sum += begin[c];
    begin[c] = sum - begin[c];
  }
  begin.push_back(sum);
  std::vector<int> next(begin);
  for (int s = 0; s < slots; ++s) {
    Cell& c = cell[cell_of[s]];
    c.radius = std::max(c.radius, (rest(s) - c.centre).norm());
    order[next[cell_of[s]]++] = s;
  }

  // Pairs whose cells are neighbours, unless all of both hangs together.
  std::vector<std::array<int, 2>> pair;
  const T square = side * side;
  for (size_t c = 0; c < cell.size(); ++c)
    for (int o = 0; o < 27; ++o) {
      const Place& at = cell[c].place;
      const int d = o == 13 ? static_cast<int>(c)
                            : table.find(key_of({at[0] + o / 9 - 1, at[1] + o / 3 % 3 - 1, at[2] + o % 3 - 1}));
      if (d < static_cast<int>(c) || hang_together(data, cell[c], cell[d])) continue;
      for (int k = begin[c]; k < begin[c + 1]; ++k)
        for (int m = d == static_cast<int>(c) ? k + 1 : begin[d]; m < begin[d + 1]; ++m) {
          const int i = order[k], j = order[m];
          if ((x[i] - x[j]).squaredNorm() < square && !hang_together(data, i, j)) pair.push_back({i, j});
        }
    }
  // Both ways, by particle.
  begin_.assign(slots + 1, 0);
  for (const auto& [i, j] : pair) {
    ++begin_[i + 1];
    ++begin_[j + 1];
  }
  for (int s = 0; s < slots; ++s) begin_[s + 1] += begin_[s];
  other_.resize(2 * pair.size());
  next.assign(begin_.begin(), begin_.end());
  for (const auto& [i, j] : pair) {
    other_[next[i]++] = j;
    other_[next[j]++] = i;
  }
  block_touches_.assign(data.grid.particle_blocks(), 0);
  for (int s = 0; s < slots; ++s) {
    std::sort(other_.begin() + begin_[s], other_.begin() + begin_[s + 1]);
    if (begin_[s] < begin_[s + 1]) block_touches_[data.block_of_slot[s]] = 1;
  }
  travelled_ = 0;
}

template class ContactList<float>;
template class ContactList<double>;

}  // namespace pliant
