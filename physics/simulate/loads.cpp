#include "physics/simulate/loads.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "physics/simulate/grab_spring.h"

namespace pliant {
namespace {

bool marks_particles(InteractionType type) {
  return type == InteractionType::kPointForce || type == InteractionType::kImpulse || type == InteractionType::kGrab ||
         type == InteractionType::kGust;
}

template <class T>
void add(StepLoads<T>& loads, uint32_t bit, const Vec3d& acceleration, double drag = 0) {
  loads.body.push_back({bit, acceleration.cast<T>(), static_cast<T>(drag)});
}

}  // namespace

template <class T>
LoadSchedule<T>::LoadSchedule(const SimulateOptions& options, const BasicParticles<T>& particles,
                              const std::vector<Interaction>& interactions)
    : options_(options), body_mass_(particles.total_mass()), bits_(particles.size(), 0) {
  const double dx = options.cell_size > 0 ? options.cell_size : static_cast<double>(particles.cell_size);
  int used_bits = 0;
  for (size_t k = 0; k < interactions.size(); ++k) {
    validate_interaction(interactions[k], k);
    Entry entry;
    entry.interaction = interactions[k];
    Interaction& it = entry.interaction;
    if (it.region.kind == Region::Kind::kHalfSpace) it.region.vector.normalize();
    entry.end = it.end();
    if (it.type == InteractionType::kGrab) entry.end = std::min(entry.end, it.start + it.path.back().time);
    const std::string where = "interaction " + std::to_string(k) + " (" + interaction_name(it.type) + ")";

    double nearest = INFINITY;
    for (size_t i = 0; i < particles.size(); ++i)
      nearest = std::min(nearest, it.region.signed_distance(particles.position[i].template cast<double>()));
    if (it.type == InteractionType::kPin) {
      entry.reaches_body = nearest <= (kPinReach + 1.5) * dx;
      if (!entry.reaches_body)
        warnings_.push_back(where + " holds nothing: the body is " + std::to_string(nearest) + " m away");
    }
    if (marks_particles(it.type)) {
      if (nearest > 0)
        throw usage_error(where, "region",
                          "touches no particle; the nearest is " + std::to_string(nearest) + " m outside",
                          "move or enlarge the region");
      if (used_bits == 32)
        throw usage_error(where, "", "is the 33rd that acts on particles", "split the script into several runs");
      entry.bit = uint32_t{1} << used_bits++;
      for (size_t i = 0; i < particles.size(); ++i) {
        if (!it.region.contains(particles.position[i].template cast<double>())) continue;
        bits_[i] |= entry.bit;
        entry.mass += particles.mass[i];
        if (it.type == InteractionType::kGrab) entry.touched.push_back(static_cast<int>(i));
      }
    }
    entries_.push_back(std::move(entry));
  }
}

template <class T>
bool LoadSchedule<T>::pinned(double t) const {
  return std::any_of(entries_.begin(), entries_.end(), [&](const Entry& e) {
    return e.interaction.type == InteractionType::kPin && e.reaches_body && t >= e.interaction.start && t < e.end;
  });
}

template <class T>
void LoadSchedule<T>::add_grab(const Entry& entry, double t, double dt, const Mpm<T>& solver,
                               StepLoads<T>& loads) const {
  const GrabSpring spring(entry.interaction, body_mass_, t, dt);
  const auto motion = solver.motion_of(entry.touched);
  const Vec3d force = spring.force(spring.unlimited(motion.centre, motion.velocity, entry.mass));
  add<T>(loads, entry.bit, force / entry.mass);
}

template <class T>
void LoadSchedule<T>::at(double t, double dt, const Mpm<T>& solver, StepLoads<T>& loads) const {
  const double middle = t + 0.5 * dt;
  Vec3d gravity = options_.gravity;
  loads.body.clear(), loads.pins.clear(), loads.grounds.clear();
  for (const Entry& entry : entries_) {
    const Interaction& it = entry.interaction;
    const double part = overlap(t, dt, it.start, entry.end);
    const bool active = middle >= it.start && middle < entry.end;
    switch (it.type) {
      case InteractionType::kGravity:
        if (active) gravity = it.vector;
        break;
      case InteractionType::kPin:
        if (active) loads.pins.push_back(it.region);
        break;
      case InteractionType::kPointForce:
        if (part > 0) add<T>(loads, entry.bit, part / entry.mass * it.vector);
        break;
      case InteractionType::kImpulse:
        if (it.start >= t && it.start < t + dt) add<T>(loads, entry.bit, it.vector / (entry.mass * dt));
        break;
      case InteractionType::kGrab:
        if (active) add_grab(entry, t, dt, solver, loads);
        break;
      case InteractionType::kGust:
        if (part > 0 && it.rate > 0) {
          const double drag = part * it.rate / (1 + part * dt * it.rate);
          add<T>(loads, entry.bit, drag * it.vector, drag);
        } else if (part > 0) {
          add<T>(loads, entry.bit, part * it.vector);
        }
        break;
      case InteractionType::kGround:
        if (active) loads.grounds.push_back({it.region.point, it.region.vector, it.friction});
        break;
    }
  }
  if (pinned(middle)) gravity -= options_.gravity;
  loads.gravity = gravity.cast<T>();
  loads.velocity_scale = options_.damping_time > 0 ? static_cast<T>(std::exp(-2 * dt / options_.damping_time)) : T(1);
  loads.viscosity_time = static_cast<T>(options_.viscosity_time);
}

template class LoadSchedule<float>;
template class LoadSchedule<double>;

}  // namespace pliant
