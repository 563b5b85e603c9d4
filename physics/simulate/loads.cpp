#include "physics/simulate/loads.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "physics/laws/law.h"
#include "physics/simulate/grab_spring.h"
#include "physics/simulate/inertia.h"
#include "physics/simulate/obstacle.h"
#include "physics/simulate/weights.h"

namespace pliant {
namespace {

bool marks_particles(InteractionType type) {
  return type == InteractionType::kPointForce || type == InteractionType::kImpulse || type == InteractionType::kGrab ||
         type == InteractionType::kGust || type == InteractionType::kTorque || type == InteractionType::kWind ||
         type == InteractionType::kWeight;
}

template <class T>
void add(StepLoads<T>& loads, uint32_t bit, const Vec3d& acceleration, double drag = 0) {
  loads.body.push_back({bit, acceleration.cast<T>(), static_cast<T>(drag)});
}

/// The pin that ends `inset` inside of a region.  A cylinder shorter than twice that has no such region of its kind.
Pin sprung_pin(const Region& region, double inset) {
  return region.kind == Region::Kind::kCylinder ? Pin(region, inset) : Pin(region.grown(-inset));
}

}  // namespace

double end_of(const Interaction& it) {
  const bool follows = it.type == InteractionType::kGrab || it.type == InteractionType::kPoke;
  return follows && std::isinf(it.duration) && it.path.size() > 1 ? it.start + it.path.back().time : it.end();
}

template <class T>
LoadSchedule<T>::LoadSchedule(const SimulateOptions& options, const BasicParticles<T>& particles,
                              const std::vector<Interaction>& interactions)
    : options_(options), bits_(particles.size(), 0) {
  const double dx = options.cell_size > 0 ? options.cell_size : static_cast<double>(particles.cell_size);
  Box bounds;
  std::vector<double> mass;
  for (size_t i = 0; i < particles.size(); ++i) {
    const size_t object = particles.object.empty() ? 0 : particles.object[i];
    if (mass.size() <= object) {
      mass.resize(object + 1);
      volume_.resize(object + 1);
    }
    mass[object] += particles.mass[i];
    volume_[object] += particles.volume[i];
    flows_ |= flows(particles.material(i).law);
    bounds.add(particles.position[i].template cast<float>());
  }
  for (size_t o = 0; o < mass.size(); ++o) density_.push_back(volume_[o] > 0 ? mass[o] / volume_[o] : 0);
  body_size_ = bounds.size().norm() + 4 * dx;
  body_middle_ = bounds.centre().cast<double>();
  cell_size_ = dx;
  const std::vector<T> loaded = masses_with_weights(particles, interactions);
  for (const T m : loaded) body_mass_ += m;
  int used_bits = 0;
  for (size_t k = 0; k < interactions.size(); ++k) {
    validate_interaction(interactions[k], k);
    Entry entry;
    entry.interaction = interactions[k];
    Interaction& it = entry.interaction;
    if (it.region.kind == Region::Kind::kHalfSpace) it.region.vector.normalize();
    entry.end = end_of(it);
    const std::string where = "interaction " + std::to_string(k) + " (" + interaction_name(it.type) + ")";

    double nearest = INFINITY;
    for (size_t i = 0; i < particles.size(); ++i)
      nearest = std::min(nearest, it.region.signed_distance(particles.position[i].template cast<double>()));
    if (it.type == InteractionType::kPin) {
      entry.reaches_body = nearest <= (kPinReach + 1.5) * dx;
      if (!entry.reaches_body)
        warnings_.push_back(where + " fixes nothing: the body is " + std::to_string(nearest) + " m away");
    }
    if (it.type == InteractionType::kPin && it.start == 0 && used_bits < 32) {
      for (size_t i = 0; i < particles.size(); ++i) {
        if (it.region.signed_distance(particles.position[i].template cast<double>()) > kClampReach * dx) continue;
        entry.sprung = true;
        bits_[i] |= uint32_t{1} << used_bits;
      }
      if (entry.sprung) entry.bit = uint32_t{1} << used_bits++;
    }
    if (it.type == InteractionType::kPoke) {
      double miss = INFINITY;
      for (const Vec3<T>& p : particles.position)
        miss = std::min(miss, distance_to_path(it.path, p.template cast<double>()));
      miss -= it.region.radius;
      if (miss > 0.5 * dx)
        warnings_.push_back(where + " passes the body at rest at a distance of " + std::to_string(miss) + " m");
    }
    if (marks_particles(it.type)) {
      if (nearest > 0)
        throw usage_error(where, "region",
                          "touches no particle; the nearest is " + std::to_string(nearest) + " m outside",
                          "move or enlarge the region");
      if (used_bits == 32)
        throw usage_error(where, "", "exceeds the maximum of 32 interactions that act on particles",
                          "split the script into several runs");
      entry.bit = uint32_t{1} << used_bits++;
      for (size_t i = 0; i < particles.size(); ++i) {
        if (!it.region.contains(particles.position[i].template cast<double>())) continue;
        bits_[i] |= entry.bit;
        entry.mass += loaded[i];
        entry.volume += particles.volume[i];
        entry.max_force += static_cast<double>(particles.young[i]) * particles.volume[i];
        if (it.type == InteractionType::kGrab || it.type == InteractionType::kTorque)
          entry.touched.push_back(static_cast<int>(i));
      }
      if (it.type == InteractionType::kGrab) {
        entry.length = bar_length<T>(particles, entry.touched);
        entry.max_force = it.max_force > 0 ? it.max_force : GrabSpring::kMaxStrain * entry.max_force / entry.length;
      }
    }
    entries_.push_back(std::move(entry));
  }
}

template <class T>
void LoadSchedule<T>::set_path(size_t k, const std::vector<Interaction::PathPoint>& path) {
  Entry& entry = entries_[k];
  entry.interaction.path = path;
  entry.end = end_of(entry.interaction);
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
  const GrabSpring spring(entry.interaction, body_mass_, entry.max_force, t, dt);
  const auto motion = solver.motion_of(entry.touched);
  const Vec3d force = spring.force(spring.unlimited(motion.centre, motion.velocity, entry.mass));
  add<T>(loads, entry.bit, force / entry.mass);
}

template <class T>
void LoadSchedule<T>::add_torque(const Entry& entry, double part, const Mpm<T>& solver, StepLoads<T>& loads) const {
  const auto motion = solver.motion_of(entry.touched);
  BodyLoad<T> load;
  load.bit = entry.bit;
  load.angular = (part * angular_acceleration(motion.inertia(), entry.interaction.vector)).template cast<T>();
  load.centre = motion.centre.template cast<T>();
  loads.body.push_back(load);
}

template <class T>
bool LoadSchedule<T>::has_wind() const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [](const Entry& e) { return e.interaction.type == InteractionType::kWind; });
}

template <class T>
double LoadSchedule<T>::collider_speed(double t, double dt) const {
  double fastest = 0;
  for (const Entry& entry : entries_) {
    const Interaction& it = entry.interaction;
    const bool collides = it.type == InteractionType::kCollider || it.type == InteractionType::kPoke;
    if (!collides || overlap(t, dt, it.start, entry.end) <= 0) continue;
    fastest = std::max(fastest, obstacle_speed(it, t, dt, body_middle_, body_size_));
  }
  return fastest;
}

template <class T>
std::vector<int> LoadSchedule<T>::acting(double t) const {
  std::vector<int> marks;
  for (size_t k = 0; k < entries_.size(); ++k) {
    const Interaction& it = entries_[k].interaction;
    const bool lasts = it.type == InteractionType::kGravity || it.type == InteractionType::kPin || is_obstacle(it.type);
    if (!lasts || t < it.start || t >= entries_[k].end) continue;
    bool moves = false;
    for (size_t p = 1; p < it.path.size(); ++p)
      moves |= t >= it.start + it.path[p - 1].time && t < it.start + it.path[p].time &&
               it.path[p].position != it.path[p - 1].position;
    marks.insert(marks.end(), {static_cast<int>(k), moves ? 1 : 0});
  }
  return marks;
}

template <class T>
void LoadSchedule<T>::at(double t, double dt, const Mpm<T>& solver, StepLoads<T>& loads) const {
  const double middle = t + 0.5 * dt;
  Vec3d gravity = options_.gravity;
  loads.body.clear();
  loads.pins.clear();
  loads.colliders.clear();
  loads.density = density_;
  loads.object_friction = options_.object_friction;
  std::vector<int> collider_source, pin_source, body_source;
  for (size_t k = 0; k < entries_.size(); ++k) {
    const Entry& entry = entries_[k];
    const Interaction& it = entry.interaction;
    const double part = overlap(t, dt, it.start, entry.end);
    const bool active = middle >= it.start && middle < entry.end;
    switch (it.type) {
      case InteractionType::kGravity:
        if (active) gravity = it.vector;
        break;
      case InteractionType::kPin:
        if (!active) break;
        pin_source.push_back(static_cast<int>(k));
        loads.pins.push_back(entry.sprung ? sprung_pin(it.region, (kPinReach + kClampDepth) * cell_size_)
                                          : Pin(it.region));
        if (!entry.sprung) break;
        loads.body.emplace_back();
        loads.body.back().bit = entry.bit;
        loads.body.back().spring = static_cast<T>(kClampSpring);
        break;
      case InteractionType::kPointForce:
        if (part > 0) add<T>(loads, entry.bit, part / entry.mass * it.vector);
        break;
      case InteractionType::kImpulse:
        if (starts_within(it.start, t, dt)) add<T>(loads, entry.bit, it.vector / (entry.mass * dt));
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
      case InteractionType::kCollider:
      case InteractionType::kPoke:
        if (!active) break;
        add_obstacle(obstacle_at(it, t, dt), loads.colliders);
        collider_source.resize(loads.colliders.size(), static_cast<int>(k));
        break;
      case InteractionType::kTorque:
        if (part > 0) add_torque(entry, part, solver, loads);
        break;
      case InteractionType::kWind:
        if (!(part > 0)) break;
        loads.body.emplace_back();
        loads.body.back().bit = entry.bit;
        loads.body.back().wind = it.vector.template cast<T>();
        loads.body.back().pressure = static_cast<T>(part * 0.5 * it.air_density * it.drag_coefficient);
        break;
      case InteractionType::kWeight:
        // It was not there when the body was captured.
        if (!cancels_gravity(middle)) break;
        loads.body.emplace_back();
        loads.body.back().bit = entry.bit;
        loads.body.back().per_volume = (it.mass / entry.volume * options_.gravity).template cast<T>();
        break;
    }
    body_source.resize(loads.body.size(), static_cast<int>(k));
  }
  loads.source = std::move(collider_source);
  loads.source.insert(loads.source.end(), pin_source.begin(), pin_source.end());
  loads.source.insert(loads.source.end(), body_source.begin(), body_source.end());
  if (options_.sleep_speed > 0) loads.acting = acting(middle);
  if (cancels_gravity(middle)) gravity -= options_.gravity;
  loads.gravity = gravity.cast<T>();
  loads.velocity_scale = options_.damping_time > 0 ? static_cast<T>(std::exp(-2 * dt / options_.damping_time)) : T(1);
  loads.viscosity_time = static_cast<T>(options_.viscosity_time);
  loads.strain_rate_kept = options_.pic ? T(0) : static_cast<T>(std::exp(-dt * options_.strain_rate_damping));
  loads.spin_kept = options_.pic ? T(0) : T(1);
}

template class LoadSchedule<float>;
template class LoadSchedule<double>;

}  // namespace pliant
