#include <fmt/format.h>

#include <cmath>

#include "app/fit/fit_limits.h"
#include "fitting/fit/fit_markers.h"

namespace pliant {
namespace {

const char* const kCheckMarkers = "check --marker-axes, --marker-units, --marker-load and the pins";

/// Why the time of the release is not to be relied on; else empty.
std::string poor_release(const MarkerFitResult& r, const MarkerFitOptions& options) {
  if (!std::isfinite(r.sigma_release))
    return std::isfinite(options.release)
               ? fmt::format(
                     "The release time was not found within {:.3g} s of --marker-release, which may be wrong: "
                     "correct it, or leave it out.",
                     options.release_range)
               : "The release time was not found within the range searched; give --marker-release.";
  if (r.sigma_release > options.release_range)
    return fmt::format(
        "The release time is known only to within {:.2g} s, more than the {:.2g} s either way that were searched, so "
        "that E and damping may be wrong. Check --marker-rest and --marker-release.",
        r.sigma_release, options.release_range);
  return "";
}

}  // namespace

std::vector<std::string> doubts_of(const MarkerFitResult& r, const MarkerFitOptions& options) {
  std::vector<std::string> out;
  if (r.search_end != 0)
    out.push_back(
        fmt::format("E is from the {} end of the search: the recording does not determine it; {}, or begin "
                    "from another --young.",
                    r.search_end < 0 ? "low" : "high", kCheckMarkers));
  if (r.rms > kPoorFit * r.rms_still)
    out.push_back(fmt::format(
        "The fitted motion explains {} of the recording: marker RMSE {:.3g} mm, against {:.3g} mm for a static object. "
        "Do not rely on E, damping or their errors; {}.",
        r.rms < r.rms_still ? "little" : "nothing", 1e3 * r.rms, 1e3 * r.rms_still, kCheckMarkers));
  if (!r.converged)
    out.push_back(
        "The refinement stopped before it converged: E, damping and the release are less exact than their errors say.");
  const std::string release = poor_release(r, options);
  if (!release.empty()) out.push_back(release);
  return out;
}

std::vector<std::string> undetermined_by_markers(const MarkerFitResult& r, const MarkerFitOptions& options,
                                                 bool gravity, bool start_given) {
  std::vector<std::string> out = doubts_of(r, options);
  out.push_back(
      gravity
          ? "The load is the body's own weight, so the markers determine E / density: E is valid for the given density."
          : "E is valid for the given density, Poisson's ratio and load.");
  out.push_back(std::string(start_given ? "One factor of the given material" : "One stiffness") +
                " was fitted for the whole object; neither differences between its parts nor Poisson's ratio were "
                "fitted.");
  if (r.search_end == 0 && r.sigma_log10_young > 0.1)
    out.push_back(fmt::format("E is known only to within a factor of {:.2g}.", std::pow(10.0, r.sigma_log10_young)));
  if (r.sigma_log_damping > 0.5)
    out.push_back(fmt::format("Damping is not determined by {:.2g} s of motion.", options.window));
  return out;
}

}  // namespace pliant
