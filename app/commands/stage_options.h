#pragma once

#include <memory>

#include "app/commands/command.h"
#include "app/reconstruct/reconstruct_stage.h"
#include "app/run/attach_scene.h"
#include "app/segment/extract_stage.h"
#include "app/segment/repair_stage.h"
#include "app/segment/segment_stage.h"
#include "app/simulate/render_stage.h"
#include "app/simulate/seed_stage.h"
#include "app/simulate/simulate_stage.h"

namespace pliant {

struct FitStage;

/// The scene argument and how to read it; shared by every command that starts from a scene.
struct SceneOptions {
  std::string source;
  std::vector<double> up;
  double metres_per_unit = 0;
  int orbit_views = 24;
  std::optional<int> level;

  LoadOptions load_options() const;
};
void add_scene_options(CLI::App& command, SceneOptions& options);

/// The scene of `run` and `segment`: a source without Gaussians, or with
/// segment.joint, is first trained into `scene` of the run directory.
Scene attach_or_reconstruct(const Context& context, RunDirectory& run, const SceneOptions& options,
                            ReconstructStage stage, const SegmentStage& segment);
/// --level N of a streamed SOG, or `all`.
void add_level(CLI::App& command, std::optional<int>& level);

/// Exactly `count` numbers separated by commas; a CLI::ValidationError names the option and the bad word.
std::vector<double> parse_numbers(const std::string& option, const std::string& text, size_t count);

/// A count such as 5000, 200k or 1.5M, or a time such as 90, 90s, 10m or 1h in seconds; a CLI::ValidationError names
/// the option and the value.
size_t parse_count(const std::string& option, const std::string& text);
double parse_duration(const std::string& option, const std::string& text);

// Options of one stage, shared by its own command and by `run`.
void add_reconstruct_options(CLI::App& command, ReconstructStage& stage, const std::string& hold_out = "--hold-out");
void add_segment_options(CLI::App& command, SegmentStage& stage);
void add_label_options(CLI::App& command, LabelStage& stage);
// Slots of networks: --detector, --tagger, --segmenter, --tracker and --vocabulary; --inpainter; --trust-torchscript of
// one or several choices.  A command has those that it uses.
void add_labelling_networks(CLI::App& command, ModelChoice& models);
void add_inpainter(CLI::App& command, ModelChoice& models);
void add_trust(CLI::App& command, std::vector<ModelChoice*> choices);
void add_extract_options(CLI::App& command, ExtractStage& stage);
void add_repair_options(CLI::App& command, RepairStage& stage);
void add_seed_options(CLI::App& command, SeedStage& stage);
void add_material_values(CLI::App& command, MaterialValues& material);
void add_fit_options(CLI::App& command, FitStage& stage, const std::string& prefix = "");
void add_simulate_options(CLI::App& command, SimulateStage& stage);
void add_render_options(CLI::App& command, RenderStage& stage);
/// --physgaussian CONFIG of one or several stages.
void add_physgaussian(CLI::App& command, std::vector<std::string*> stages);

/// A command that works on an existing run directory: `pliant NAME DIR [options]`.
template <class Stage>
void add_stage_command(CLI::App& app, Program& program, const std::string& name, const std::string& description,
                       void (*add_options)(CLI::App&, Stage&),
                       nlohmann::json (*run_stage)(const Context&, RunDirectory&, const Scene&, const Stage&)) {
  CLI::App* command = app.add_subcommand(name, description);
  auto directory = std::make_shared<std::string>();
  auto stage = std::make_shared<Stage>();
  command->add_option("DIR", *directory, "Run directory")->required();
  if (add_options) add_options(*command, *stage);
  add_overwrite(*command, program);
  add_common(*command, program);
  command->callback([=, &program] {
    program.action = [=](Context& context) {
      RunDirectory run = RunDirectory::open(*directory);
      const Scene scene = load_run_scene(run);
      return run_stage(context, run, scene, *stage);
    };
  });
}

}  // namespace pliant
