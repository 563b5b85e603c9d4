#pragma once

#include "physics/mpm/kernels/record_packs.h"

namespace pliant::PLIANT_ISA {

/// Along one axis, patch offset o = 0 or 1 covers the nodes [4 o, 4 o + 4) of which a patch holds 4 or 2.
INLINE int patch_from(int o) { return 4 * o; }
INLINE int patch_count(int o) { return o ? 2 : 4; }

/// The rows of nodes that a patch and one of its eight node blocks have in common: visit(in the patch, in the block,
/// nodes of the row), places as steps of numbers.
template <class Visit>
INLINE void for_common_rows(int offset, Visit&& visit) {
  const int ox = offset >> 2, oy = offset >> 1 & 1, oz = offset & 1;
  for (int i = 0; i < patch_count(ox); ++i)
    for (int j = 0; j < patch_count(oy); ++j)
      visit((i + patch_from(ox)) * kPlane + (j + patch_from(oy)) * kRow + patch_from(oz) * 4, (i * 4 + j) * 16,
            patch_count(oz));
}

template <class T>
void add_nodes(const T* const* patch, T* node) {
  using Two = TwoNodes<T>;
  for (int o = 0; o < 8; ++o) {
    if (!patch[o]) continue;
    for_common_rows(o, [&](int from, int to, int count) {
      for (int k = 0; k < 4 * count; k += 8)
        store(node + to + k, load<Two>(node + to + k) + load<Two>(patch[o] + from + k));
    });
  }
}

template <class T>
void update_nodes(T* node, const T* fall, T scale) {
  using Two = TwoNodes<T>;
  const Two dv = {fall[0], fall[1], fall[2], 0, fall[0], fall[1], fall[2], 0};
  const Two is_mass = {0, 0, 0, 1, 0, 0, 0, 1};
  for (int k = 0; k < 4 * 64; k += 8) {
    const Two p = load<Two>(node + k), mass = __builtin_shufflevector(p, p, 3, 3, 3, 3, 7, 7, 7, 7);
    const Two v = (p * (T(1) / mass) + dv) * scale;
    const Two next = is_mass > Two{} ? p : v;
    store(node + k, mass > Two{} ? next : Two{});
  }
}

/// The nodes of a patch out of its eight node blocks.
template <class T>
INLINE void fill_patch(const T* const* node, T* patch) {
  using Two = TwoNodes<T>;
  for (int o = 0; o < 8; ++o)
    for_common_rows(o, [&](int to, int from, int count) {
      for (int k = 0; k < 4 * count; k += 8) store(patch + to + k, load<Two>(node[o] + from + k));
    });
}

}  // namespace pliant::PLIANT_ISA
