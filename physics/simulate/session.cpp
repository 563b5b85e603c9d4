#include "physics/simulate/session.h"

#include <algorithm>
#include <cmath>

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
    active_.push_back({static_cast<int>(history_.size()), it});
    history_.push_back(it);
  }
  rebuild();
}

std::vector<Interaction> Session::acting() const {
  std::vector<Interaction> script;
  for (const Active& a : active_) script.push_back(a.interaction);
  if (settings_.gravity != options_.gravity) {
    Interaction gravity;
    gravity.type = InteractionType::kGravity;
    gravity.vector = settings_.gravity;
    script.push_back(gravity);
  }
  // What held the body as it was captured still tells that its gravity is cancelled while anything holds it.
  for (const Interaction& it : history_)
    if (it.type == InteractionType::kPin && it.start == 0 && it.end() <= state_.time) script.push_back(it);
  return script;
}

void Session::rebuild() {
  SimulateOptions options = options_;
  options.damping_time = settings_.damping_time;
  if (settings_.max_substeps > 0) options.max_substeps = settings_.max_substeps;
  for (size_t i = 0; i < particles_.size(); ++i)
    particles_.young[i] = static_cast<float>(settings_.young_scale * original_.young[i]);
  simulator_ = std::make_unique<Simulator<float>>(options, particles_, acting(), summary_);
  force_.assign(active_.size(), Vec3d::Zero());
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
  if (it.type == InteractionType::kGrab && it.path.empty())
    it.path = {{0, touched_centre(original_, state_, it.region)}};
  const int number = static_cast<int>(history_.size());
  active_.push_back({number, it});
  try {
    rebuild();
  } catch (...) {
    active_.pop_back();
    rebuild();
    throw;
  }
  history_.push_back(it);
  return number;
}

void Session::move(int number, const Vec3d& target) {
  Active* const a = find(number);
  if (!a) return;
  CHECK_MSG(follows_a_path(a->interaction), "only grabs and fingers move");
  const double start = a->interaction.start, end = (state_.frame + 1) / options_.fps - start;
  std::vector<Interaction::PathPoint>& path = a->interaction.path;
  if (a->moved) {
    path.back().position = target;
  } else {
    cut_path(path, std::max(0.0, state_.frame / options_.fps - start));
    path.push_back({end, target});
  }
  a->moved = true;
  history_[number].path = path;
}

void Session::end(int number) {
  Active* const a = find(number);
  if (!a) return;
  history_[number].duration = state_.time - a->interaction.start;
  active_.erase(active_.begin() + (a - active_.data()));
  rebuild();
}

void Session::advance() {
  for (Active& a : active_) {
    // A path that nobody has continued stays where it is.
    if (follows_a_path(a.interaction) && !a.moved &&
        a.interaction.start + a.interaction.path.back().time < (state_.frame + 0.5) / options_.fps)
      move(a.number, a.interaction.path.back().position);
    a.moved = false;
  }
  size_t k = 0;
  for (const Active& a : active_) {
    if (follows_a_path(a.interaction)) simulator_->set_path(k, a.interaction.path);
    ++k;
  }
  SimulationState next = state_;
  simulator_->advance(next);
  state_ = std::move(next);
  substeps_ = summary_.substeps_of_frame.back();
  for (size_t n = 0; n < force_.size(); ++n) force_[n] = options_.fps * summary_.impulse_of_frame.back()[n];
  summary_ = {};
  const size_t before = active_.size();
  std::erase_if(active_, [&](const Active& a) { return is_over(a.interaction, state_.time); });
  if (active_.size() != before) rebuild();
}

bool Session::acts(int number) const {
  return std::any_of(active_.begin(), active_.end(), [&](const Active& a) { return a.number == number; });
}

Vec3d Session::force(int number) const {
  for (size_t k = 0; k < force_.size(); ++k)
    if (active_[k].number == number) return force_[k];
  return Vec3d::Zero();
}

}  // namespace pliant
