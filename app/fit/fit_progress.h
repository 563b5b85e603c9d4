#pragma once

#include "app/run/run_directory.h"
#include "fitting/fit/fit_markers.h"
#include "fitting/fit/fit_material.h"

namespace pliant {

/// What an interrupted fit of the same options and inputs left in fit/checkpoint.h5, and the hooks that keep what is
/// done from now on.
MaterialFitProgress kept_progress(const Context& context, const RunDirectory& run, const std::string& provenance);
/// The same of a fit to markers.
struct KeptMarkerFit {
  MarkerFitState state;
  MarkerFitSink sink;
};
KeptMarkerFit kept_marker_fit(const Context& context, const RunDirectory& run, const std::string& provenance);
/// Once a fit is done.
void forget_progress(const RunDirectory& run);

}  // namespace pliant
