#include "app/commands/stage_options.h"
#include "app/seed/seed_stage.h"
#include "app/segment/label_choice.h"
#include "app/segment/repair_stage.h"
#include "app/simulate/export_stage.h"
#include "app/simulate/simulate_stage.h"
#include "gaussians/base/error.h"

namespace pliant {

std::string given_option(const CLI::App& command, const OptionTable& table, const std::set<std::string>& names) {
  for (const Option& option : table.options) {
    if (!names.empty() && !names.count(option.name)) continue;
    const CLI::Option* added = command.get_option_no_throw("--" + table.stage + "." + option.name);
    if (added && added->count() > 0) return "--" + added->get_lnames().front();
  }
  return "";
}

void refuse_given(const CLI::App& command, const OptionTable& table, const Unused& unused) {
  if (const std::string option = given_option(command, table, unused.names); !option.empty())
    throw usage_error(command.get_name(), option, unused.why, unused.advice);
}

void check_given(const CLI::App& command, ReconstructStage& stage) {
  if (stage.train.seconds > 0)
    refuse_given(command, options_of(stage),
                 {"does nothing with --time-limit", "leave one of them out", {"iterations"}});
}

void check_given(const CLI::App& command, SegmentStage& stage) {
  const OptionTable table = options_of(stage);
  const bool lines = !stage.clicks.empty() || !stage.strokes.empty();
  const bool selects = lines || !stage.boxes.empty() || !stage.aabb.empty() || !stage.sphere.empty();
  const std::set<std::string> of_masks = {"masks", "mask-zero", "associate"};
  if (selects) refuse_given(command, table, {"does nothing with a selection", "leave one of them out", of_masks});
  if (!stage.physgaussian.empty())
    refuse_given(command, table,
                 {"does nothing with --physgaussian, whose sim_area selects the object", "leave it out", of_masks});
  if (stage.automatic)
    refuse_given(
        command, table,
        {"does nothing with --auto, which needs no masks", "leave one of them out", {"mask-zero", "associate"}});
  if (stage.label.track)
    refuse_given(command, table,
                 {"does nothing with --track, whose IDs hold in all photos", "leave one of them out", {"associate"}});
  if (!lines)
    refuse_given(command, table, {"does nothing without --click or --stroke", "leave it out", {"stroke-width"}});
  if (!stage.label.models.segmenter.empty())
    refuse_given(
        command, table,
        {"does nothing with --segmenter, which draws masks of photos and takes points of strokes, not their width",
         "leave it out",
         {"grow", "aabb", "sphere", "stroke-width"}});
  else if (!lines && stage.boxes.empty())
    refuse_given(command, table, {"does nothing without --box, --click or --stroke", "leave it out", {"grow"}});
  if (labels_photos(stage) && !stage.label.everything)
    refuse_given(command, table,
                 {"does nothing with masks made from the photos: what none of them holds is the object 'rest'",
                  "leave it out",
                  {"mask-zero"}});
  if (stage.joint || !stage.gaussian_grouping.empty())
    refuse_given(
        command, table,
        {"does nothing where the labels are already trained", "leave it out", {"iterations", "no-vote", "associate"}});
  if (!stage.gaussian_grouping.empty())
    refuse_given(command, table,
                 {"does nothing with --gaussian-grouping", "leave one of them out", {"auto", "mask-zero"}});
  if (stage.label.text.find_first_not_of(" .,") == std::string::npos)
    refuse_given(command, table, {"holds no name", "give names separated by commas, or leave it out", {"text"}});
}

void check_given(const CLI::App& command, ExportStage& stage) {
  if (!stage.physgaussian_output.empty())
    refuse_given(command, options_of(stage),
                 {"does nothing with --physgaussian-output", "leave it out", {"every", "object-only"}});
  if (!stage.material.empty())
    refuse_given(command, options_of(stage),
                 {"does nothing with --material", "leave it out", {"every", "object-only", "recorded"}});
}

void check_given(const CLI::App& command, RepairStage& stage) {
  if (stage.models.inpainter.empty())
    refuse_given(command, options_of(stage),
                 {"does nothing without --inpainter", "leave it out", {"trust-torchscript"}});
}

void check_given(const CLI::App& command, SeedStage& stage) {
  if (!stage.fill.physgaussian.empty())
    refuse_given(command, options_of(stage),
                 {"does nothing with --physgaussian, whose grid and pins are used",
                  "leave it out",
                  {"particles", "pin-below", "no-pin-contact"}});
  if (stage.fill.pin_below)
    refuse_given(command, options_of(stage),
                 {"does nothing with --pin-below, which sets what is fixed", "leave it out", {"no-pin-contact"}});
}

void check_given(const CLI::App& command, SimulateStage& stage) {
  const OptionTable table = options_of(stage);
  if (stage.physgaussian.empty()) {
    refuse_given(command, table, {"does nothing without --physgaussian", "leave it out", {"physgaussian-bugs"}});
    if (!stage.interactions.empty())
      refuse_given(command, table, {"does nothing with --interactions", "leave one of them out", {"auto-push"}});
    if (!stage.velocity_file.empty())
      refuse_given(command, table,
                   {"does nothing with --velocity, which starts the motion",
                    "leave one of them out",
                    {"auto-push", "interactions"}});
    if (!stage.gravity)
      refuse_given(command, table, {"does nothing without gravity", "leave one of them out", {"rest-shape"}});
    return;
  }
  std::set<std::string> unused = {
      "interactions", "fps",       "duration", "damping-time",     "auto-push",     "rest-shape", "settle-time",
      "sleep-speed",  "flip-time", "solver",   "contact-friction", "collide-scene", "no-gravity", "no-floor",
      "law",          "young",     "poisson",  "density",          "material",      "velocity",   "no-fit"};
  for (const Option& option : table.options)
    if (option.group == "Constants of the law") unused.insert(option.name);
  refuse_given(command, table,
               {"does nothing with --physgaussian, whose configuration sets it", "set it there", unused});
}

}  // namespace pliant
