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

/// Files that something is made from: role -> file or folder.
using InputFiles = std::map<std::string, std::filesystem::path>;

/// Everything that decides the outcome of a stage, and what it writes; see stage_inputs.h.
struct StageKey {
  std::string name;
  nlohmann::json options = nlohmann::json::object();  ///< values that the user may set
  nlohmann::json scene = nlohmann::json::object();    ///< values of the scene
  nlohmann::json found = nlohmann::json::object();    ///< values that earlier stages found
  InputFiles inputs;                                  ///< hashed by contents
  std::vector<std::string> outputs;                   ///< relative to the run directory
  std::vector<std::string> kept;  ///< files and folders that took long or were made by hand: a new result does not
                                  ///< replace them, they are moved aside
};

/// What is recorded of a key: {seed, options, scene, found, inputs (hashes)}.
nlohmann::json record_of(const StageKey& key, uint64_t seed);
/// Erases from such a record paths that do not count: of the scene's video, and of splats that are a single file.
void leave_out_paths(nlohmann::json& record);
/// What differs between two such records, as a sentence; empty when nothing does.
std::string first_difference(const nlohmann::json& before, const nlohmann::json& now);
/// The same of two JSON objects whose entries are called `kind`: "option 'fps' was 30, now 12".
std::string first_difference(const nlohmann::json& before, const nlohmann::json& now, const std::string& kind);

/// Whether a folder is a run directory; that of `reconstruct`, which is a scene as well, is none.
bool is_run_directory(const std::filesystem::path& path);

/// A run directory and its run.json: the scene it belongs to, and per stage its options, input hashes, outputs,
/// summary, wall time and peak memory.  From `create`, or the first writing on, no other process may write to it: that
/// is a usage error.
class RunDirectory {
 public:
  /// Creates `path` if needed; one that nothing is written to goes again.  An existing directory of another kind
  /// (files, but no run.json) is a usage error.
  static RunDirectory create(const std::filesystem::path& path);
  /// Opens an existing run directory; a usage error names what is missing.
  static RunDirectory open(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& relative) const { return path_ / relative; }

  /// Keeps other processes from writing to it, as the first writing does by itself; before files of it are written
  /// outside of a stage.  What a killed program was about to write goes.
  void hold();

  /// The scene this directory was made from: {source, up, metres_per_unit}; a source within the directory is relative
  /// to it.
  const nlohmann::json& scene() const { return manifest_["scene"]; }
  /// Records the scene; one of another source than the recorded one is a usage error unless `overwrite`.
  void set_scene(const nlohmann::json& scene, bool overwrite);

  /// Runs `body` unless the same record and all outputs are there.  Where the record differs, the difference is said,
  /// and what key.kept names is moved aside first, unless context.overwrite.  A `body` that fails, unless it was
  /// interrupted, leaves the previous result as it was; what it had made of the folders moved aside is kept as
  /// NAME.failed, and is there again when the same key is next attempted.  One that was interrupted leaves the previous
  /// result aside; it comes back when the same key then fails, or when another key is attempted.  After one that
  /// succeeds, outputs of other choices are removed, finished or not, but for those of objects.  `body` is given the
  /// provenance for the files that it writes (version, stage and record of the key, no times) and returns the stage's
  /// summary.  Returns the summary, old or new.
  nlohmann::json stage(const Context& context, const StageKey& key,
                       const std::function<nlohmann::json(const std::string& provenance)>& body);

  /// Summary of a finished stage; a usage error says which command to run first.
  const nlohmann::json& summary(const std::string& stage, const std::string& hint) const;
  bool has(const std::string& stage) const;
  /// Forgets that a stage has run, so that it runs again.
  void forget(const std::string& stage);
  /// Moves a folder of results, and what run.json says of it.  What is at `after` already is kept beside it under a
  /// name of its own, which is returned; empty = nothing was there.  Nothing happens when there is no folder `before`.
  std::string move_folder(const std::string& before, const std::string& after);
  /// The record of the result of a stage that is there, or that was being made when the stage was interrupted; null
  /// when there is none.
  nlohmann::json last_record(const std::string& stage) const;
  /// What run.json keeps besides stages: "edits" made by hand since `segment` ran, "sheet_prompts".  Null when there is
  /// none.
  nlohmann::json note(const std::string& name) const { return manifest_.value(name, nlohmann::json()); }
  void set_note(const std::string& name, const nlohmann::json& value);  ///< an empty value erases it
  const nlohmann::json& manifest() const { return manifest_; }
  /// Moves files and folders aside, under names with one number behind them: fit.1, material.h5.1.  Returns the new
  /// names; none for what is not there.
  std::map<std::string, std::string> move_aside(const std::vector<std::string>& names);

 private:
  /// A result that a stage is replacing.
  struct Replaced {
    nlohmann::json record;                                           ///< null where there was none
    std::map<std::string, std::string> moved;                        ///< what is moved aside, name -> name since
    std::map<std::string, std::filesystem::file_time_type> written;  ///< its outputs, and when they were written
  };

  explicit RunDirectory(std::filesystem::path path);
  /// What other choices than `key` have written of this stage, also where the program was killed.
  std::vector<std::string> outputs_of_others(const StageKey& key) const;
  /// The names that move_aside would give.
  std::map<std::string, std::string> names_aside(const std::vector<std::string>& names) const;
  /// What the stage is to replace, which is recorded as replaced before anything is moved: move_replaced does that.
  Replaced begin_replacing(const Context& context, const StageKey& key);
  /// Moves aside what begin_replacing named, and an earlier attempt with the same record to its place.
  void move_replaced(const Context& context, const std::string& stage, const nlohmann::json& now,
                     const Replaced& replaced);
  /// Moves folders that put_back kept of an attempt with the same record to their places.
  void take_up_failed(const Context& context, const std::string& stage, const nlohmann::json& now,
                      const Replaced& replaced);
  /// What an attempt that was interrupted or killed was replacing, where `now` goes on with that attempt.  One that
  /// does not go on with it puts the previous result back first, and so does one that finds nothing of it moved.
  Replaced still_replaced(const Context& context, const std::string& stage, const nlohmann::json& now);
  /// As run.json keeps it: {record, moved: [[name, name since]], written: [[output, time]]}.
  static nlohmann::json to_json(const Replaced& replaced);
  /// Moves back what move_replaced moved, and records it again; folders that the attempt with this record has made
  /// are kept as NAME.failed.
  void put_back(const Context& context, const std::string& stage, const nlohmann::json& attempt,
                const Replaced& replaced);
  void read();
  void save() const;

  std::filesystem::path path_;
  nlohmann::json manifest_;
  std::shared_ptr<const FileLock> lock_;  ///< held since it was first written to
  std::shared_ptr<const void> made_;      ///< by `create`: with the last copy goes a folder that nothing came into
};

/// SHA-256 over a file, or over names and contents of all files of a folder in order.
std::string hash_of_input(const std::filesystem::path& path);

}  // namespace pliant
