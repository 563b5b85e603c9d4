#include "app/evaluate/last_load.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/evaluate/metrics.h"
#include "app/import/interactions.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

/// interactions.json of a trajectory; empty when there is none.
fs::path script_of(const fs::path& trajectory) {
  std::error_code ignored;
  const fs::path file = fs::weakly_canonical(trajectory), beside = file.parent_path() / "interactions.json";
  if (fs::is_regular_file(beside, ignored)) return beside;
  // RUN/objects/OBJECT/trajectory.h5
  const fs::path run = file.parent_path().parent_path().parent_path(), script = run / "interactions.json";
  if (!fs::is_regular_file(run / "run.json", ignored) || !fs::is_regular_file(script, ignored)) return {};
  const json manifest = read_json(run / "run.json");
  const json* outputs = find_value(manifest, "stages.simulate.outputs");
  const bool simulated = outputs && std::find(outputs->begin(), outputs->end(),
                                              fs::relative(file, run).generic_string()) != outputs->end();
  return simulated ? script : fs::path();
}

}  // namespace

std::optional<double> last_load_change(const fs::path& trajectory, double until) {
  const fs::path script = script_of(trajectory);
  if (script.empty()) return std::nullopt;
  const std::string text = read_text(script);
  // That of a configuration of PhysGaussian is no list of loads.
  if (json::parse(text, nullptr, false).contains("physgaussian")) return std::nullopt;
  double last = 0;
  for (const Interaction& load : parse_interactions(text, {}, script.string())) {
    const double begin = load.start, end = load.end();
    if (begin >= until) continue;
    const double moved = load.path.empty() ? begin : std::min(begin + load.path.back().time, end);
    last = std::max({last, begin, std::min(moved, until)});
    if (end < until) last = std::max(last, end);
  }
  return last;
}

std::optional<double> release_of(const fs::path& file, const TrajectoryFile& trajectory, double until) {
  const auto& frames = trajectory.frames;
  const std::optional<double> last = last_load_change(file, until);
  const auto is_free = [&](const TrajectoryFile::Frame& frame) {
    return frame.time >= *last && frame.time <= until * (1 + 1e-9);
  };
  if (!last || static_cast<size_t>(std::count_if(frames.begin(), frames.end(), is_free)) < kLeastFree)
    return std::nullopt;
  return std::max(0.0, *last - frames.front().time);
}

}  // namespace pliant
