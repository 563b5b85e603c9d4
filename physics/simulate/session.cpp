#include "physics/simulate/session.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "gaussians/base/error.h"
#include "physics/simulate/grab_spring.h"

namespace pliant {
namespace {

/// Centre of mass of the particles that lie in a region at rest, where they are now.
Vec3d touched_centre(const Particles& particles, const SimulationState& state, const Region& region) {
  Vec3d sum = Vec3d::Zero();
  double mass = 0;
  for (size_t i = 0; i < particles.size(); ++i) {
    if (!region.contains(particles.position[i].cast<double>())) continue;
    sum += static_cast<double>(particles.mass[i]) * state.x[i].cast<double>();
    mass += particles.mass[i];
  }
  return mass > 0 ? Vec3d(sum / mass) : Vec3d::Zero();
}

/// Ends a path at a time, where it is then.
void cut_path(std::vector<Interaction::PathPoint>& path, double time) {
  if (path.back().time <= time) return;
  const Vec3d place = path_position(path, time);
  std::erase_if(path, [&](const Interaction::PathPoint& point) { return point.time >= time; });
  path.push_back({time, place});
}

/// Leaves out the second last point of a path whose last three are at one place; its place at any time stays the same.
void drop_idle_point(std::vector<Interaction::PathPoint>& path) {
  const size_t n = path.size();
  if (n < 3 || path[n - 3].position != path[n - 2].position || path[n - 2].position != path[n - 1].position) return;
  path[n - 2].time = path[n - 1].time;
  path.pop_back();
}

/// Whether nothing of it is left after a time.
bool is_over(const Interaction& it, double time) {
  return it.end() <= time || (it.type == InteractionType::kImpulse && it.start < time);
}

bool follows_a_path(const Interaction& it) {
  return it.type == InteractionType::kGrab || it.type == InteractionType::kPoke;
}

}  // namespace

Session::Session(const SimulateOptions& options, Particles particles, const std::vector<Interaction>& held,
                 SimulationState start)
    : options_(options), original_(particles), particles_(std::move(particles)), state_(std::move(start)) {
  settings_.damping_time = options.damping_time;
  settings_.gravity = options.gravity;
  for (const Interaction& it : held) {
    active_.push_back({static_cast<int>(history_.size())});
    history_.push_back(it);
  }
  rebuild();
  if (!options_.held_as_captured) options_.held_as_captured = simulator_->schedule().cancels_gravity(0);
}

std::vector<Interaction> Session::acting() const {
  std::vector<Interaction> script;
  for (const Active& a : active_) script.push_back(history_[a.number]);
  if (settings_.gravity != options_.gravity) {
    Interaction gravity;
    gravity.type = InteractionType::kGravity;
    gravity.vector = settings_.gravity;
    script.push_back(gravity);
  }
  return script;
}

void Session::rebuild() {
  SimulateOptions options = options_;
  options.damping_time = settings_.damping_time;
  if (settings_.max_substeps > 0) options.max_substeps = settings_.max_substeps;
  for (size_t i = 0; i < particles_.size(); ++i)
    particles_.young[i] = static_cast<float>(settings_.young_scale * original_.young[i]);
  for (size_t k = 0; k < particles_.materials.size(); ++k)
    for (const auto modulus : {&Material::bulk_modulus, &Material::branch_shear, &Material::branch_lambda,
                               &Material::branch_viscosity})  // which keeps the time of relaxation
      particles_.materials[k].*modulus = settings_.young_scale * original_.materials[k].*modulus;
  simulator_ = std::make_unique<Simulator<float>>(options, particles_, acting(), summary_);
  // A solver notices only changes within its own schedule, so that all that slept under another one wakes.
  state_.quiet_time.clear();
}

Session::Active* Session::find(int number) {
  const auto it = std::find_if(active_.begin(), active_.end(), [&](const Active& a) { return a.number == number; });
  return it == active_.end() ? nullptr : &*it;
}

void Session::set(const SessionSettings& settings) {
  const SessionSettings before = settings_;
  settings_ = settings;
  try {
    rebuild();
  } catch (...) {
    settings_ = before;
    rebuild();
    throw;
  }
}

int Session::begin(Interaction it) {
  it.start = state_.time;
  // A pin at 0 s counts as one that held the body before, where it was captured.
  if (it.type == InteractionType::kPin) it.start = std::max(it.start, std::numeric_limits<double>::min());
  if (it.type == InteractionType::kGrab && it.path.empty())
    it.path = {{0, touched_centre(original_, state_, it.region)}};
  const int number = static_cast<int>(history_.size());
  active_.push_back({number});
  history_.push_back(std::move(it));
  try {
    rebuild();
  } catch (...) {
    active_.pop_back();
    history_.pop_back();
    rebuild();
    throw;
  }
  return number;
}

void Session::move(int number, const Vec3d& target) {
  Active* const a = find(number);
  if (!a) return;
  Interaction& it = history_[number];
  CHECK_MSG(follows_a_path(it), "only grabs and fingers move");
  const double start = it.start, end = (state_.frame + 1) / options_.fps - start;
  std::vector<Interaction::PathPoint>& path = it.path;
  if (a->moved) {
    path.back().position = target;
  } else {
    cut_path(path, std::max(0.0, state_.frame / options_.fps - start));
    path.push_back({end, target});
  }
  a->moved = true;
}

void Session::end(int number) {
  Active* const a = find(number);
  if (!a) return;
  history_[number].duration = std::max(0.0, state_.time - history_[number].start);
  active_.erase(active_.begin() + (a - active_.data()));
  rebuild();
}

void Session::advance(const std::function<void()>& glance) {
  for (size_t k = 0; k < active_.size(); ++k) {
    Active& a = active_[k];
    Interaction& it = history_[a.number];
    if (!follows_a_path(it)) continue;
    // A path that nobody has continued stays where it is.
    if (!a.moved && it.start + it.path.back().time < (state_.frame + 0.5) / options_.fps)
      move(a.number, it.path.back().position);
    if (!a.moved) continue;
    a.moved = false;
    drop_idle_point(it.path);
    simulator_->set_path(k, it.path);
  }
  SimulationState next = state_;
  simulator_->advance(next, glance);
  state_ = std::move(next);
  substeps_ = summary_.substeps_of_frame.back();
  for (size_t k = 0; k < active_.size(); ++k) active_[k].force = options_.fps * summary_.impulse_of_frame.back()[k];
  summary_ = {};
  const size_t before = active_.size();
  std::erase_if(active_, [&](const Active& a) { return is_over(history_[a.number], state_.time); });
  if (active_.size() != before) rebuild();
}

SimulationState Session::state_within() const {
  SimulationState state = state_;
  simulator_->solver().store(state);
  return state;
}

bool Session::acts(int number) const {
  return std::any_of(active_.begin(), active_.end(), [&](const Active& a) { return a.number == number; });
}

Vec3d Session::force(int number) const {
  for (const Active& a : active_)
    if (a.number == number) return a.force;
  return Vec3d::Zero();
}

}  // namespace pliant
