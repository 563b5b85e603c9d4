#pragma once

#include <nlohmann/json.hpp>

#include "app/run/options.h"
#include "app/run/run_directory.h"
#include "app/run/scene_parts.h"

namespace pliant {

/// Everything that a stage reads.  Its key follows from this alone, and the work is done with nothing else, so that
/// what is not recorded cannot count.
template <class Stage>
struct StageInputs {
  Stage options;       ///< what the user chose
  ScenePartSet parts;  ///< of the scene that are here
  Scene scene;
  InputFiles files;
  nlohmann::json found = nlohmann::json::object();  ///< what earlier stages found, by name
  std::vector<std::string> outputs;                 ///< relative to the run directory
  std::vector<std::string> kept;  ///< of these, or folders around them: what is not replaced but moved aside
};

/// Records every option of `table`.
void record_options(const OptionTable& table, StageKey& key);
/// Sets the options of `table` whose values such a record, of StageKey::options, holds.
void take_recorded(const nlohmann::json& options, const OptionTable& table);

template <class Stage>
StageKey key_of(StageInputs<Stage> in) {
  StageKey key;
  const SceneRecord scene = record_of(in.parts, in.scene);
  key.scene = scene.values;
  key.inputs = scene.files;
  for (const auto& [role, file] : in.files) key.inputs[role] = file;
  key.found = in.found;
  key.outputs = in.outputs;
  key.kept = in.kept;
  record_options(options_of(in.options), key);
  return key;
}

/// Runs `work(context, run, in, provenance)`, which returns the stage's summary, unless its result is there already.
template <class Stage, class Work>
nlohmann::json run_stage(const Context& context, RunDirectory& run, const StageInputs<Stage>& in, const Work& work) {
  return run.stage(context, key_of(in),
                   [&](const std::string& provenance) { return work(context, run, in, provenance); });
}

}  // namespace pliant
