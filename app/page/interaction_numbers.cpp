#include "app/page/interaction_numbers.h"

#include <cmath>
#include <limits>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

Vec3d vector_at(std::span<const double> numbers, size_t at) { return {numbers[at], numbers[at + 1], numbers[at + 2]}; }

}  // namespace

std::vector<double> numbers_of(const Interaction& it) {
  std::vector<double> out = {static_cast<double>(it.type), std::isfinite(it.duration) ? it.duration : 0,
                             static_cast<double>(it.region.kind)};
  const auto add = [&](const Vec3d& v) { out.insert(out.end(), v.data(), v.data() + 3); };
  add(it.region.point);
  add(it.region.vector);
  out.push_back(it.region.radius);
  add(it.vector);
  for (const double x : {it.friction, it.rate, it.drag_coefficient, it.air_density, it.stiffness, it.damping,
                         it.max_force, static_cast<double>(it.contact), it.mass})
    out.push_back(x);
  return out;
}

Interaction interaction_of(std::span<const double> n) {
  CHECK(n.size() == kInteractionNumbers);
  Interaction it;
  it.type = static_cast<InteractionType>(static_cast<int>(n[0]));
  it.duration = n[1] > 0 ? n[1] : std::numeric_limits<double>::infinity();
  it.region.kind = static_cast<Region::Kind>(static_cast<int>(n[2]));
  it.region.point = vector_at(n, 3);
  it.region.vector = vector_at(n, 6);
  it.region.radius = n[9];
  it.vector = vector_at(n, 10);
  it.friction = n[13];
  it.rate = n[14];
  it.drag_coefficient = n[15];
  it.air_density = n[16];
  it.stiffness = n[17];
  it.damping = n[18];
  it.max_force = n[19];
  it.contact = static_cast<ContactKind>(static_cast<int>(n[20]));
  it.mass = n[21];
  if (it.type == InteractionType::kPoke) it.path = {{0, it.region.point}};
  return it;
}

}  // namespace pliant
