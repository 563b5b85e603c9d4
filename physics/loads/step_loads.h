#pragma once

#include <cstdint>
#include <vector>

#include "physics/loads/body_load.h"
#include "physics/loads/collider.h"
#include "physics/loads/region.h"

namespace pliant {

/// What holds the nodes in it.
struct Pin {
  Region region;
  double inset = 0;  ///< m by which it ends inside of the region's surface

  Pin(const Region& region, double inset = 0) : region(region), inset(inset) {}
  double signed_distance(const Vec3d& x) const { return region.signed_distance(x) + inset; }
};

/// What acts during one substep.
template <class T>
struct StepLoads {
  Vec3<T> gravity = Vec3<T>::Zero();      ///< m/s^2, on every node
  T velocity_scale = 1;                   ///< exp(-2 dt / damping time)
  T viscosity_time = 0;                   ///< s, Kelvin-Voigt
  T strain_rate_kept = 1, spin_kept = 1;  ///< part of the symmetric and of the other part of C that outlives the step
  std::vector<BodyLoad<T>> body;
  std::vector<Pin> pins;
  std::vector<Collider> colliders;
  double object_friction = 0.5;  ///< Coulomb coefficient between bodies
  std::vector<int> source;       ///< the caller's numbers for colliders, pins and body loads, in that order; see
                                 ///< Mpm::impulses
  std::vector<int> acting;       ///< the caller's marks of what holds or drives the nodes, such as numbers; where they
                                 ///< change, what sleeps wakes
  std::vector<double> density;   ///< [objects] kg/m^3, mean of each body at rest: from it and a node's mass follows how
                                 ///< near the body's surface is; missing = contact as soon as a node has mass
};

}  // namespace pliant
