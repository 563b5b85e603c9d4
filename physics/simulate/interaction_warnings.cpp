#include "physics/simulate/interaction_warnings.h"

#include <algorithm>
#include <cstdio>

namespace pliant {
namespace {

std::string name_of(const Interaction& it, size_t number) {
  return "interaction " + std::to_string(number) + " (" + interaction_name(it.type) + ")";
}

/// Whether an obstacle is so thin that grid nodes on both of its sides feel the same of the body.
bool is_thin(const Interaction& it, double dx) {
  constexpr double kLeastCells = 1.5;  // from its middle to its surface
  const bool solid =
      it.type == InteractionType::kPoke || (it.type == InteractionType::kCollider &&
                                            it.contact == ContactKind::kSeparating && !it.container && !it.distance);
  return solid && it.region.half_thickness() < kLeastCells * dx * (1 - 1e-6);
}

}  // namespace

template <class T>
void warn_of_idle(const LoadSchedule<T>& schedule, double seconds, SimulateSummary& summary) {
  for (size_t k = 0; k < schedule.size(); ++k)
    if (const std::string why = why_idle(schedule[k], seconds); !why.empty())
      summary.warnings.push_back(name_of(schedule[k], k) + " never acts: " + why);
}

template <class T>
void warn_of_thin_obstacles(const LoadSchedule<T>& schedule, double seconds, SimulateSummary& summary) {
  for (size_t k = 0; k < schedule.size(); ++k) {
    const Interaction& it = schedule[k];
    if (!is_thin(it, summary.cell_size) || !why_idle(it, seconds).empty()) continue;
    char line[320];
    std::snprintf(line, sizeof line,
                  "%s has a half-thickness of only %.3g m with cells of %.3g m: obstacles with less than 1.5 cells may "
                  "pass through the body or get stuck in it; make it larger, or use more driving particles, whose "
                  "cells are smaller",
                  name_of(it, k).c_str(), it.region.half_thickness(), summary.cell_size);
    summary.warnings.push_back(line);
  }
}

template <class T>
void warn_of_leaving(const LoadSchedule<T>& schedule, const BasicSimulationState<T>& state, SimulateSummary& summary) {
  for (size_t k = 0; k < schedule.size(); ++k) {
    const Interaction& it = schedule[k];
    if (!it.distance || !it.path.empty() || !it.vector.isZero() || !it.angular_velocity.isZero()) continue;
    const auto outside = std::count_if(state.x.begin(), state.x.end(), [&](const Vec3<T>& x) {
      return !it.distance->covers(x.template cast<double>());
    });
    if (outside == 0) continue;
    summary.warnings.push_back(name_of(it, k) + ": " + std::to_string(outside) + " of " + std::to_string(state.size()) +
                               " particles end outside of the space that it covers, where nothing of it stops them; "
                               "shorten the clip, or give a ground");
  }
}

template <class T>
void warn_of_misses(const LoadSchedule<T>& schedule, double seconds, SimulateSummary& summary) {
  for (size_t k = 0; k < schedule.size(); ++k) {
    const Interaction& it = schedule[k];
    if (!why_idle(it, seconds).empty()) continue;
    const bool moves = it.type == InteractionType::kPoke ||
                       (it.type == InteractionType::kCollider && (!it.path.empty() || it.vector.norm() > 0));
    const bool touched = std::any_of(summary.impulse_of_frame.begin(), summary.impulse_of_frame.end(),
                                     [&](const std::vector<Vec3d>& frame) { return !frame[k].isZero(0); });
    if (moves && !touched && summary.frames > 0)
      summary.warnings.push_back(name_of(it, k) + " touched nothing" +
                                 (is_thin(it, summary.cell_size) ? ": it may be too thin for the grid's cells" : ""));
  }
}

template <class T>
void warn_of_weak_grabs(const LoadSchedule<T>& schedule, double fps, SimulateSummary& summary) {
  constexpr double kAll = 0.999;  // of the maximum, in the mean of a frame
  for (size_t k = 0; k < schedule.size(); ++k) {
    const double max_force = schedule.max_force(k);
    const auto weak = [&](const std::vector<Vec3d>& frame) { return frame[k].norm() * fps >= kAll * max_force; };
    if (schedule[k].type != InteractionType::kGrab || std::ranges::none_of(summary.impulse_of_frame, weak)) continue;
    char line[256];
    std::snprintf(
        line, sizeof line,
        "%s pulls with its maximum force of %.3g N and may lag behind its path; a larger max_force follows it",
        name_of(schedule[k], k).c_str(), max_force);
    summary.warnings.push_back(line);
  }
}

template void warn_of_idle(const LoadSchedule<float>&, double, SimulateSummary&);
template void warn_of_thin_obstacles(const LoadSchedule<float>&, double, SimulateSummary&);
template void warn_of_leaving(const LoadSchedule<float>&, const BasicSimulationState<float>&, SimulateSummary&);
template void warn_of_misses(const LoadSchedule<float>&, double, SimulateSummary&);
template void warn_of_weak_grabs(const LoadSchedule<float>&, double, SimulateSummary&);
template void warn_of_idle(const LoadSchedule<double>&, double, SimulateSummary&);
template void warn_of_thin_obstacles(const LoadSchedule<double>&, double, SimulateSummary&);
template void warn_of_leaving(const LoadSchedule<double>&, const BasicSimulationState<double>&, SimulateSummary&);
template void warn_of_misses(const LoadSchedule<double>&, double, SimulateSummary&);
template void warn_of_weak_grabs(const LoadSchedule<double>&, double, SimulateSummary&);

}  // namespace pliant
