#include "physics/mpm/contact_list.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pliant {
namespace {

uint64_t key_of(const std::array<int, 3>& p) {
  constexpr int kHalf = 1 << 20;
  uint64_t key = 0;
  for (const int c : p) key = key << 21 | static_cast<uint64_t>(std::clamp(c + kHalf, 0, 2 * kHalf - 1));
  return key;
}

}  // namespace

template <class T>
bool ContactList<T>::hang_together(const MpmData<T>& data, const Body& a, const Body& b) {
  if (a.object != b.object) return false;
  const T apart = static_cast<T>(kApart) * data.dx;
  if (!((a.rest - b.rest).squaredNorm() < apart * apart)) return false;
  return data.grid.hang_together(a.part, b.part);
}

template <class T>
bool ContactList<T>::hang_together(const MpmData<T>& data, const Cell& a, const Cell& b) {
  if (a.object < 0 || a.object != b.object) return false;
  if (!((a.centre - b.centre).norm() + a.radius + b.radius < static_cast<T>(kApart) * data.dx)) return false;
  return a.part == 0 || b.part == 0 || (a.part > 0 && b.part > 0 && data.grid.hang_together(a.part, b.part));
}

template <class T>
void ContactList<T>::sort(const MpmData<T>& data, std::span<const Vec3<T>> x) {
  const int slots = static_cast<int>(x.size());
  const T side = static_cast<T>(kReach + kSlack) * data.dx;
  table_.clear(static_cast<size_t>(slots) / 4);
  cell_.clear();
  std::vector<int> cell_of(slots), count;
  for (int s = 0; s < slots; ++s) {
    Place place;
    for (int a = 0; a < 3; ++a)
      place[a] = static_cast<int>(std::floor(std::clamp((x[s][a] - data.origin[a]) / side, T(-1e6), T(1e6))));
    const int part = data.grid.part_of(data.record[s].index), object = data.grid.object_of(data.block_of_slot[s]);
    const int c = cell_of[s] = table_.insert(key_of(place), static_cast<int>(cell_.size()));
    if (c == static_cast<int>(cell_.size())) {
      cell_.push_back({place, 0, Vec3<T>::Zero(), T(0), part, object});
      count.push_back(0);
    }
    cell_[c].centre += Eigen::Map<const Vec3<T>>(data.rest[s].X);
    if (cell_[c].part != part) cell_[c].part = -1;
    if (cell_[c].object != object) cell_[c].object = -1;
    ++count[c];
  }
  int sum = 0;
  for (size_t c = 0; c < cell_.size(); ++c) {
    cell_[c].begin = sum;
    cell_[c].centre /= static_cast<T>(count[c]);
    sum += count[c];
    count[c] = cell_[c].begin;
  }
  cell_.push_back({{}, sum, Vec3<T>::Zero(), T(0), -1, -1});
  body_.resize(slots);
  for (int s = 0; s < slots; ++s) {
    Cell& c = cell_[cell_of[s]];
    const Vec3<T> rest = Eigen::Map<const Vec3<T>>(data.rest[s].X);
    c.radius = std::max(c.radius, (rest - c.centre).norm());
    body_[count[cell_of[s]]++] = {x[s], rest, s, data.grid.part_of(data.record[s].index),
                                  data.grid.object_of(data.block_of_slot[s])};
  }
  found_.assign(chunks(), {});
}

template <class T>
void ContactList<T>::search(const MpmData<T>& data, int chunk) {
  const T side = static_cast<T>(kReach + kSlack) * data.dx, square = side * side;
  const int cells = static_cast<int>(cell_.size()) - 1;
  for (int c = chunk * kCellsAtOnce; c < std::min(cells, (chunk + 1) * kCellsAtOnce); ++c)
    for (int o = 13; o < 27; ++o) {  // itself and half of its neighbors, whose other half is it
      const Place& at = cell_[c].place;
      const int d = o == 13 ? c : table_.find(key_of({at[0] + o / 9 - 1, at[1] + o / 3 % 3 - 1, at[2] + o % 3 - 1}));
      if (d < 0 || hang_together(data, cell_[c], cell_[d])) continue;
      for (int k = cell_[c].begin; k < cell_[c + 1].begin; ++k)
        for (int m = d == c ? k + 1 : cell_[d].begin; m < cell_[d + 1].begin; ++m)
          if ((body_[k].x - body_[m].x).squaredNorm() < square && !hang_together(data, body_[k], body_[m]))
            found_[chunk].push_back({body_[k].slot, body_[m].slot});
    }
}

template <class T>
void ContactList<T>::finish(const MpmData<T>& data) {
  const int slots = static_cast<int>(body_.size());
  // Both ways, by particle.
  begin_.assign(slots + 1, 0);
  for (const auto& pairs : found_)
    for (const auto& [i, j] : pairs) {
      ++begin_[i + 1];
      ++begin_[j + 1];
    }
  for (int s = 0; s < slots; ++s) begin_[s + 1] += begin_[s];
  other_.resize(begin_[slots]);
  std::vector<int> next(begin_);
  for (const auto& pairs : found_)
    for (const auto& [i, j] : pairs) {
      other_[next[i]++] = j;
      other_[next[j]++] = i;
    }
  block_touches_.assign(data.grid.particle_blocks(), 0);
  for (int s = 0; s < slots; ++s) {
    if (begin_[s] == begin_[s + 1]) continue;
    std::sort(other_.begin() + begin_[s], other_.begin() + begin_[s + 1]);
    block_touches_[data.block_of_slot[s]] = 1;
  }
  travelled_ = 0;
}

template <class T>
void ContactList<T>::build(const MpmData<T>& data, std::span<const Vec3<T>> x) {
  sort(data, x);
  for (int c = 0; c < chunks(); ++c) search(data, c);
  finish(data);
}

template class ContactList<float>;
template class ContactList<double>;

}  // namespace pliant
