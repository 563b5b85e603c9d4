#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/run/progress.h"
#include "gaussians/io/files/file_lock.h"

namespace pliant {

/// Everything that decides the outcome of a stage, and what it writes.
struct StageKey {
  std::string name;
  nlohmann::json options;                               ///< values that the user may set
  std::map<std::string, std::filesystem::path> inputs;  ///< role -> file or folder, hashed by contents
  std::vector<std::string> outputs;                     ///< relative to the run directory
};

/// A run directory and its run.json: the scene it belongs to, and per stage its options, input hashes, outputs,
/// summary, wall time and peak memory.  From `create`, or the first writing on, no other process may write to it: that
/// is a usage error.
class RunDirectory {
 public:
  /// Creates `path` if needed.  An existing directory of another kind (files, but no run.json) is a usage error.
  static RunDirectory create(const std::filesystem::path& path);
  /// Opens an existing run directory; a usage error names what is missing.
  static RunDirectory open(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& relative) const { return path_ / relative; }

  /// The scene this directory was made from: {source, up, metres_per_unit}.
  const nlohmann::json& scene() const { return manifest_["scene"]; }
  /// Records the scene; another scene than the recorded one is a usage error unless `overwrite`.
  void set_scene(const nlohmann::json& scene, bool overwrite);

  /// Runs `body` unless a record with equal options and input hashes and all outputs exist.  A record that differs is
  /// a usage error that names the difference, unless context.overwrite.  `body` returns the stage's summary.
  /// Returns the summary, old or new.
  nlohmann::json stage(const Context& context, const StageKey& key, const std::function<nlohmann::json()>& body);

  /// Summary of a finished stage; a usage error says which command to run first.
  const nlohmann::json& summary(const std::string& stage, const std::string& hint) const;
  bool has(const std::string& stage) const;
  /// Forgets that a stage has run, so that it runs again.
  void forget(const std::string& stage);
  /// Moves a folder of results, and what run.json says of it.  What is at `after` already is kept beside it under a
  /// name of its own, which is returned; empty = nothing was there.  Nothing happens when there is no folder `before`.
  std::string move_folder(const std::string& before, const std::string& after);
  /// What run.json keeps besides stages: "edits" made by hand since `segment` ran, "sheet_prompts".  Null when there is
  /// none.
  nlohmann::json note(const std::string& name) const { return manifest_.value(name, nlohmann::json()); }
  void set_note(const std::string& name, const nlohmann::json& value);  ///< an empty value erases it
  const nlohmann::json& manifest() const { return manifest_; }
  /// Provenance for files written by `stage`: version, seed, options and input hashes, no times.
  std::string provenance(const Context& context, const StageKey& key) const;

 private:
  explicit RunDirectory(std::filesystem::path path);
  void read();
  void save() const;
  void hold();  // before anything is changed

  std::filesystem::path path_;
  nlohmann::json manifest_;
  std::shared_ptr<const FileLock> lock_;  ///< held since it was first written to
};

/// First difference between two JSON objects, as a sentence such as "option 'fps' was 30, now 12"; empty when they
/// agree.
std::string first_difference(const nlohmann::json& before, const nlohmann::json& now, const std::string& kind);

/// SHA-256 over a file, or over names and contents of all files of a folder in order.
std::string hash_of_input(const std::filesystem::path& path);

}  // namespace pliant
