// Records lie in memory in the order of the blocks, so that they are fetched ahead of their use.

#include <algorithm>

#include "physics/mpm/mpm.h"

namespace pliant {

template <class T>
void Mpm<T>::reorder_chunk(int chunk) {
  const size_t n = data_.record.size();
  for (size_t s = static_cast<size_t>(chunk) * kReorderChunk; s < std::min(n, (chunk + size_t{1}) * kReorderChunk);
       ++s) {
    int& slot = data_.grid.order()[s];
    spare_record_[s] = data_.record[slot];
    data_.slot[spare_record_[s].index] = static_cast<int>(s);
    slot = static_cast<int>(s);
  }
}

template class Mpm<float>;
template class Mpm<double>;

}  // namespace pliant
