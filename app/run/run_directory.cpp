#include "app/run/run_directory.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kLock = ".lock";

/// The number of the process that writes a temporary of write_atomically, .NAME.tmp<digits>.EXTENSION; empty for any
/// other name.
std::string writer_of(const std::string& name) {
  const size_t at = name.rfind(".tmp");
  if (name[0] != '.' || at == std::string::npos || at == 0) return "";
  const size_t begin = at + 4, end = std::min(name.find_first_not_of("0123456789", begin), name.size());
  return end == name.size() || name[end] == '.' ? name.substr(begin, end - begin) : "";
}

bool is_temporary(const std::string& name) { return !writer_of(name).empty(); }

/// Whether the process that writes a temporary is another one that lives: `view` keeps recordings in a run directory
/// that it does not hold.
bool is_being_written(const std::string& name) {
  const std::string writer = writer_of(name);
  pid_t process = 0;
  std::from_chars(writer.data(), writer.data() + writer.size(), process);
  return process > 0 && process != ::getpid() && (::kill(process, 0) == 0 || errno == EPERM);
}

/// Removes what a killed program was about to write into a run directory: it is nobody's.
void remove_temporaries(const fs::path& run) {
  std::vector<fs::path> folders = {run, run / "fit", run / "recordings"}, left;
  std::error_code none;
  for (const auto& object : fs::directory_iterator(run / "objects", none)) folders.push_back(object.path());
  for (const fs::path& folder : folders)
    for (const auto& entry : fs::directory_iterator(folder, none)) {
      const std::string name = entry.path().filename().string();
      if (is_temporary(name) && !is_being_written(name)) left.push_back(entry.path());
    }
  for (const fs::path& file : left) fs::remove(file, none);
}

/// Whether a folder holds only what a program leaves that was killed before it recorded anything.
bool holds_nothing_recorded(const fs::path& folder) {
  return std::all_of(fs::directory_iterator(folder), fs::directory_iterator(), [](const fs::directory_entry& entry) {
    const std::string name = entry.path().filename().string();
    return name == kLock || is_temporary(name);
  });
}

/// Whether a name that a record gives is that of something within the run directory.
bool is_inside(const json& name) {
  if (!name.is_string()) return false;
  const fs::path path = fs::path(name.get<std::string>()).lexically_normal();
  return path.is_relative() && !path.empty() && *path.begin() != ".." && *path.begin() != ".";
}

bool are_inside(const json& names) { return std::all_of(names.begin(), names.end(), is_inside); }

/// The field for which the record of a finished stage is of no use, or empty.
std::string unusable_field(const json& record) {
  for (const char* field : {"options", "scene", "found", "inputs", "outputs", "summary"})
    if (!record.is_object() || !record.contains(field)) return field;
  for (const char* field : {"outputs", "kept"})
    if (!are_inside(record.value(field, json::array()))) return field;
  const json& summary = record["summary"];
  return summary.is_object() && summary.contains("folder") && !is_inside(summary["folder"]) ? "summary.folder" : "";
}

/// The field for which what an unfinished stage was replacing is of no use, or empty.
std::string unusable_replaced(const json& replaced) {
  if (!replaced.is_object()) return "replaced";
  if (const std::string field = unusable_field(replaced.value("record", json())); !field.empty())
    return "replaced.record." + field;
  const auto is_pair = [](const json& pair) { return pair.is_array() && pair.size() == 2 && is_inside(pair[0]); };
  const json moved = replaced.value("moved", json()), written = replaced.value("written", json());
  const auto is_move = [&](const json& pair) { return is_pair(pair) && is_inside(pair[1]); };
  if (!moved.is_array() || !std::all_of(moved.begin(), moved.end(), is_move)) return "replaced.moved";
  const auto is_time = [&](const json& pair) { return is_pair(pair) && pair[1].is_number_integer(); };
  return written.is_array() && std::all_of(written.begin(), written.end(), is_time) ? "" : "replaced.written";
}

/// Texts in `value` that name the folder `before` or something in it name `after` instead.
void rename_paths(const std::string& before, const std::string& after, json& value) {
  if (value.is_structured())
    for (json& element : value) rename_paths(before, after, element);
  if (!value.is_string()) return;
  const std::string text = value;
  if (text == before || text.starts_with(before + "/")) value = after + text.substr(before.size());
}

}  // namespace

RunDirectory::RunDirectory(fs::path path) : path_(std::move(path)) { read(); }

void RunDirectory::read() {
  if (!fs::exists(path_ / "run.json")) {
    manifest_ = {{"pliant", PLIANT_VERSION}, {"scene", nullptr}, {"stages", json::object()}};
    return;
  }
  const std::string file = (path_ / "run.json").string(), advice = "restore the file, or give another --out";
  json read = json::parse(read_text(path_ / "run.json"), nullptr, false);
  if (!read.is_object() || !read.contains("scene") || !read.contains("stages") || !read["stages"].is_object())
    throw input_error(file, "stages", "is not a record of a run", advice);
  for (const auto& [stage, record] : read["stages"].items())
    if (const std::string field = unusable_field(record); !field.empty())
      throw input_error(file, "stages." + stage + "." + field, "is missing or leads out of the run directory", advice);
  const json begun = read.value("begun", json::object());
  for (const auto& [stage, record] : begun.items()) {
    if (!record.is_object() || !are_inside(record.value("outputs", json::array())))
      throw input_error(file, "begun." + stage + ".outputs", "leads out of the run directory", advice);
    if (!record.contains("replaced")) continue;
    if (const std::string field = unusable_replaced(record["replaced"]); !field.empty())
      throw input_error(file, "begun." + stage + "." + field, "is missing or leads out of the run directory", advice);
  }
  for (const char* group : {"stages", "begun"})
    if (read.contains(group))
      for (json& record : read[group]) {
        leave_out_paths(record);
        if (record.contains("replaced")) leave_out_paths(record["replaced"]["record"]);
      }
  manifest_ = std::move(read);
}

void RunDirectory::hold() {
  if (lock_) return;
  lock_ = std::make_shared<const FileLock>(path_ / kLock, path_.string());
  remove_temporaries(path_);
  // Another program may have written to it since it was read.
  const fs::path record = path_ / "run.json";
  if (fs::exists(record) && json::parse(read_text(record), nullptr, false) != manifest_) read();
}

RunDirectory RunDirectory::create(const fs::path& path) {
  if (fs::exists(path) && !fs::is_directory(path))
    throw usage_error("--out", path.string(), "is a file", "give a folder");
  bool empty = true;
  if (fs::exists(path)) {
    for (const auto& entry : fs::directory_iterator(path)) {
      const std::string name = entry.path().filename().string();
      // A `run` that was killed before or while it trained its scene has made nothing else.
      const bool trained = name == "scene" && entry.is_directory() &&
                           (fs::exists(entry.path() / "run.json") || holds_nothing_recorded(entry.path()));
      empty = empty && (is_temporary(name) || name == kLock || trained);
    }
  }
  if (!empty && !fs::exists(path / "run.json"))
    throw usage_error("--out", path.string(), "contains files but no run.json", "give a new or an empty folder");
  std::error_code failed;
  const bool made = fs::create_directories(path, failed);
  if (failed) throw usage_error("--out", path.string(), failed.message(), "give a writable folder");
  RunDirectory run(path);
  if (made)
    run.made_ = std::shared_ptr<const void>(nullptr, [path](const void*) {
      std::error_code kept;
      if (fs::exists(path / "run.json", kept)) return;
      fs::remove(path / kLock, kept);
      fs::remove(path, kept);  // nothing happens where there are other files
    });
  run.hold();
  return run;
}

bool is_run_directory(const fs::path& path) {
  return fs::is_regular_file(path / "run.json") && !fs::exists(path / "scene.json");
}

RunDirectory RunDirectory::open(const fs::path& path) {
  if (!fs::exists(path / "run.json"))
    throw usage_error(path.string(), "", "is not a run directory: it has no run.json",
                      "make one with `pliant segment SCENE --out DIR` or `pliant run SCENE --out DIR`");
  return RunDirectory(path);
}

void RunDirectory::save() const { write_text(path_ / "run.json", manifest_.dump(2) + "\n"); }

void RunDirectory::set_scene(const json& scene, bool overwrite) {
  hold();
  const auto place = [&](const json& record) { return path_ / record["source"].get<std::string>(); };
  const json& before = manifest_["scene"];
  if (!before.is_null() && !overwrite && place(before) != place(scene))
    throw usage_error(path_.string(), "", "is a run of " + place(before).string() + ", not of " + place(scene).string(),
                      "give another --out, or --overwrite to start over");
  manifest_["scene"] = scene;
  save();
}

bool RunDirectory::has(const std::string& stage) const { return manifest_["stages"].contains(stage); }

void RunDirectory::forget(const std::string& stage) {
  hold();
  manifest_["stages"].erase(stage);
  save();
}

json RunDirectory::last_record(const std::string& stage) const {
  for (const char* group : {"begun", "stages"})
    if (const json records = manifest_.value(group, json::object()); records.contains(stage)) return records[stage];
  return nullptr;
}

std::string RunDirectory::move_folder(const std::string& before, const std::string& after) {
  if (before == after || !fs::is_directory(path_ / before)) return "";
  hold();
  const std::map<std::string, std::string> moved = move_aside({after});
  const std::string aside = moved.empty() ? "" : moved.at(after);
  fs::rename(path_ / before, path_ / after);
  for (const char* group : {"stages", "begun"})
    if (manifest_.contains(group)) rename_paths(before, after, manifest_[group]);
  save();
  return aside;
}

std::map<std::string, std::string> RunDirectory::names_aside(const std::vector<std::string>& names) const {
  const auto numbered = [](const std::string& name, int k) { return fmt::format("{}.{}", name, k); };
  int k = 1;
  const auto taken = [&](const std::string& name) { return fs::exists(path_ / numbered(name, k)); };
  while (std::any_of(names.begin(), names.end(), taken)) ++k;
  std::map<std::string, std::string> aside;
  for (const std::string& name : names)
    if (fs::exists(path_ / name)) aside[name] = numbered(name, k);
  return aside;
}

std::map<std::string, std::string> RunDirectory::move_aside(const std::vector<std::string>& names) {
  hold();
  const std::map<std::string, std::string> moved = names_aside(names);
  for (const auto& [name, aside] : moved) fs::rename(path_ / name, path_ / aside);
  return moved;
}

void RunDirectory::set_note(const std::string& name, const json& value) {
  hold();
  if (value.empty() && !manifest_.contains(name)) return;
  if (value.empty())
    manifest_.erase(name);
  else
    manifest_[name] = value;
  save();
}

const json& RunDirectory::summary(const std::string& stage, const std::string& hint) const {
  if (!has(stage)) throw usage_error(path_.string(), "", "stage '" + stage + "' has not run here", hint);
  return manifest_["stages"][stage]["summary"];
}

}  // namespace pliant
