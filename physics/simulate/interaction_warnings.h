#pragma once

#include "physics/simulate/loads.h"
#include "physics/simulate/simulate.h"

// Each adds to summary.warnings what a user should know of the interactions of a run of so many seconds.

namespace pliant {

/// Those that never act.
template <class T>
void warn_of_idle(const LoadSchedule<T>& schedule, double seconds, SimulateSummary& summary);
/// Obstacles that are thin beside the cells of the grid.
template <class T>
void warn_of_thin_obstacles(const LoadSchedule<T>& schedule, double seconds, SimulateSummary& summary);
/// What ended beyond the part of space for which a collider's distances are known.
template <class T>
void warn_of_leaving(const LoadSchedule<T>& schedule, const BasicSimulationState<T>& state, SimulateSummary& summary);
/// Moving colliders and fingers that gave the body nothing while they acted.
template <class T>
void warn_of_misses(const LoadSchedule<T>& schedule, double seconds, SimulateSummary& summary);
/// Grabs that pulled as hard as they may during a whole frame.
template <class T>
void warn_of_weak_grabs(const LoadSchedule<T>& schedule, double fps, SimulateSummary& summary);

}  // namespace pliant
