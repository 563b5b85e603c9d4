#include "physics/mpm/object_contact.h"

#include "physics/mpm/contact_ring.h"

namespace pliant {
namespace {

/// What both directions of `exchange_impulse` compute from a pair.
struct Meeting {
  Vec3d normal, relative, along;  // from body 0 to body 1; v0 - v1; its part across the normal
  double steepness, approach, sliding, reduced_mass;
  double across;  // impulse across the normal per `along`, 0 .. reduced_mass
  bool sticks;

  bool touching() const { return steepness > 0 && approach > 0; }
  Meeting(double friction, const NodePair& pair) {
    const Vec3d g = pair.gradient[1] - pair.gradient[0];
    steepness = g.norm();
    normal = steepness > 0 ? Vec3d(g / steepness) : Vec3d::Zero();
    relative = pair.velocity[0] - pair.velocity[1];
    approach = relative.dot(normal);
    along = relative - approach * normal;
    sliding = along.norm();
    reduced_mass = pair.mass[0] * pair.mass[1] / (pair.mass[0] + pair.mass[1]);
    sticks = !(friction * approach < sliding);
    across = sticks ? reduced_mass : reduced_mass * friction * approach / sliding;
  }
};

}  // namespace

void exchange_impulse(double friction, NodePair& pair) {
  const Meeting meet(friction, pair);
  if (!meet.touching()) return;
  const Vec3d impulse = meet.reduced_mass * meet.approach * meet.normal + meet.across * meet.along;
  pair.velocity[0] -= impulse / pair.mass[0];
  pair.velocity[1] += impulse / pair.mass[1];
}

void exchange_impulse_adjoint(double friction, const NodePair& pair, NodePair& adj) {
  const Meeting meet(friction, pair);
  if (!meet.touching()) return;
  const double m0 = pair.mass[0], m1 = pair.mass[1], total = m0 + m1;
  // v0' = v0 - J / m0, v1' = v1 + J / m1 with J = m (a n + s t): m reduced mass, a approach, t along; s = 1 when they
  // stick, else mu a / |t|.
  const double s = meet.across / meet.reduced_mass;
  const Vec3d unit_impulse = meet.approach * meet.normal + s * meet.along, impulse = meet.reduced_mass * unit_impulse;
  const Vec3d adj_impulse = adj.velocity[1] / m1 - adj.velocity[0] / m0;
  adj.mass[0] = adj.velocity[0].dot(impulse) / (m0 * m0);
  adj.mass[1] = -adj.velocity[1].dot(impulse) / (m1 * m1);
  const double adj_reduced = adj_impulse.dot(unit_impulse);
  adj.mass[0] += adj_reduced * m1 * m1 / (total * total);
  adj.mass[1] += adj_reduced * m0 * m0 / (total * total);
  const Vec3d adj_unit = meet.reduced_mass * adj_impulse;
  double adj_approach = adj_unit.dot(meet.normal);
  Vec3d adj_normal = meet.approach * adj_unit, adj_along = s * adj_unit;
  if (!meet.sticks) {
    const double adj_s = adj_unit.dot(meet.along);
    adj_approach += adj_s * friction / meet.sliding;
    adj_along -= adj_s * s / (meet.sliding * meet.sliding) * meet.along;
  }
  // t = u - a n, a = u . n
  Vec3d adj_relative = adj_along;
  adj_approach -= adj_along.dot(meet.normal);
  adj_normal -= meet.approach * adj_along;
  adj_relative += adj_approach * meet.normal;
  adj_normal += adj_approach * meet.relative;
  adj.velocity[0] += adj_relative;
  adj.velocity[1] -= adj_relative;
  const Vec3d adj_g = (adj_normal - adj_normal.dot(meet.normal) * meet.normal) / meet.steepness;
  adj.gradient[1] = adj_g;
  adj.gradient[0] = -adj_g;
}

template <class T>
void apply_object_contact(const StepLoads<T>& loads, const BlockGrid& grid, T dx, std::vector<Node<T>>& nodes, int n) {
  const ContactRing<T> ring(loads, grid, dx, nodes, n);
  for (int a = 0; a < ring.size(); ++a) {
    for (int b = a + 1; b < ring.size(); ++b) {
      for (int k = 0; k < BlockGrid::kNodes; ++k) {
        NodePair pair;
        if (!ring.meet(a, b, k, pair)) continue;
        Node<T>* node[2] = {&nodes[static_cast<size_t>(ring.block(a)) * BlockGrid::kNodes + k],
                            &nodes[static_cast<size_t>(ring.block(b)) * BlockGrid::kNodes + k]};
        for (int i = 0; i < 2; ++i) pair.velocity[i] = velocity_of(*node[i]);
        exchange_impulse(loads.object_friction, pair);
        for (int i = 0; i < 2; ++i) set_velocity(*node[i], pair.velocity[i]);
      }
    }
  }
}

template <class T>
void apply_object_contact_adjoint(const StepLoads<T>& loads, const BlockGrid& grid, T dx,
                                  const std::vector<Node<T>>& before, int n, ContactGradient<T> adj) {
  const ContactRing<T> ring(loads, grid, dx, before, n);
  struct Met {
    int body[2];
    NodePair pair;
  };
  std::vector<Met> met;  // at one node, in the order in which they exchanged impulses
  std::vector<Node<T>> now(ring.size());
  for (int k = 0; k < BlockGrid::kNodes; ++k) {
    const auto at = [&](int a) { return static_cast<size_t>(ring.block(a)) * BlockGrid::kNodes + k; };
    for (int a = 0; a < ring.size(); ++a) now[a] = before[at(a)];
    met.clear();
    for (int a = 0; a < ring.size(); ++a)
      for (int b = a + 1; b < ring.size(); ++b) {
        NodePair pair;
        if (!ring.meet(a, b, k, pair)) continue;
        pair.velocity[0] = velocity_of(now[a]);
        pair.velocity[1] = velocity_of(now[b]);
        met.push_back({{a, b}, pair});
        exchange_impulse(loads.object_friction, pair);
        set_velocity(now[a], pair.velocity[0]);
        set_velocity(now[b], pair.velocity[1]);
      }
    for (size_t m = met.size(); m-- > 0;) {
      NodePair by{{0, 0}, {}, {Vec3d::Zero(), Vec3d::Zero()}};
      Node<T>* by_node[2];
      double* by_density[2];
      for (int i = 0; i < 2; ++i) {
        const size_t place = at(met[m].body[i]);
        by.velocity[i] = velocity_of(adj.velocity[place]);
        by_node[i] = &adj.mass[place];
        by_density[i] = &adj.density[ring.block(met[m].body[i])];
      }
      exchange_impulse_adjoint(loads.object_friction, met[m].pair, by);
      for (int i = 0; i < 2; ++i) set_velocity(adj.velocity[at(met[m].body[i])], by.velocity[i]);
      ring.meet_adjoint(met[m].body[0], met[m].body[1], k, by, by_node, by_density);
    }
  }
}

template <class T>
void add_contact_masses(const BlockGrid& grid, const std::vector<Node<T>>& by_mass, int n, Node<T>* adj) {
  const NodePatch<T> patch(grid, by_mass, n);
  for (int k = 0; k < BlockGrid::kNodes; ++k)
    adj[k].lane[3] += patch.node(k).lane[3] + static_cast<T>(patch.gradient_adjoint(k));
}

#define PLIANT_OBJECT_CONTACT(T)                                                                                    \
  template void apply_object_contact(const StepLoads<T>&, const BlockGrid&, T, std::vector<Node<T>>&, int);         \
  template void apply_object_contact_adjoint(const StepLoads<T>&, const BlockGrid&, T, const std::vector<Node<T>>&, \
                                             int, ContactGradient<T>);                                              \
  template void add_contact_masses(const BlockGrid&, const std::vector<Node<T>>&, int, Node<T>*);
PLIANT_OBJECT_CONTACT(float)
PLIANT_OBJECT_CONTACT(double)
#undef PLIANT_OBJECT_CONTACT

}  // namespace pliant
