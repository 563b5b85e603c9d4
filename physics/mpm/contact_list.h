#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "physics/mpm/block_table.h"
#include "physics/mpm/mpm_data.h"
#include "physics/mpm/particle_contact.h"

namespace pliant {

/// Which particles of a Lagrangian run may touch: they lie near each other now, and do not hang together at rest.  A
/// list holds until something has moved by `kSlack` cells (Verlet 1967).
template <class T>
class ContactList {
 public:
  static constexpr double kReach = 0.8;   ///< cells between particles from which on they touch
  static constexpr double kSlack = 0.45;  ///< cells
  /// Cells between particles at rest from which on they can touch though they are of one body.  Nearer ones lie in
  /// blocks that share blocks of nodes, so that BlockGrid knows whether they hang together.
  static constexpr double kApart = BlockGrid::kSide;

  /// Forgets everything; the next steps begin with a new list.
  void clear() { travelled_ = kSlack; }
  /// After a step of dt in which nothing was faster than `speed`, measured from any velocity.
  void travel(double speed, double dt, double dx) { travelled_ += 2 * speed * dt / dx; }
  bool stale() const { return travelled_ >= kSlack; }
  /// Anew for the present places `x` [slots].
  void build(const MpmData<T>& data, std::span<const Vec3<T>> x);
  /// The same in parts: `search` of every chunk may run at the same time.
  void sort(const MpmData<T>& data, std::span<const Vec3<T>> x);
  int chunks() const { return (static_cast<int>(cell_.size()) + kCellsAtOnce - 1) / kCellsAtOnce; }
  void search(const MpmData<T>& data, int chunk);
  void finish(const MpmData<T>& data);

  bool empty() const { return other_.empty(); }
  /// Slots of the particles near that in slot s, ascending.
  std::span<const int> near(int s) const { return std::span(other_).subspan(begin_[s], begin_[s + 1] - begin_[s]); }
  /// [particle blocks] whether any particle of it is near another.
  const std::vector<uint8_t>& block_touches() const { return block_touches_; }

 private:
  using Place = std::array<int, 3>;
  static constexpr int kCellsAtOnce = 128;

  /// Particles that are in one cell of space now, and a ball around where they lie at rest.
  struct Cell {
    Place place;
    int begin;  // in body_
    Vec3<T> centre;
    T radius;
    int part, object;  // of all of them, or -1; see BlockGrid::part_of
  };
  struct Body {
    Vec3<T> x, rest;
    int slot, part, object;
  };
  static bool hang_together(const MpmData<T>& data, const Body& a, const Body& b);
  static bool hang_together(const MpmData<T>& data, const Cell& a, const Cell& b);

  double travelled_ = kSlack;  // cells since `finish`
  BlockTable table_;
  std::vector<Cell> cell_;  // and one after the last
  std::vector<Body> body_;  // by cell
  std::vector<std::vector<std::array<int, 2>>> found_;
  std::vector<int> begin_, other_;
  std::vector<uint8_t> block_touches_;
};

/// Two particles that may touch; what lies nearer than kReach at rest does so when it comes nearer still.  `x` and `v`
/// are [slots].
template <class T>
ContactPair<T> contact_pair(const MpmData<T>& data, int s, int other, std::span<const Vec3<T>> x,
                            std::span<const Vec3<T>> v) {
  const RestParticle<T>&a = data.rest[s], &b = data.rest[other];
  const auto at_rest = [&](int i) -> const Vec3<T>& { return data.reference[data.record[i].index]; };
  const auto stiffness = [&](const RestParticle<T>& p) {
    return (p.lambda + 2 * p.mu) * p.volume * data.inverse_dx * data.inverse_dx;
  };
  return {{x[s], x[other]},
          {v[s], v[other]},
          {a.mass, b.mass},
          {stiffness(a), stiffness(b)},
          std::min(static_cast<T>(ContactList<T>::kReach) * data.dx, (at_rest(s) - at_rest(other)).norm())};
}

/// Velocity [m/s] that the particles near that in slot s give to it in a step of dt.
template <class T>
Vec3<T> contact_gain(const MpmData<T>& data, const ContactList<T>& contacts, int s, std::span<const Vec3<T>> x,
                     std::span<const Vec3<T>> v, T dt, T friction) {
  Vec3<T> gain = Vec3<T>::Zero();
  for (const int other : contacts.near(s)) {
    const ContactPair<T> pair = contact_pair<T>(data, s, other, x, v);
    gain += contact_impulse(pair, dt, friction) / pair.mass[0];
  }
  return gain;
}

}  // namespace pliant
