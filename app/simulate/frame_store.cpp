#include "app/simulate/frame_store.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/store/frames.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

json row(const Vec3d& v) { return {v.x(), v.y(), v.z()}; }
Vec3d vector_of(const json& row) { return {row.at(0).get<double>(), row.at(1).get<double>(), row.at(2).get<double>()}; }

/// Calls visit(name, field) for what adds up over the frames.
template <class Summary, class Visit>
void visit_fields(Summary& summary, Visit&& visit) {
  visit("frames", summary.frames);
  visit("substeps_of_frame", summary.substeps_of_frame);
  visit("min_dt", summary.min_dt);
  visit("max_dt", summary.max_dt);
  visit("max_displacement", summary.max_displacement);
  visit("max_stretch", summary.max_stretch);
  visit("max_stretch_frame", summary.max_stretch_frame);
  visit("settle_displacement", summary.settle_displacement);
  visit("settle_seconds", summary.settle_seconds);
  visit("rest_shape_residual", summary.rest_shape_residual);
  visit("rest_shape_sag", summary.rest_shape_sag);
  visit("rest_shape_iterations", summary.rest_shape_iterations);
  visit("strays", summary.strays);
  visit("retries", summary.retries);
  visit("particle_substeps", summary.particle_substeps);
  visit("warnings", summary.warnings);
}

json to_json(const SimulateSummary& summary) {
  json out = {{"max_stretch_place", row(summary.max_stretch_place)}, {"impulse_of_frame", json::array()}};
  visit_fields(summary, [&](const char* name, const auto& field) { out[name] = field; });
  for (const std::vector<Vec3d>& frame : summary.impulse_of_frame) {
    out["impulse_of_frame"].push_back(json::array());
    for (const Vec3d& impulse : frame) out["impulse_of_frame"].back().push_back(row(impulse));
  }
  return out;
}

SimulateSummary summary_from_json(const json& in) {
  SimulateSummary summary;
  visit_fields(summary, [&](const char* name, auto& field) { in.at(name).get_to(field); });
  summary.max_stretch_place = vector_of(in.at("max_stretch_place"));
  for (const json& frame : in.at("impulse_of_frame")) {
    summary.impulse_of_frame.emplace_back();
    for (const json& impulse : frame) summary.impulse_of_frame.back().push_back(vector_of(impulse));
  }
  return summary;
}

fs::path summary_file(const fs::path& folder, int frame) { return folder / fmt::format("{:04d}.json", frame); }

}  // namespace

FrameStore::FrameStore(fs::path folder, const std::string& key) : folder_(std::move(folder)) {
  const fs::path record = folder_ / "key.json";
  if (fs::exists(folder_) && !(fs::exists(record) && read_text(record) == key)) fs::remove_all(folder_);
  fs::create_directories(folder_);
  if (!fs::exists(record)) write_text(record, key);
}

SimulationState FrameStore::resume(const SimulationState& otherwise, SimulateSummary& summary) const {
  summary = {};
  const int last = last_frame(folder_);
  // Frame 0 is made of the start, and so anew.
  if (last < 1 || !fs::exists(summary_file(folder_, last))) return otherwise;
  try {
    summary = summary_from_json(json::parse(read_text(summary_file(folder_, last))));
  } catch (const json::exception&) {
    return otherwise;
  }
  return read_frame(folder_, last);
}

void FrameStore::add(const SimulationState& state, const SimulateSummary& summary) {
  // Of a frame that is there, so is its summary.
  write_text(summary_file(folder_, state.frame), to_json(summary).dump());
  write_frame(folder_, state);
  fs::remove(summary_file(folder_, state.frame - 1));
}

SimulationState FrameStore::frame(int index) const { return read_frame(folder_, index); }

void FrameStore::remove() { fs::remove_all(folder_); }

}  // namespace pliant
