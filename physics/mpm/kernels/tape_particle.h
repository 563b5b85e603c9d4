#pragma once

namespace pliant {

/// A particle at the start of a step, in the groups of `ParticleRecord`.
template <class T>
struct TapeParticle {
  T x[3], F[9], v[3], C[9];
};

constexpr int kTapePlace = 0, kTapeVelocity = 12;  // offsets of the groups

}  // namespace pliant
