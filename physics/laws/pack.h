#pragma once

namespace pliant {

/// Four scalars that are computed on together: the lanes of a grid node (momentum and mass), or four particles.
/// Arithmetic works lane by lane; a scalar operand is broadcast.
template <class T>
struct PackOf;
template <>
struct PackOf<float> {
  typedef float Type __attribute__((vector_size(16), may_alias));
};
template <>
struct PackOf<double> {
  typedef double Type __attribute__((vector_size(32), may_alias));
};
template <class T>
using Pack = typename PackOf<T>::Type;

constexpr int kLanes = 4;

}  // namespace pliant
