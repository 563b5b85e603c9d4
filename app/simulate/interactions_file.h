#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/run/run_directory.h"

namespace pliant {

/// Records the loads of a simulation, rows in scene units, in interactions.json of the run directory.  A file of the
/// same loads stays as it is, however it is written.  One of other loads that was written or changed by hand is moved
/// aside first, which is said; one that this program wrote is replaced.
void record_loads(const Context& context, RunDirectory& run, const nlohmann::json& loads);

}  // namespace pliant
