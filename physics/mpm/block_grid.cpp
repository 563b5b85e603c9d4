#include "physics/mpm/block_grid.h"

#include "gaussians/base/error.h"

namespace pliant {

void BlockGrid::build(const std::vector<Coordinates>& block_of_particle, const Coordinates& low,
                      const Coordinates& high) {
  // One more block on the upper side, which only stencils reach.
  const int64_t nx = high.x - low.x + 2, ny = high.y - low.y + 2, nz = high.z - low.z + 2;
  CHECK(nx > 1 && ny > 1 && nz > 1 && nx * ny * nz < (int64_t{1} << 30));
  const int64_t cells = nx * ny * nz;
  const int n = static_cast<int>(block_of_particle.size());
  ++version_;

  table_.assign(cells, 0);
  key_.resize(n);
  for (int i = 0; i < n; ++i) {
    const Coordinates& b = block_of_particle[i];
    key_[i] = static_cast<int>(((b.x - low.x) * ny + (b.y - low.y)) * nz + (b.z - low.z));
    ++table_[key_[i]];
  }

  // Blocks in ascending key; their particles keep their order.
  begin_.clear(), particle_links_.clear(), node_links_.clear(), node_block_.clear();
  node_table_.assign(cells, -1);
  std::vector<int>& cursor = table_;
  std::vector<int64_t> block_key;
  int total = 0;
  for (int64_t k = 0; k < cells; ++k) {
    const int count = cursor[k];
    cursor[k] = total;
    if (count == 0) continue;
    begin_.push_back(total);
    block_key.push_back(k);
    total += count;
  }
  begin_.push_back(total);
  order_.resize(n);
  for (int i = 0; i < n; ++i) order_[cursor[key_[i]]++] = i;

  particle_links_.resize(block_key.size());
  for (size_t b = 0; b < block_key.size(); ++b) {
    for (int o = 0; o < 8; ++o) {
      const int64_t k = block_key[b] + ((o >> 2) * ny + (o >> 1 & 1)) * nz + (o & 1);
      if (node_table_[k] < 0) {
        node_table_[k] = static_cast<int>(node_links_.size());
        node_links_.push_back({-1, -1, -1, -1, -1, -1, -1, -1});
        node_block_.push_back({low.x + static_cast<int>(k / (ny * nz)), low.y + static_cast<int>(k / nz % ny),
                               low.z + static_cast<int>(k % nz)});
      }
      particle_links_[b][o] = node_table_[k];
      node_links_[node_table_[k]][o] = static_cast<int>(b);
    }
  }
}

}  // namespace pliant
