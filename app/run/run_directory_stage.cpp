#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "app/run/run_directory.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// Restarts the kernel's record of this process's peak memory; without permission the peak stays that of the process.
void reset_peak_memory() { std::ofstream("/proc/self/clear_refs") << "5"; }

double peak_memory_megabytes() {
  std::ifstream in("/proc/self/status");
  for (std::string line; std::getline(in, line);)
    if (line.rfind("VmHWM:", 0) == 0) return std::stod(line.substr(6)) / 1024;
  return 0;
}

/// When a file was last written; the start of the clock for none.
fs::file_time_type time_of(const fs::path& file) {
  std::error_code none;
  const fs::file_time_type time = fs::last_write_time(file, none);
  return none ? fs::file_time_type() : time;
}

/// Where a folder goes that an attempt has made and that failed.
std::string failed_name(const std::string& name) { return name + ".failed"; }

bool has_files(const fs::path& folder) { return fs::is_directory(folder) && !fs::is_empty(folder); }

/// The names behind which things are moved aside.
std::vector<std::string> aside_names(const std::map<std::string, std::string>& moved) {
  std::vector<std::string> names;
  for (const auto& [name, aside] : moved) names.push_back(aside);
  return names;
}

/// Of what was being made when a stage ended early: the record without what begun adds to it.
json record_of_attempt(json begun) {
  begun.erase("outputs");
  begun.erase("replaced");
  return begun;
}

}  // namespace

std::vector<std::string> RunDirectory::outputs_of_others(const StageKey& key) const {
  std::vector<std::string> others;
  const json last = last_record(key.name);
  if (last.is_null()) return others;
  for (const std::string output : last.value("outputs", json::array()))
    if (std::find(key.outputs.begin(), key.outputs.end(), output) == key.outputs.end()) others.push_back(output);
  return others;
}

void RunDirectory::take_up_failed(const Context& context, const std::string& stage, const json& now,
                                  const Replaced& replaced) {
  if (manifest_.value("failed", json::object()).value(stage, json()) != now) return;
  for (const auto& [name, aside] : replaced.moved) {
    if (!has_files(path_ / failed_name(name)) || fs::exists(path_ / name)) continue;
    fs::rename(path_ / failed_name(name), path_ / name);
    context.progress.say(fmt::format("{}: going on from {}", stage, failed_name(name)));
  }
}

RunDirectory::Replaced RunDirectory::begin_replacing(const Context& context, const StageKey& key) {
  Replaced replaced{manifest_["stages"][key.name], {}, {}};
  for (const std::string output : replaced.record["outputs"]) replaced.written.emplace(output, time_of(path_ / output));
  if (!context.overwrite) {
    // What is kept of the result that is there may be of another object, or of another kind.
    std::set<std::string> kept(key.kept.begin(), key.kept.end());
    for (const std::string name : replaced.record.value("kept", json::array())) kept.insert(name);
    replaced.moved = names_aside({kept.begin(), kept.end()});
  }
  manifest_["stages"].erase(key.name);
  return replaced;
}

void RunDirectory::move_replaced(const Context& context, const std::string& stage, const json& now,
                                 const Replaced& replaced) {
  for (const auto& [name, aside] : replaced.moved) fs::rename(path_ / name, path_ / aside);
  if (!replaced.moved.empty())
    context.progress.say(
        fmt::format("{}: previous results kept as {}", stage, fmt::join(aside_names(replaced.moved), ", ")));
  take_up_failed(context, stage, now, replaced);
}

json RunDirectory::to_json(const Replaced& replaced) {
  json out = {{"record", replaced.record}, {"moved", json::array()}, {"written", json::array()}};
  for (const auto& [name, aside] : replaced.moved) out["moved"].push_back({name, aside});
  for (const auto& [output, time] : replaced.written)
    out["written"].push_back({output, static_cast<std::int64_t>(time.time_since_epoch().count())});
  return out;
}

RunDirectory::Replaced RunDirectory::still_replaced(const Context& context, const std::string& stage, const json& now) {
  const json begun = manifest_.value("begun", json::object()).value(stage, json());
  Replaced replaced;
  if (has(stage) || !begun.is_object() || !begun.contains("replaced")) return replaced;
  const json& kept = begun["replaced"];
  bool all_aside = true, none_aside = true;
  for (const json& pair : kept["moved"]) {
    const std::string aside = pair[1];
    (fs::exists(path_ / aside) ? none_aside : all_aside) = false;
    replaced.moved.emplace(pair[0].get<std::string>(), aside);
  }
  for (const json& pair : kept["written"])
    replaced.written.emplace(pair[0].get<std::string>(),
                             fs::file_time_type(fs::file_time_type::duration(pair[1].get<std::int64_t>())));
  replaced.record = kept["record"];
  if (!all_aside) {
    // A program that was killed just before it moved the previous result, or after it moved it back, left it whole.
    const bool whole = std::all_of(replaced.written.begin(), replaced.written.end(), [&](const auto& output) {
      return fs::exists(path_ / output.first) && time_of(path_ / output.first) == output.second;
    });
    if (none_aside && whole) {
      manifest_["stages"][stage] = replaced.record;
      manifest_["begun"].erase(stage);
      save();
    }
    return {};
  }
  if (first_difference(begun, now).empty()) return replaced;
  put_back(context, stage, record_of_attempt(begun), replaced);
  return {};
}

void RunDirectory::put_back(const Context& context, const std::string& stage, const json& attempt,
                            const Replaced& replaced) {
  if (replaced.record.is_null()) return;
  for (const auto& [name, aside] : replaced.moved) {
    if (has_files(path_ / name)) {
      fs::remove_all(path_ / failed_name(name));
      fs::rename(path_ / name, path_ / failed_name(name));
      manifest_["failed"][stage] = attempt;
      context.progress.say(fmt::format("{}: the partial {} is kept as {}; the same command resumes from it", stage,
                                       name, failed_name(name)));
    }
    fs::remove_all(path_ / name);
    fs::rename(path_ / aside, path_ / name);
  }
  // Where some of its files were written anew already, the previous result is no more.
  for (const auto& [output, written] : replaced.written)
    if (time_of(path_ / output) != written) return;
  manifest_["stages"][stage] = replaced.record;
  manifest_["begun"].erase(stage);
  save();
  context.progress.say(stage + ": the previous result stays");
}

json RunDirectory::stage(const Context& context, const StageKey& key,
                         const std::function<json(const std::string& provenance)>& body) {
  hold();
  const json now = record_of(key, context.seed);
  const std::vector<std::string> others = outputs_of_others(key);
  Replaced replaced = still_replaced(context, key.name, now);
  const bool replaces = has(key.name);
  if (replaces) {
    const json& before = manifest_["stages"][key.name];
    const std::string changed = first_difference(before, now);
    // Files of the same kind may be there from elsewhere: of an object that had another name.
    const bool complete = before["outputs"] == json(key.outputs) &&
                          std::all_of(key.outputs.begin(), key.outputs.end(),
                                      [&](const std::string& output) { return fs::exists(path_ / output); });
    if (changed.empty() && complete) {
      context.progress.say(fmt::format("{}: unchanged, skipped", key.name));
      return before["summary"];
    }
    if (!changed.empty()) context.progress.say(fmt::format("{}: {}, running again", key.name, changed));
    replaced = begin_replacing(context, key);
  }
  json& begun = manifest_["begun"][key.name] = now;
  begun["outputs"] = key.outputs;
  for (const std::string& output : others) begun["outputs"].push_back(output);
  if (!replaced.record.is_null()) begun["replaced"] = to_json(replaced);
  save();  // what an interrupted stage leaves lies in a run directory
  if (replaces) move_replaced(context, key.name, now, replaced);

  reset_peak_memory();
  const auto start = std::chrono::steady_clock::now();
  json provenance = now;
  provenance.update({{"pliant", PLIANT_VERSION}, {"stage", key.name}});
  json summary;
  try {
    summary = body(provenance.dump());
  } catch (...) {
    // An interrupted stage goes on from what it has made.
    const bool goes_on = std::any_of(replaced.moved.begin(), replaced.moved.end(),
                                     [&](const auto& pair) { return fs::exists(path_ / pair.first); }) &&
                         context.interrupted();
    if (!goes_on) put_back(context, key.name, now, replaced);
    throw;
  }
  // What other choices wrote is no result of these; objects keep theirs.
  for (const std::string& output : others)
    if (!output.starts_with("objects/")) fs::remove_all(path_ / output);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  manifest_["begun"].erase(key.name);
  json& record = manifest_["stages"][key.name] = now;
  record.update({{"outputs", key.outputs},
                 {"kept", key.kept},
                 {"summary", summary},
                 {"wall_s", seconds},
                 {"peak_memory_mb", peak_memory_megabytes()},
                 {"threads", omp_get_max_threads()}});
  save();
  context.progress.say(fmt::format("{}: {:.1f} s", key.name, seconds));
  if (context.interrupted())
    throw Error(Failure::kInterrupted, key.name, "", "interrupted after this stage had finished",
                "run the same command to continue after it");
  return summary;
}

}  // namespace pliant
