#include "app/page/page_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "app/page/clip_budget.h"
#include "app/page/clip_html.h"
#include "app/page/interaction_numbers.h"
#include "app/page/page_assets.h"
#include "app/page/page_solver.h"
#include "app/report/html.h"
#include "app/run/attach_scene.h"
#include "app/simulate/clip_camera.h"
#include "gaussians/base/error.h"
#include "gaussians/base/orbit.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/webp.h"
#include "gaussians/render/image_loss.h"
#include "gaussians/render/render.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kSideways = 25;      // degrees to either side from which photographed scenes are worth a look
constexpr double kPosterSide = 1280;  // px, at most
constexpr double kVideoShare = 0.1;   // of the bytes that the video may take, for devices that cannot draw
constexpr size_t kHeader = 20'000;    // bytes at most, without texts of the user and what holds the object

std::vector<double> numbers(const Vec3d& v) { return {v.x(), v.y(), v.z()}; }

json camera_json(const Camera& camera) {
  json rows = json::array();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 4; ++j) rows.push_back(camera.cam_from_world.matrix()(i, j));
  return {{"width", camera.width}, {"height", camera.height}, {"fx", camera.fx},       {"fy", camera.fy},
          {"cx", camera.cx},       {"cy", camera.cy},         {"cam_from_world", rows}};
}

/// What rounding and pruning cost [dB], the least of some instants and views.
double least_psnr(const CodedClip& clip, const MovingScene& moving, const std::vector<Camera>& views,
                  const RenderOptions& options) {
  double least = INFINITY;
  const size_t frames = moving.trajectory.frames.size();
  for (size_t v = 0; v < views.size(); ++v) {
    const size_t t = v * (frames - 1) / std::max<size_t>(1, views.size() - 1);
    const ImageF full = render(moving.all_at(moving.trajectory.frames[t]), views[v], options).color;
    const ImageF page = render(clip.decoded_frame(t), views[v], options).color;
    least = std::min(least, psnr_of_mse(mse_loss(full, page)));
  }
  return least;
}

/// `instead`: what else there is to do where a page does not fit, after "give more".
json make_page(const Context& context, const RunDirectory& run, const StageInputs<PageStage>& in, const fs::path& file,
               const std::string& instead) {
  const PageStage& stage = in.options;
  const Scene& scene = in.scene;
  MovingScene moving = load_moving_scene(in.files, scene);
  const Box bounds = robust_bounds(moving.object);
  const Camera camera = clip_camera(scene, "", bounds);
  const Vec3d centre = bounds.centre().cast<double>();
  const std::vector<Camera> views = page_views(camera, centre, scene.up, scene.cameras_are_orbit);
  RenderOptions options;
  options.antialiased = moving.antialiased;
  options.background = scene.settings.background_color();
  const ImageF first =
      render(moving.all_at(moving.trajectory.frames.front()),
             camera.scaled(std::min(1.0, kPosterSide / std::max(camera.width, camera.height))), options)
          .color;
  const std::string poster = encode_webp(to_8_bit(first), 80);
  const size_t film = in.files.count("clip") ? fs::file_size(in.files.at("clip")) : 0;
  const auto film_in = [&](size_t size) {
    return static_cast<double>(film) < kVideoShare * static_cast<double>(size) ? film : 0;
  };
  const std::string video = film_in(stage.size) > 0 ? read_text(in.files.at("clip")) : "";

  SessionSetup setup = session_setup(run, scene, moving);
  ClipCoder coder(std::move(moving), scene, views);
  SectionPacker packer;
  const std::vector<SolverLevel> levels = solver_levels(setup, scene, coder.moving());
  const auto levels_of = [&](const CodedClip& clip) {
    return levels_beside(clip.level, levels, clip.choice.solver_levels);
  };
  const auto motion_level = [&](const CodedClip& clip) {
    return SolverLevel{0, clip.level, {}, memory_of(coder.moving(), clip.level)};
  };
  std::map<std::pair<size_t, size_t>, size_t> bytes_of_solver;  // by drivers and number of levels
  SolverShare solver;
  solver.needed = stage.grows;
  solver.levels = [&](const CodedClip& clip) { return levels_beside(clip.level, levels).size(); };
  solver.bytes = [&](const CodedClip& clip) -> size_t {
    if (!clip.choice.solver) return 0;
    const std::span<const SolverLevel> beside = levels_of(clip);
    const auto [known, fresh] = bytes_of_solver.try_emplace({clip.level.driving_position.size(), beside.size()});
    if (fresh) known->second = solver_bytes(motion_level(clip), setup, scene, beside, packer);
    return known->second;
  };
  json unbounded = {stage.licence, stage.command, in.found, setup.script};
  for (const Interaction& it : setup.held) unbounded.push_back(numbers_of(it));
  const size_t header_bytes = kHeader + json_in_script(unbounded).size();
  const size_t code = page_template().size() + page_style().size() + page_script().size() + header_bytes;
  const auto around = [&](size_t size) { return code + 4 * (poster.size() + film_in(size)) / 3; };
  const size_t bytes = stage.size - std::min(stage.size, around(stage.size));
  ClipPage page;
  std::vector<std::string> given_up;
  size_t least = 0;
  const CodedClip clip = fit_to_size(coder, bytes, solver, page.file, packer, given_up, least);
  if (least > bytes && !stage.grows)
    throw usage_error(
        "--html-size", std::to_string(stage.size),
        fmt::format("is too small: the minimum is {}, of a page that only plays, with almost no background",
                    least + around(least + around(0))),
        "give more" + instead);
  const MovingScene& drawn = coder.moving();
  if (!clip.choice.solver) setup.refused = "the solver does not fit into this size";
  add_solver(page.file, motion_level(clip), setup, scene, levels_of(clip));
  const double psnr = least_psnr(clip, drawn, {camera, views[2], camera, views[6]}, options);

  json& header = page.file.header;
  // What is done in the page says on what it was done.
  if (header["solver"].is_object())
    header["solver"].update({{"object", in.found["object"]}, {"simulated", in.found["simulated"]}});
  header["title"] = in.found["title"];
  header["about"] = {{"pliant", PLIANT_VERSION},
                     {"source", in.found["source"]},
                     {"licence", stage.licence},
                     {"command", stage.command},
                     {"given_up", fmt::format("{}", fmt::join(given_up, "; "))}};
  if (in.found.contains("prediction")) {
    const json& prediction = in.found["prediction"];
    const double young = prediction["young"];
    header["about"]["material"] =
        (prediction["guessed"] ? "guessed: " : "predicted: ") + prediction["understood"].get<std::string>();
    header["softness"] = {{"value", prediction["softness"]}};
    for (const char* end : {"low", "typical", "high"})
      header["softness"][end] = prediction["young_band"][end].get<double>() / young;
  }
  header["up"] = numbers(scene.up);
  header["metres_per_unit"] = scene.metres_per_unit;
  header["clip"] = {
      {"fps", drawn.trajectory.fps}, {"frames", drawn.trajectory.frames.size()}, {"camera", camera_json(camera)}};
  header["orbit"] = {{"centre", numbers(centre)},
                     {"radius", (camera.centre() - centre).norm()},
                     {"degrees", scene.cameras_are_orbit ? 360 : 2 * kSideways}};
  header["render"] = {{"antialiased", drawn.antialiased}, {"background", {0, 0, 0}}};
  if (scene.settings.background) header["render"]["background"] = numbers(*scene.settings.background);
  page.poster = poster;
  page.video = video;
  const PageSizes sizes = write_page(file, page, packer, stage.grows ? SIZE_MAX : stage.size);
  if (!given_up.empty())
    context.progress.say(fmt::format("page: to fit into {:.1f} MB, {}", static_cast<double>(stage.size) / 1e6,
                                     fmt::join(given_up, "; ")));
  if (const std::string why = header["plays_only"]; !why.empty()) context.progress.say("page: playback only: " + why);
  context.progress.say(
      fmt::format("page: {:.2f} MB, PSNR at least {:.1f} dB against the full scene in the clip's views",
                  static_cast<double>(sizes.all) / 1e6, psnr));
  return {{"bytes", sizes.all},
          {"bytes_until_poster", sizes.until_poster},
          {"bytes_until_motion", sizes.until_motion},
          {"bytes_of_sections", sizes.sections},
          {"given_up", given_up},
          {"drivers", clip.level.driving_position.size()},
          {"background_gaussians", clip.background.size()},
          {"object_gaussians", clip.object.size()},
          {"psnr_db", psnr}};
}

}  // namespace

std::vector<Camera> page_views(const Camera& camera, const Vec3d& centre, const Vec3d& up, bool all_around) {
  OrbitPathOptions turn;
  turn.frames = 8;
  turn.degrees = all_around ? 360 : kSideways;
  return orbit_path(turn, camera, centre, up);
}

bool shows_motion(const RunDirectory& run, const std::string& stage) {
  if (!run.has(stage)) return run.last_record(stage).is_null();
  const json& shown = run.manifest()["stages"][stage]["inputs"];
  return !shown.contains("trajectory") || shown["trajectory"] == hash_of_input(moving_scene_files(run)["trajectory"]);
}

StageInputs<PageStage> inputs_of(const RunDirectory& run, const Scene& scene, const PageStage& stage) {
  check_simulated_with(run, scene);
  StageInputs<PageStage> in;
  in.options = stage;
  in.parts = {ScenePart::kDrawing, ScenePart::kCameras, ScenePart::kUp, ScenePart::kMetresPerUnit,
              ScenePart::kVideoCamera};
  in.scene = only(in.parts, scene);
  in.files = moving_scene_files(run);
  if (fs::exists(run / "clip.mp4") && shows_motion(run, "render")) in.files["clip"] = run / "clip.mp4";
  const std::string source = fs::path(run.scene()["source"].get<std::string>()).filename().string();
  const std::string object = extracted(run, {"name"})["name"].get<std::string>();
  in.found = {{"source", source},
              {"title", object == "object" ? source : object + " of " + source},
              {"object", object},
              {"simulated", record_of_motion(run)}};
  // What the solver in the page is given beside the motion.
  const json& simulated = run.summary("simulate", "run `pliant simulate` first");
  for (const char* name : {"session", "damping_time_s", "floor"}) in.found[name] = simulated.value(name, json());
  if (run.manifest()["stages"]["simulate"]["found"].contains("predicted")) {
    const json& prediction = run.summary("predict", "run `pliant predict` first");
    const json given = prediction.value("given", json::array());
    // The band is that of the label, in which a given E has no place.
    if (std::find(given.begin(), given.end(), "young") == given.end())
      for (const char* name : {"understood", "guessed", "softness", "young", "young_band"})
        in.found["prediction"][name] = prediction[name];
  }
  if (const fs::path material = run / (object_folder(run) + "/material.h5"); fs::exists(material))
    in.files["material"] = material;
  in.outputs = {"clip.html"};
  return in;
}

json run_page(const Context& context, RunDirectory& run, const Scene& scene, const PageStage& stage) {
  return run_stage(context, run, inputs_of(run, scene, stage),
                   [](const Context& c, const RunDirectory& r, const StageInputs<PageStage>& in, const std::string&) {
                     return make_page(c, r, in, r / "clip.html", ", or --no-html");
                   });
}

void drop_page(RunDirectory& run) {
  if (run.last_record("page").is_null()) return;
  run.forget("page");
  fs::remove(run / "clip.html");
}

json export_page(const Context& context, const RunDirectory& run, const Scene& scene, const PageStage& stage,
                 const fs::path& file) {
  json summary = make_page(context, run, inputs_of(run, scene, stage), file, "");
  summary["file"] = file.string();
  return summary;
}

OptionTable options_of(PageStage& stage) {
  return {"page",
          {{.name = "no-html", .field = &stage.html, .help = "No clip.html", .off = true},
           {.name = "html-size",
            .field = CountField{&stage.size},
            .help = "Maximum size of clip.html [bytes], such as 12M"},
           {.name = "html-license",
            .field = &stage.licence,
            .help = "License of the scene, which clip.html shows",
            .value = "TEXT",
            .formerly = "html-licence"}}};
}

}  // namespace pliant
