#pragma once

#include <memory>

#include "app/commands/option_parser.h"
#include "app/reconstruct/reconstruct_stage.h"
#include "app/run/attach_scene.h"
#include "app/segment/segment_stage.h"

namespace pliant {

struct ExportStage;
struct RepairStage;
struct SeedStage;
struct SimulateStage;

/// The scene argument and how to read it; shared by every command that starts from a scene.
struct SceneOptions {
  std::string source;
  std::string up;  ///< three numbers or the name of an axis; empty = estimated
  std::optional<double> metres_per_unit, object_height;
  std::optional<int> orbit_views, level;
  bool antialiased = false;

  LoadOptions load_options() const;
};
OptionTable options_of(SceneOptions& options);
/// The argument SCENE, with what it may be, and these options.
void add_scene_options(CLI::App& command, Program& program, SceneOptions& options, const Spelling& spelling = {},
                       const std::string& scene = "Splat file, model or scene.json folder, or posed photos");
/// --level N of a streamed SOG, or `all`.
Option level_option(std::optional<int>& level);

/// The scene of `run` and `segment`: a source without Gaussians, or with
/// segment.joint, is first trained into `scene` of the run directory.
/// Options of the reconstruction that `command` was given for a scene which needs none are refused.
Scene attach_or_reconstruct(const Context& context, const CLI::App& command, RunDirectory& run,
                            const SceneOptions& options, ReconstructStage stage, const SegmentStage& segment);

/// Where results of a source go when nobody says: NAME_run, or NAME_scene, in the current folder.
std::string default_out(const std::string& source, const std::string& ending);

/// The first option of these, or of all in the table where there are no names, that the user gave, as typed; empty =
/// none.
std::string given_option(const CLI::App& command, const OptionTable& table, const std::set<std::string>& names = {});

/// Options that do nothing in a certain case.
struct Unused {
  std::string why;              ///< "does nothing ..."
  std::string advice;           ///< what to do instead
  std::set<std::string> names;  ///< of a table; empty = all of them
};
/// Throws Error{kUsage} for the first of these that the user gave.
void refuse_given(const CLI::App& command, const OptionTable& table, const Unused& unused);

// What would be ignored is refused, by the command line alone.
void check_given(const CLI::App& command, ReconstructStage& stage);
void check_given(const CLI::App& command, SegmentStage& stage);
void check_given(const CLI::App& command, RepairStage& stage);
void check_given(const CLI::App& command, SeedStage& stage);
void check_given(const CLI::App& command, SimulateStage& stage);
void check_given(const CLI::App& command, ExportStage& stage);

/// A command that works on an existing run directory: `pliant NAME DIR [options]`.  `overwrite` says what --overwrite
/// does; empty: the command has none.
template <class Stage>
void add_stage_command(CLI::App& app, Program& program, const std::string& name, const std::string& description,
                       nlohmann::json (*run_stage)(const Context&, RunDirectory&, const Scene&, const Stage&),
                       void (*check)(const CLI::App&, Stage&) = nullptr, const std::string& overwrite = "") {
  CLI::App* command = app.add_subcommand(name, description);
  auto directory = std::make_shared<std::string>();
  auto stage = std::make_shared<Stage>();
  command->add_option("DIR", *directory, "Run directory")->required();
  add_options(*command, program, options_of(*stage));
  if (!overwrite.empty()) add_overwrite(*command, program, overwrite);
  add_common(*command, program);
  command->callback([=, &program] {
    program.action = [=](Context& context) {
      if (check) check(*command, *stage);
      RunDirectory run = RunDirectory::open(*directory);
      const Scene scene = load_run_scene(run);
      if (name != "extract") warn_of_selection(context, run);
      return run_stage(context, run, scene, *stage);
    };
  });
}

}  // namespace pliant
