// Particles of a cell follow one another, so that they find their nodes in registers and caches; blocks of records
// follow one another in memory.

#include <algorithm>

#include "physics/mpm/mpm.h"

namespace pliant {

template <class T>
void Mpm<T>::sort_cells(int b) {
  constexpr int kCells = BlockGrid::kNodes;
  const int count = data_.grid.begin(b + 1) - data_.grid.begin(b);
  int* order = data_.grid.order().data() + data_.grid.begin(b);
  uint8_t* cell = cell_.data() + data_.grid.begin(b);
  kernels_->cells(run_of(b), cell);
  int next[kCells + 1] = {}, steps_down = 0;
  for (int s = 0; s < count; ++s) {
    ++next[cell[s] + 1];
    steps_down += s > 0 && cell[s] < cell[s - 1];
  }
  if (steps_down * 16 < count) return;
  for (int c = 0; c < kCells; ++c) next[c + 1] += next[c];
  int* sorted = spare_order_.data() + data_.grid.begin(b);
  for (int s = 0; s < count; ++s) sorted[next[cell[s]]++] = order[s];
  std::copy_n(sorted, count, order);
}

template <class T>
void Mpm<T>::reorder_chunk(int chunk) {
  const size_t n = data_.record.size();
  for (size_t s = static_cast<size_t>(chunk) * kReorderChunk; s < std::min(n, (chunk + size_t{1}) * kReorderChunk); ++s) {
    int& slot = data_.grid.order()[s];
    spare_record_[s] = data_.record[slot];
    data_.slot[spare_record_[s].index] = static_cast<int>(s);
    slot = static_cast<int>(s);
  }
}

template class Mpm<float>;
template class Mpm<double>;

}  // namespace pliant
