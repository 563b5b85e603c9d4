#include "fitting/fit/marker_window.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr int kFewestSamples = 4;  // one more than unknowns

}  // namespace

double MarkerWindow::total_weight() const {
  double sum = 0;
  for (const std::vector<double>& row : weight)
    for (const double w : row) sum += w;
  return sum;
}

double marker_release(const MarkerWindowOptions& options, const MarkerTracks& tracks) {
  if (std::isfinite(options.release)) {
    const double begin = std::max(options.rest_begin, tracks.time.front()), end = tracks.time.back();
    if (!(options.release >= begin && options.release < end))
      throw usage_error("--marker-release", fmt::format("{:.4g} s", options.release),
                        fmt::format("is not between the begin of rest at {:.4g} s and the end of the recording at "
                                    "{:.4g} s",
                                    begin, end),
                        "give a time between them, or check --marker-rest");
    return options.release;
  }
  // Still until the onset: first against the first places, then against the mean of those before it.
  const auto first = std::lower_bound(tracks.time.begin(), tracks.time.end(), options.rest_begin);
  if (first == tracks.time.end())
    throw input_error("markers", "", "the recording ends before the body is at rest", "check --marker-rest");
  const std::ptrdiff_t skip = first - tracks.time.begin();
  MarkerTracks later = tracks;
  later.time.erase(later.time.begin(), later.time.begin() + skip);
  later.position.erase(later.position.begin(), later.position.begin() + skip);
  later.weight.erase(later.weight.begin(), later.weight.begin() + skip);
  double onset = *first;
  for (int pass = 0; pass < 2; ++pass) onset = onset_of_motion(later, mean_position(later, *first, onset));
  if (onset <= *first)
    throw input_error("markers", "", "they move from the first sample on, or not at all",
                      "record the body at rest before its release, or give --marker-release");
  return onset;
}

MarkerWindow marker_window(const MarkerWindowOptions& options, const MarkerTracks& tracks, double release,
                           const std::vector<int>& chosen, const std::vector<Vec3d>& rest) {
  MarkerWindow out;
  int samples = 0;
  for (size_t t = 0; t < tracks.samples(); ++t) {
    if (tracks.time[t] < release - options.release_range || tracks.time[t] > release + options.window) continue;
    out.time.push_back(tracks.time[t]);
    std::vector<Vec3d>& displacement = out.displacement.emplace_back();
    std::vector<double>& weight = out.weight.emplace_back();
    for (const int k : chosen) {
      displacement.push_back(tracks.position[t][k] - rest[k]);
      weight.push_back(tracks.weight[t][k]);
    }
    const bool seen = std::any_of(weight.begin(), weight.end(), [](double w) { return w > 0; });
    if (tracks.time[t] >= release && seen) ++samples;
  }
  if (samples < kFewestSamples)
    throw input_error(
        "markers", "",
        fmt::format("have {} sample{} from {:.4g} s to {:.4g} s, the window after the release", samples,
                    samples == 1 ? "" : "s", release, release + options.window),
        fmt::format("at least {} are fitted: give a longer --marker-window or check --marker-release", kFewestSamples));
  return out;
}

std::vector<std::string> spike_warnings(const MarkerTracks& recorded, const MarkerTracks& kept,
                                        const std::vector<int>& chosen) {
  std::vector<std::string> out;
  for (const int k : chosen) {
    std::vector<double> at;
    for (size_t t = 0; t < recorded.samples(); ++t)
      if (kept.weight[t][k] < recorded.weight[t][k]) at.push_back(recorded.time[t]);
    if (at.empty()) continue;
    const std::string more = at.size() > 1 ? fmt::format(" and in {} more samples", at.size() - 1) : "";
    out.push_back(
        fmt::format("marker '{}' jumps away and back at {:.4g} s{}: ignored there", recorded.name[k], at[0], more));
  }
  return out;
}

double seen_at_rest(const MarkerWindowOptions& options, const MarkerTracks& tracks, const std::vector<int>& chosen) {
  double earliest = tracks.time.front();
  for (const int k : chosen)
    for (size_t t = 0; t < tracks.samples(); ++t)
      if (tracks.time[t] >= options.rest_begin && tracks.weight[t][k] > 0) {
        earliest = std::max(earliest, tracks.time[t]);
        break;
      }
  return earliest;
}

}  // namespace pliant
