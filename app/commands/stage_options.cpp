#include "app/commands/stage_options.h"

#include <fmt/format.h>

#include "app/reconstruct/photo_set.h"
#include "app/reconstruct/trained_scene.h"
#include "app/segment/label_choice.h"
#include "app/segment/object_source.h"
#include "gaussians/base/error.h"
#include "gaussians/io/scene/up_direction.h"
#include "gaussians/io/splats/splats.h"

namespace pliant {
namespace {

Eigen::Vector3d parse_up(const std::string& text) {
  if (const auto axis = axis_of_name(text)) return *axis;
  if (text.find(',') == std::string::npos)
    throw usage_error("--up", text, "is neither three numbers nor an axis", "give x, y, z, -x, -y, -z or X,Y,Z");
  const std::vector<double> v = parse_numbers("--up", text, 3);
  const Eigen::Vector3d direction(v[0], v[1], v[2]);
  if (!(direction.norm() > 0)) throw usage_error("--up", "", "has no length", "give a direction such as 0,0,1");
  return direction.normalized();
}

}  // namespace

LoadOptions SceneOptions::load_options() const {
  LoadOptions options;
  if (!up.empty()) options.up = parse_up(up);
  if (metres_per_unit && object_height)
    throw usage_error("--object-height", fmt::format("{:g}", *object_height),
                      "was given together with --metres-per-unit", "leave one of them out: either sets the scale");
  options.metres_per_unit = metres_per_unit;
  options.object_height = object_height.value_or(0);
  options.orbit_views = orbit_views;
  options.level = level;
  options.antialiased = antialiased;
  return options;
}

Option level_option(std::optional<int>& level) {
  return {.name = "level",
          .field = LevelField{&level},
          .help = "Level of detail of a streamed SOG, 0 = finest, or 'all' (default: the finest available)",
          .value = "N"};
}

OptionTable options_of(SceneOptions& options) {
  return {"scene",
          {{.name = "up",
            .field = &options.up,
            .help = "Up direction, or an axis such as -y (default: estimated, printed)",
            .value = "x,y,z"},
           {.name = "metres-per-unit",
            .field = &options.metres_per_unit,
            .help = "Length of one scene unit [m] (default: scene.json's, else 1)",
            .positive = true},
           {.name = "object-height",
            .field = &options.object_height,
            .help = "Height of the object along up [m], which sets the scene unit instead",
            .positive = true},
           {.name = "orbit-views",
            .field = &options.orbit_views,
            .help = "Orbit views if the scene has no cameras (default 24)",
            .low = 4,
            .high = 1000},
           level_option(options.level),
           {.name = "antialiased",
            .field = &options.antialiased,
            .help = "The splats were trained with mip-splatting, which their file does not say"}}};
}

void add_scene_options(CLI::App& command, Program& program, SceneOptions& options, const Spelling& spelling,
                       const std::string& scene) {
  command.add_option("SCENE", options.source, scene)->required();
  add_options(command, program, options_of(options), spelling);
}

Scene attach_or_reconstruct(const Context& context, const CLI::App& command, RunDirectory& run,
                            const SceneOptions& options, ReconstructStage stage, const SegmentStage& segment) {
  std::string source = options.source;
  LoadOptions load = options.load_options();  // its errors come before the training
  const bool untrained = lacks_splats(source);
  check_networks(segment);
  check_given(command, stage);
  if (!untrained && !segment.joint)
    refuse_given(command, options_of(stage), {"does nothing: the scene is already trained", "leave it out", {}});
  stage.joint = segment.joint;
  if (segment.joint && segment.hold_out) {
    refuse_given(
        command, options_of(stage),
        {"does nothing with --hold-out, which is every 8th photo", "leave one of them out", {"hold-out-every"}});
    stage.photo.hold_out_every = PhotoOptions().hold_out_every;
  }
  stage.masks = segment.masks;
  stage.mask_zero = segment.mask_zero;
  if (segment.joint && !untrained) {
    const Scene trained = load_scene(source, load);
    refuse_unused(load, trained);
    stage.splats = trained.report.files;
    stage.level = load.level;
    if (!trained.settings.background_file.empty() && stage.background.empty()) {
      const auto color = trained.settings.background_color();
      stage.background = {color[0], color[1], color[2]};
    }
  }
  if (untrained && load.antialiased)
    throw usage_error("--antialiased", "", "does nothing: the scene has no splats yet",
                      "train them so with --reconstruct.antialiased");
  if (untrained && load.level)
    throw usage_error("--level", *load.level == kAllLevels ? "all" : std::to_string(*load.level),
                      "does nothing: the scene has no splats yet", "leave it out");
  stage.train.render.antialiased |= load.antialiased;
  if (!stage.splats.empty())
    refuse_given(command, options_of(stage),
                 {"does nothing when training continues from a trained scene",
                  "leave it out",
                  {"strategy", "init", "max-gaussians"}});
  if (untrained && options.orbit_views)
    throw usage_error("--orbit-views", std::to_string(*options.orbit_views), "does nothing: the scene has cameras",
                      "leave it out");
  if (segment.joint) {
    Scene planned;  // what excludes --joint is said before the training
    check_object_options(source_of(planned, segment), segment);
  }
  if (untrained || segment.joint) {
    refuse_own_source(run / "scene", find_photo_set(source, stage.photos, stage.splats), stage);
    RunDirectory reconstruction = RunDirectory::create(run / "scene");
    run_reconstruct(context, reconstruction, source, stage);
    source = reconstruction.path();
    load.level.reset();  // what was trained has one level
  }
  return attach_scene(context, run, source, load);
}

std::string default_out(const std::string& source, const std::string& ending) {
  const std::filesystem::path path = place_of_scene(source);
  const std::string name = std::filesystem::is_directory(path) ? path.filename() : path.stem();
  return name + "_" + ending;
}

}  // namespace pliant
