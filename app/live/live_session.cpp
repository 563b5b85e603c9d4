#include "app/live/live_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "app/page/most_substeps.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr double kMostWork = 1.2e6;     // particles times substeps of a frame, which a person waits for
constexpr double kMostSubsteps = 2000;  // of a frame, unless the body at rest needs as many
constexpr size_t kMostActive = 64;      // interactions at a time

bool finite(const SimulationState& state) {
  float sum = 0;
  for (const Vec3f& x : state.x) sum += x.sum();
  for (const Vec3f& v : state.v) sum += v.sum();
  for (const Mat3f& F : state.F) sum += F.sum();
  return std::isfinite(sum);
}

SimulationState at_rest(SimulationState state) {
  for (Vec3f& v : state.v) v.setZero();
  for (Vec3f& v : state.node_velocity) v.setZero();
  for (Mat3f& C : state.C) C.setZero();
  return state;
}

}  // namespace

LiveSession::LiveSession(const SimulateOptions& options, const Particles& particles,
                         const std::vector<Interaction>& held, const SimulationState& start)
    : options_(options), particles_(particles), first_(start) {
  options_.max_substeps = max_substeps(1);
  for (size_t k = 0; k < held.size(); ++k) held_[static_cast<int>(k)] = held[k];
  held_at_start_ = static_cast<int>(held.size());
  open(start);
}

/// Substeps at which a frame is given up.
int LiveSession::max_substeps(double young_scale) const {
  const double many = std::min(kMostWork / static_cast<double>(particles_.size()), kMostSubsteps);
  return most_substeps(options_, particles_, young_scale, many);
}

void LiveSession::open(const SimulationState& start) {
  std::vector<Interaction> held;
  active_.clear();
  for (const auto& [number, it] : held_) {
    active_[number] = Active(static_cast<int>(held.size()));
    held.push_back(it);
  }
  SimulationState state = start;
  state.frame = 0;
  state.time = 0;
  session_ = std::make_unique<Session>(options_, particles_, held, std::move(state));
  options_.held_as_captured = session_->held_as_captured();  // of the first one, for those after a failure
}

/// Throws Error{kUsage} where it cannot.
void LiveSession::begin(const LiveCommand& command, LiveAnswer& answer) {
  const std::string number = std::to_string(command.number);
  if (command.number < held_at_start_)
    throw usage_error("begin", number, "is the number of an interaction that acts from the start",
                      fmt::format("give one from {} on", held_at_start_));
  if (active_.count(command.number)) throw usage_error("begin", number, "is already in use", "end it first");
  if (active_.size() >= kMostActive)
    throw usage_error("begin", number, "exceeds the maximum number of interactions", "end something first");
  const int in_session = session_->begin(command.interaction);
  const InteractionType type = command.interaction.type;
  Active& active = active_[command.number] = Active(in_session);
  active.follows = type == InteractionType::kGrab || type == InteractionType::kPoke;
  if (type == InteractionType::kGrab) {
    active.hold = session_->history()[in_session].path.front().position;
    answer.holds.emplace_back(command.number, *active.hold);
  }
}

void LiveSession::apply(const LiveCommand& command, LiveAnswer& answer) {
  const auto it = active_.find(command.number);
  switch (command.kind) {
    case LiveCommand::Kind::kBegin:
      try {
        begin(command, answer);
      } catch (const Error& error) {
        if (error.failure != Failure::kUsage) throw;
        answer.refused.emplace_back(command.number, error.what());
      }
      break;
    case LiveCommand::Kind::kMove:
      if (it != active_.end() && it->second.follows) session_->move(it->second.in_session, command.place);
      break;
    case LiveCommand::Kind::kDrag:
      if (it != active_.end() && it->second.hold)
        session_->move(it->second.in_session, *it->second.hold + command.place);
      break;
    case LiveCommand::Kind::kEnd:
      if (it != active_.end()) session_->end(it->second.in_session);
      active_.erase(command.number);
      held_.erase(command.number);
      break;
    case LiveCommand::Kind::kSet: {
      SessionSettings settings = command.settings;
      settings.max_substeps = max_substeps(settings.young_scale);
      session_->set(settings);
      break;
    }
  }
}

LiveAnswer LiveSession::step(std::span<const LiveCommand> commands, const std::function<void()>& glance) {
  LiveAnswer answer;
  const size_t done = history_.size();
  for (const LiveCommand& command : commands) history_.push_back({frames_, command.text});
  const SimulationState good = session_->state();
  const auto start = std::chrono::steady_clock::now();
  try {
    for (const LiveCommand& command : commands) apply(command, answer);
    session_->advance(glance);
    if (!finite(session_->state())) throw numerical_error("simulate", "the motion is not finite", "push less");
  } catch (const Error& error) {
    if (error.failure == Failure::kInterrupted) {
      history_.erase(history_.begin() + static_cast<std::ptrdiff_t>(done), history_.end());
      throw;
    }
    answer.failed = error.what();
    recover(good, glance);
  }
  ++frames_;
  answer.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  answer.substeps = session_->substeps();
  for (const auto& [number, active] : active_) answer.forces.emplace_back(number, session_->force(active.in_session));
  forget_ended();
  return answer;
}

std::optional<SimulationState> LiveSession::state_within() const {
  SimulationState state = session_->state_within();
  if (!finite(state)) return {};
  return state;
}

/// Frees the numbers of what has ended by its duration.
void LiveSession::forget_ended() {
  const auto ended = [&](const auto& entry) { return !session_->acts(entry.second.in_session); };
  for (const auto& entry : active_)
    if (ended(entry)) held_.erase(entry.first);
  std::erase_if(active_, ended);
}

/// One frame from the first of these states with which it works in few substeps: a person waits for all that are tried.
void LiveSession::recover(const SimulationState& good, const std::function<void()>& glance) {
  const SimulationState states[] = {good, at_rest(good), at_rest(first_)};
  for (const SimulationState& state : states) {
    try {
      open(state);
      SessionSettings settings = session_->settings();
      settings.max_substeps = most_substeps(options_, particles_, 1, 0);
      session_->set(settings);
      session_->advance(glance);
      if (!finite(session_->state())) continue;
      settings.max_substeps = options_.max_substeps;
      session_->set(settings);
      return;
    } catch (const Error& error) {
      if (&state == &states[2] || error.failure == Failure::kInterrupted) throw;
    }
  }
  throw numerical_error("simulate", "not even the body at rest can be simulated", "simulate it again");
}

}  // namespace pliant
