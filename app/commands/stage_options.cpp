#include "app/commands/stage_options.h"

#include <algorithm>

#include "app/reconstruct/photo_set.h"
#include "app/segment/label_choice.h"
#include "gaussians/base/error.h"
#include "gaussians/io/splats/splats.h"

namespace pliant {

LoadOptions SceneOptions::load_options() const {
  LoadOptions options;
  if (!up.empty()) {
    const Eigen::Vector3d direction(up[0], up[1], up[2]);
    if (!(direction.norm() > 0)) throw usage_error("--up", "", "has no length", "give a direction such as 0 0 1");
    options.up = direction.normalized();
  }
  if (metres_per_unit != 0) options.metres_per_unit = metres_per_unit;
  options.orbit_views = orbit_views;
  options.level = level;
  return options;
}

void add_scene_options(CLI::App& command, SceneOptions& options) {
  command
      .add_option("SCENE", options.source,
                  "Splat file, 3DGS model folder, folder with a scene.json, or photos with cameras")
      ->required();
  add_level(command, options.level);
  command.add_option("--up", options.up, "Up direction x y z (default: estimated, and printed)")
      ->expected(3)
      ->delimiter(',');
  command.add_option("--metres-per-unit", options.metres_per_unit, "Length of one scene unit [m]")
      ->check(CLI::PositiveNumber);
  command.add_option("--orbit-views", options.orbit_views, "Views of the orbit when the scene has no cameras")
      ->check(CLI::Range(4, 1000))
      ->capture_default_str();
}

Scene attach_or_reconstruct(const Context& context, RunDirectory& run, const SceneOptions& options,
                            ReconstructStage stage, const SegmentStage& segment) {
  std::string source = options.source;
  const bool untrained = lacks_splats(source);
  check_networks(segment);
  stage.joint = segment.joint;
  stage.masks = segment.masks;
  if (segment.joint && !untrained) stage.splats = load_scene(source, options.load_options()).settings.splats.string();
  if (untrained || segment.joint) {
    RunDirectory reconstruction = RunDirectory::create(run / "scene");
    run_reconstruct(context, reconstruction, source, stage);
    source = reconstruction.path();
  }
  return attach_scene(context, run, source, options.load_options());
}

void add_level(CLI::App& command, std::optional<int>& level) {
  command.add_option_function<std::string>(
      "--level",
      [&level](const std::string& text) {
        level = text == "all" ? kAllLevels : static_cast<int>(parse_numbers("--level", text, 1)[0]);
        if (*level < 0 && text != "all") throw CLI::ValidationError("--level", "'" + text + "' is negative");
      },
      "Level of detail of a streamed SOG, 0 = finest, or 'all' (default: the finest that is there)");
}

void add_reconstruct_options(CLI::App& command, ReconstructStage& stage, const std::string& hold_out) {
  TrainOptions& train = stage.train;
  command
      .add_option(hold_out, stage.photo.hold_out_every, "Measure on every Nth photo and never train on it; 0 = none")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  CLI::Option* iterations =
      command
          .add_option("--iterations", train.iterations, "Photos that a reconstruction is shown, one after the other")
          ->check(CLI::Range(1, 10000000))
          ->capture_default_str();
  command
      .add_option_function<std::string>(
          "--time", [&train](const std::string& text) { train.seconds = parse_duration("--time", text); },
          "Wall time of the reconstruction instead of iterations: 90s, 10m, 1h")
      ->excludes(iterations);
  command.add_option_function<std::string>(
      "--gaussians", [&train](const std::string& text) { train.most_gaussians = parse_count("--gaussians", text); },
      "Most Gaussians: 50000, 200k, 1.5M (default: one for 100 pixels of the photos, 20k to 150k)");
  const std::map<std::string, Densification> strategies = {
      {"mcmc", Densification::kMcmc}, {"classic", Densification::kClassic}, {"none", Densification::kNone}};
  command
      .add_option_function<std::string>(
          "--strategy", [&train, strategies](const std::string& name) { train.densification = strategies.at(name); },
          "How Gaussians are added and taken away (default mcmc)")
      ->check(CLI::IsMember({"mcmc", "classic", "none"}));
  command
      .add_option("--longest-side", stage.photo.longest_side, "Larger photos are scaled down to this [px]; 0 = never")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command.add_option("--sh-degree", train.sh_degree, "Degree of the spherical harmonics")
      ->check(CLI::Range(0, 3))
      ->capture_default_str();
  command.add_flag("--exposure", train.exposure, "Train exposure and white balance of each photo");
  command
      .add_option("--start", stage.start,
                  "Where the Gaussians come from; auto: the first of points, triangulate, random that is to be had")
      ->check(CLI::IsMember({"auto", "points", "triangulate", "random"}))
      ->capture_default_str();
  command
      .add_option("--poses", stage.poses, "How the file means its poses; auto: as given, unless the photos contradict")
      ->check(CLI::IsMember({"auto", "as-given", "inverse", "flipped", "inverse-flipped", "turned"}))
      ->capture_default_str();
  command.add_option("--photos", stage.photos, "Folder of the photos, when they are not beside the cameras");
  command
      .add_option("--checkpoint-every", stage.checkpoint_every,
                  "Iterations between two checkpoints (default: about a minute)")
      ->check(CLI::PositiveNumber);
  command.add_option_function<std::string>(
      "--background",
      [&train](const std::string& text) {
        const std::vector<double> color = parse_numbers("--background", text, 3);
        for (const double value : color)
          if (value < 0 || value > 1) throw CLI::ValidationError("--background", "'" + text + "' is not in 0..1");
        train.render.background = Vec3d(color[0], color[1], color[2]).cast<float>();
        train.changing_backdrop = false;
      },
      "Colour r,g,b in 0..1 behind the scene and behind photos with alpha (default: black; behind photos with alpha "
      "another colour each time)");
  command.add_flag("--antialiased", train.render.antialiased, "Opacity compensation (mip-splatting)");
}

void add_segment_options(CLI::App& command, SegmentStage& stage) {
  command.add_option("--masks", stage.masks, "Folder of id pictures named like the photos (default: the scene file's)");
  command.add_flag(
      "--auto", stage.automatic,
      "Find free-standing objects from the Gaussians alone, without masks and prompts (default when there are none)");
  command
      .add_option("--associate", stage.associate,
                  "Ids of the masks hold only inside a view and are matched by 3D overlap: "
                  "auto (when they disagree between views), always, never")
      ->check(CLI::IsMember({"auto", "always", "never"}))
      ->capture_default_str();
  command.add_option_function<std::string>(
      "--aabb", [&stage](const std::string& text) { stage.aabb = parse_numbers("--aabb", text, 6); },
      "Select what lies in a box x0,y0,z0,x1,y1,z1 [scene units]");
  command.add_option_function<std::string>(
      "--sphere", [&stage](const std::string& text) { stage.sphere = parse_numbers("--sphere", text, 4); },
      "Select what lies in a sphere x,y,z,r [scene units]");
  // A value may hold commas and must not be split; every option can be given more than once.
  const auto texts = [&command](const std::string& name, std::vector<std::string>& values,
                                const std::string& description) {
    command.add_option(name, values, description)
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->type_name("TEXT");
  };
  texts("--box", stage.boxes,
        "The object lies in this rectangle: V,x0,y0,x1,y1 (V: camera, pixels of its picture); one to three views");
  texts("--click", stage.clicks, "What is at this pixel belongs to the object: V,x,y; can be repeated");
  texts("--stroke", stage.strokes,
        "What is under this line belongs to the object (fg) or not (bg): fg|bg,V,x0,y0,x1,y1,...; can be repeated");
  command.add_option("--stroke-width", stage.stroke_width, "Width of strokes and clicks [px]")
      ->check(CLI::Range(1.0, 500.0))
      ->capture_default_str();
  command.add_option("--segment-iterations", stage.iterations, "Steps of the semantic optimisation; 0 = vote only")
      ->check(CLI::NonNegativeNumber);
  command.add_option("--gaussian-grouping", stage.gaussian_grouping,
                     "Folder with the classifier.pth of a Gaussian Grouping model: its objects are taken");
  command
      .add_option_function<std::string>(
          "--zero", [&stage](const std::string&) { stage.zero_is_background = true; },
          "What id 0 of masks means: 'background', an object of its own (default: unlabelled)")
      ->check(CLI::IsMember({"background"}));
  command.add_flag("--joint", stage.joint, "Train all Gaussians together with their labels, against photos and masks");
  command.add_flag(
      "--hold-out", stage.hold_out,
      "Leave every 8th photo out of the optimisation and write its id picture to held_out/, for evaluation");
  add_negation(command, "--no-vote", stage.start_from_vote,
               "Start the semantic attribute at random, not from the vote");
  add_label_options(command, stage.label);
}

void add_label_options(CLI::App& command, LabelStage& stage) {
  command.add_flag("--label-photos", stage.photos,
                   "Make the masks from the photos, into labelled/ (implied by the options that say how)");
  command.add_option_function<std::string>(
      "--text",
      [&stage](const std::string& text) {
        stage.text = text;
        stage.photos = true;
      },
      "Label these things only, names separated by commas (a detector with a fixed list takes the nearest of its "
      "names)");
  command.add_flag_callback(
      "--everything", [&stage] { stage.everything = stage.photos = true; },
      "Label whatever the segmenter finds, without names and detector");
  command.add_flag_callback(
      "--track", [&stage] { stage.track = stage.photos = true; },
      "The photos are in order: masks are carried from one to the next instead of matched in 3D");
  add_labelling_networks(command, stage.models);
}

void add_extract_options(CLI::App& command, ExtractStage& stage) {
  command.add_option("--object", stage.object, "Id or name of the object (default: the scene file's, or the only one)");
  command.add_option("--threshold", stage.threshold, "Least probability of the object's Gaussians")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command.add_flag("--hull", stage.hull,
                   "What lies inside the convex hull of the object, above its support, belongs to it");
}

void add_repair_options(CLI::App& command, RepairStage& stage) {
  command.add_option("--shadow", stage.shadow, "Contact shadow of the object on its support, where it is plain")
      ->check(CLI::IsMember({"repair", "keep"}))
      ->capture_default_str();
}

void add_seed_options(CLI::App& command, SeedStage& stage) {
  command.add_option("--particles", stage.particles, "Driving particles; the grid follows from them")
      ->check(CLI::Range(200, 10000000))
      ->capture_default_str();
  command
      .add_option("--drivers", stage.drivers,
                  "How they are placed: kmeans, or pgas (Poisson disks, denser where E is small)")
      ->check(CLI::IsMember({"kmeans", "pgas"}))
      ->capture_default_str();
  command.add_option("--pin-below", stage.pin_below, "Hold what lies below this height along up [scene units]");
  add_negation(command, "--no-pin-contact", stage.pin_contact, "Do not hold the object where it touches its support");
}

void add_material_values(CLI::App& command, MaterialValues& material) {
  command.add_option("--young", material.young, "Young's modulus [Pa]");
  command.add_option("--poisson", material.poisson, "Poisson's ratio, -1 < nu < 0.5");
  command.add_option("--density", material.density, "Density [kg/m^3]");
}

void add_simulate_options(CLI::App& command, SimulateStage& stage) {
  command.add_option(
      "--interactions", stage.interactions,
      "JSON array of forces (default: the motion of a fit once more, else one push sized to the stiffness)");
  add_material_values(command, stage.material);
  command
      .add_option("--material", stage.material_file,
                  "E(x), nu(x), rho(x) from a material.h5, of these or of other particles")
      ->check(CLI::ExistingFile);
  command
      .add_option("--velocity", stage.velocity_file,
                  "How the motion starts, from a velocity.h5, of these or of other particles")
      ->check(CLI::ExistingFile);
  command.add_option("--compat", stage.compat, "With --physgaussian: repeat the known defects of that program")
      ->check(CLI::IsMember({"physgaussian"}));
  command.add_option("--law", stage.material.law, "Constitutive law (default fixed_corotated)")
      ->check(CLI::IsMember(law_names()));
  for (const MaterialConstant& constant : material_constants()) {
    std::string name = "--" + std::string(constant.name);
    std::replace(name.begin(), name.end(), '_', '-');
    command
        .add_option_function<double>(
            name, [&stage, &constant](double value) { stage.material.constants[constant.name] = value; },
            constant.description)
        ->group("Constants of the law");
  }
  command.add_option("--fps", stage.fps, "Frames a second")->check(CLI::Range(1.0, 1000.0))->capture_default_str();
  command.add_option("--duration", stage.duration, "Length of the clip [s]")
      ->check(CLI::Range(0.01, 3600.0))
      ->capture_default_str();
  command
      .add_option("--damping-time", stage.damping_time,
                  "Motion decays as exp(-t / this) [s]; 0 = undamped (default: what a fit found, else 1)")
      ->check(CLI::NonNegativeNumber);
  command.add_option("--push", stage.push, "Peak deflection of the automatic push, share of the object's height")
      ->check(CLI::Range(0.001, 1.0))
      ->capture_default_str();
  command
      .add_option("--rest-shape", stage.rest_shape,
                  "What the captured shape of a held object is: free of stress, or loaded by gravity (solve)")
      ->check(CLI::IsMember({"captured", "solve"}))
      ->capture_default_str();
  command
      .add_option("--settle", stage.settle,
                  "Longest time that an object which nothing holds gets to come to rest first [s]")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command
      .add_option("--sleep-speed", stage.sleep_speed,
                  "Parts slower than this are not computed until something touches them [m/s]")
      ->check(CLI::NonNegativeNumber);
  command
      .add_option("--flip-time", stage.flip_time,
                  "Transfer of low dissipation: particles keep what the grid cannot hold this long [s]; 0 = APIC")
      ->check(CLI::NonNegativeNumber);
  command.add_flag("--obstacles", stage.obstacles, "The rest of the scene's Gaussians are an obstacle");
  add_negation(command, "--no-gravity", stage.gravity, "No gravity");
  add_negation(command, "--no-floor", stage.floor, "Let the object pass through the plane that it rests on");
}

void add_render_options(CLI::App& command, RenderStage& stage) {
  command.add_option("--camera", stage.camera,
                     "Camera of clip.mp4 (default: the video's, else one that sees the object well)");
  add_negation(command, "--no-orbit", stage.orbit, "Leave out clip_orbit.mp4");
  command.add_flag("--frames", stage.frames,
                   "Write the frames of clip.mp4 as PNG too, to clip/: to measure on, or to edit");
}

void add_physgaussian(CLI::App& command, std::vector<std::string*> stages) {
  command
      .add_option_function<std::string>(
          "--physgaussian",
          [stages](const std::string& file) {
            for (std::string* stage : stages) *stage = file;
          },
          "Configuration of PhysGaussian (JSON): object, material, boundary conditions, time")
      ->check(CLI::ExistingFile);
}

namespace {

/// A positive number with one of the suffixes.
double parse_with_suffix(const std::string& option, const std::string& text,
                         const std::map<std::string, double>& suffixes) {
  char* stop = nullptr;
  const double value = std::strtod(text.c_str(), &stop);
  const auto suffix = suffixes.find(stop);
  if (stop == text.c_str() || suffix == suffixes.end() || !std::isfinite(value) || !(value * suffix->second > 0)) {
    std::string known;
    for (const auto& [name, factor] : suffixes)
      if (!name.empty()) known += (known.empty() ? "" : ", ") + name;
    throw CLI::ValidationError(option, "'" + text + "' is not a positive number, with or without " + known);
  }
  return value * suffix->second;
}

}  // namespace

size_t parse_count(const std::string& option, const std::string& text) {
  const double count = parse_with_suffix(option, text, {{"", 1}, {"k", 1e3}, {"K", 1e3}, {"M", 1e6}});
  if (!(count >= 1 && count <= 1e9)) throw CLI::ValidationError(option, "'" + text + "' is not in 1..1000M");
  return static_cast<size_t>(std::llround(count));
}

double parse_duration(const std::string& option, const std::string& text) {
  return parse_with_suffix(option, text, {{"", 1}, {"s", 1}, {"m", 60}, {"h", 3600}});
}

std::vector<double> parse_numbers(const std::string& option, const std::string& text, size_t count) {
  std::vector<double> values;
  size_t begin = 0;
  while (begin <= text.size()) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    char* stop = nullptr;
    const double value = std::strtod(word.c_str(), &stop);
    if (word.empty() || *stop != 0 || !std::isfinite(value))
      throw CLI::ValidationError(option, "'" + word + "' in '" + text + "' is not a number");
    values.push_back(value);
    begin = end + 1;
  }
  if (values.size() != count)
    throw CLI::ValidationError(option, "'" + text + "' has " + std::to_string(values.size()) + " numbers, " +
                                           std::to_string(count) + " are needed");
  return values;
}

}  // namespace pliant
