#include "app/reconstruct/reconstruct_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/reconstruct/photo_set.h"
#include "app/reconstruct/trained_scene.h"
#include "app/reconstruct/training_loop.h"
#include "app/reconstruct/training_masks.h"
#include "app/reconstruct/training_start.h"
#include "app/store/segmentation.h"
#include "app/store/training.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/splats/splats.h"
#include "gaussians/reconstruct/check_poses.h"
#include "segmentation/field/joint_term.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

const char* name_of(Densification strategy) {
  switch (strategy) {
    case Densification::kMcmc:
      return "mcmc";
    case Densification::kClassic:
      return "classic";
    case Densification::kNone:
      return "none";
  }
  return "";
}

fs::path masks_of(const PhotoSet& set, const ReconstructStage& stage) {
  return stage.joint && !stage.masks.empty() ? fs::path(stage.masks) : set.settings.masks;
}

/// The attribute to be trained along; null without.
std::unique_ptr<JointTerm> joint_term(const Context& context, const PhotoSet& set, const ReconstructStage& stage,
                                      const CameraFile& cameras, const TrainingPhotos& photos) {
  if (!stage.joint) return nullptr;
  const fs::path folder = masks_of(set, stage);
  if (folder.empty()) throw usage_error("--joint", "--masks", "are not known for these photos", "give --masks FOLDER");
  const MaskSet masks = training_masks(folder, set.settings.labels, cameras, photos);
  for (const std::string& warning : masks.warnings) context.progress.warn(warning);
  JointOptions options;
  options.seed = context.seed;
  for (size_t i = 0; i < photos.photos.size(); ++i)
    if (photos.photos[i].held_out) options.held_out.push_back(static_cast<int>(i));
  return std::make_unique<JointTerm>(options, masks);
}

/// A trained scene goes on in small steps and keeps its Gaussians.
TrainingStart go_on_from(const std::string& splats, TrainOptions& options) {
  GaussianCloud cloud = read_splats(splats);
  options.densification = Densification::kNone;
  options.coarse_to_fine = false;
  options.position_rate *= 0.1f;
  options.sh_degree = std::max(options.sh_degree, cloud.sh_degree);
  const std::string sentence = fmt::format("{} Gaussians of {}", cloud.size(), splats);
  const size_t count = cloud.size();
  return {std::move(cloud), {{"kind", "splats"}, {"points", count}, {"sentence", sentence}}};
}

/// What decides the outcome; without a limit of time, bit for bit.
StageKey key_of(const PhotoSet& set, const CameraFile& cameras, const ReconstructStage& stage) {
  const TrainOptions& train = stage.train;
  const Vec3f& background = train.render.background;
  StageKey key{"reconstruct",
               {{"gaussians", train.most_gaussians},
                {"strategy", name_of(train.densification)},
                {"sh_degree", train.sh_degree},
                {"exposure", train.exposure},
                {"antialiased", train.render.antialiased},
                {"background", {background.x(), background.y(), background.z()}},
                {"longest_side", stage.photo.longest_side},
                {"hold_out", stage.photo.hold_out_every},
                {"start", stage.start},
                {"poses", stage.poses}},
               {},
               {"point_cloud", "scene.json", "cameras.json", "transforms.json", "results.json"}};
  if (!train.changing_backdrop) key.options["backdrop"] = "fixed";
  if (train.seconds > 0)
    key.options["time"] = train.seconds;
  else
    key.options["iterations"] = train.iterations;
  for (const fs::path& file : cameras.files) key.inputs["cameras " + file.filename().string()] = file;
  for (const Camera& camera : cameras.cameras)
    if (!camera.photo.empty()) key.inputs["photo " + camera.name] = camera.photo;
  const fs::path points = read_sparse_points(set.cameras, {}).file;
  if (!points.empty()) key.inputs["points"] = points;
  if (!set.settings.file.empty()) key.inputs["scene.json"] = set.settings.file;
  const fs::path masks = masks_of(set, stage);
  if (!masks.empty()) key.inputs["masks"] = masks;
  if (stage.joint) {
    key.options["joint"] = true;
    key.outputs.push_back("segmentation.h5");
  }
  if (!stage.splats.empty()) key.inputs["splats"] = stage.splats;
  return key;
}

/// The checkpoint of an unfinished training with the same options and inputs.
std::optional<TrainingCheckpoint> unfinished(const Context& context, const fs::path& file,
                                             const std::string& provenance) {
  if (!fs::exists(file)) return std::nullopt;
  try {
    const json before = json::parse(read_training_provenance(file), nullptr, false), now = json::parse(provenance);
    if (!before.is_object() || !before.contains("options") || !before.contains("inputs") || !before.contains("seed"))
      throw input_error(file.string(), "provenance", "is no record of options and inputs", "");
    std::string changed = first_difference(before["options"], now["options"], "option");
    if (changed.empty() && before["seed"] != now["seed"])
      changed = fmt::format("option 'seed' was {}, now {}", before["seed"].dump(), now["seed"].dump());
    if (changed.empty()) changed = first_difference(before["inputs"], now["inputs"], "input");
    if (changed.empty()) {
      TrainingCheckpoint checkpoint = read_training(file);
      const json start = json::parse(checkpoint.start_json, nullptr, false);
      if (!start.is_object() || !start.contains("warnings"))
        throw input_error(file.string(), "start", "is no record of a start", "");
      return checkpoint;
    }
    if (!context.overwrite)
      throw usage_error(file.string(), "", "is of an unfinished training whose " + changed,
                        "repeat that command to go on, give --overwrite to start anew, or another --out");
    context.progress.say("reconstruct: " + changed + ", started anew");
  } catch (const Error& error) {
    if (error.failure != Failure::kInput) throw;
    if (!context.overwrite)
      throw input_error(error.where, error.field, error.problem, "give --overwrite to start anew, or another --out");
    context.progress.warn(fmt::format("{} cannot be used, started anew: {}", file.string(), error.problem));
  }
  fs::remove(file);
  return std::nullopt;
}

/// Points that belong to the cameras, once poses, photos and points are found to belong together.
SparsePoints checked_points(const Context& context, const ReconstructStage& stage, const PhotoSet& set,
                            const CameraFile& cameras, const TrainingPhotos& photos, json& start) {
  std::vector<Camera> pinholes;
  for (const TrainingPhoto& photo : photos.photos) pinholes.push_back(photo.camera);
  SparsePoints points = read_sparse_points(set.cameras, pinholes);
  const PoseReport report = check_poses({.refuse = stage.poses == "auto"}, cameras, photos, points);
  context.progress.say("reconstruct: " + report.sentence);
  for (const std::string& warning : report.warnings) context.progress.warn(warning);
  start["poses"] = report.sentence;
  start["warnings"] = report.warnings;
  return points;
}

json curve_json(const std::vector<CurvePoint>& curve) {
  json rows = json::array();
  for (const CurvePoint& p : curve)
    rows.push_back({{"iteration", p.iteration},
                    {"seconds", p.seconds},
                    {"gaussians", p.gaussians},
                    {"psnr", p.psnr},
                    {"ssim", p.ssim}});
  return rows;
}

json results_json(const StageKey& key, const ReconstructStage& stage, const TrainingPhotos& photos,
                  const TrainingState& state, const json& start, const std::vector<std::string>& warnings) {
  const std::vector<PhotoQuality> quality = held_out_quality(state.cloud, photos, stage.train.render);
  json rows = json::array();
  double psnr = 0, ssim = 0, corrected = 0;
  for (const PhotoQuality& q : quality) {
    rows.push_back({{"name", q.name}, {"psnr", q.psnr}, {"ssim", q.ssim}, {"corrected_psnr", q.corrected_psnr}});
    psnr += q.psnr / quality.size();
    corrected += q.corrected_psnr / quality.size();
    ssim += q.ssim / quality.size();
  }
  json results = {{"gaussians", state.cloud.size()},
                  {"iterations", state.iteration},
                  {"seconds", state.seconds},
                  {"start", start},
                  {"photos", photos.photos.size() - quality.size()},
                  {"held_out", rows},
                  {"curve", curve_json(state.curve)},
                  {"options", key.options},
                  {"warnings", warnings},
                  {"psnr", nullptr},
                  {"ssim", nullptr}};
  if (!quality.empty()) {
    results["psnr"] = psnr;
    results["ssim"] = ssim;
    results["corrected_psnr"] = corrected;
  }
  if (!state.exposure.empty()) {
    for (size_t i = 0; i < photos.photos.size(); ++i)
      results["exposure"][photos.photos[i].camera.name] =
          std::vector<float>(state.exposure.begin() + 12 * i, state.exposure.begin() + 12 * (i + 1));
  }
  return results;
}

}  // namespace

json run_reconstruct(const Context& context, RunDirectory& run, const fs::path& source, const ReconstructStage& stage) {
  const auto begin = std::chrono::steady_clock::now();
  const PhotoSet set = find_photo_set(source, stage.photos);
  CameraFile cameras = read_photo_cameras(set);
  if (const auto convention = pose_convention_named(stage.poses))
    cameras.cameras = apply_convention(*convention, cameras.format, std::move(cameras.cameras));
  const StageKey key = key_of(set, cameras, stage);
  const fs::path checkpoint = run / "checkpoint.h5";

  const json summary = run.stage(context, key, [&]() -> json {
    const std::string provenance = run.provenance(context, key);
    std::optional<TrainingCheckpoint> earlier = unfinished(context, checkpoint, provenance);

    std::vector<std::string> warnings = cameras.warnings;
    TrainOptions options = stage.train;
    options.seed = context.seed;
    PhotoOptions photo_options = stage.photo;
    photo_options.background = options.render.background;
    const TrainingPhotos photos = load_training_photos(photo_options, cameras);
    warnings.insert(warnings.end(), photos.warnings.begin(), photos.warnings.end());
    for (const std::string& warning : warnings) context.progress.warn(warning);
    const auto held_out =
        std::count_if(photos.photos.begin(), photos.photos.end(), [](const TrainingPhoto& p) { return p.held_out; });
    context.progress.say(fmt::format("reconstruct: {} photos of {}x{}{}, {} more are held out",
                                     photos.photos.size() - held_out, photos.photos[0].camera.width,
                                     photos.photos[0].camera.height, photos.changed ? " (changed)" : "", held_out));

    json start;
    const std::unique_ptr<JointTerm> term = joint_term(context, set, stage, cameras, photos);
    std::optional<TrainingStart> trained;
    if (!stage.splats.empty()) trained = go_on_from(stage.splats, options);
    std::optional<Trainer> trainer;
    if (earlier) {
      start = json::parse(earlier->start_json);
      context.progress.say(fmt::format("reconstruct: going on after iteration {}", earlier->state.iteration));
      trainer.emplace(options, photos, std::move(earlier->state), term.get());
    } else {
      const SparsePoints points = checked_points(context, stage, set, cameras, photos, start);
      TrainingStart first = trained ? std::move(*trained) : start_training(context, stage, points, photos);
      start.update(first.description);
      context.progress.say("reconstruct: start: " + start["sentence"].get<std::string>());
      trainer.emplace(options, photos, std::move(first.cloud), term.get());
    }
    // Reading and matching count, but leave at least half of the time for training.
    const double spent = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (options.seconds > 0 && !earlier && spent > options.seconds / 2)
      context.progress.warn(
          fmt::format("reading the photos took {:.1f} s of {:.1f} s; the training gets half of the time all the same",
                      spent, options.seconds));
    for (const json& warning : start["warnings"]) warnings.push_back(warning);
    trainer->spend(options.seconds > 0 ? std::min(spent, options.seconds / 2) : spent);

    train_to_end(context, stage, photos, *trainer, run / "preview.png", [&](const TrainingState& state) {
      write_training(checkpoint, {state, start.dump(), provenance});
    });

    const TrainingState& state = trainer->state();
    const std::vector<std::string> lost = write_trained_scene(
        run.path(), {set, cameras, photos, state.cloud, state.iteration, options.render.antialiased});
    for (const std::string& sentence : lost) {
      context.progress.warn(sentence);
      warnings.push_back(sentence);
    }
    if (term) {
      std::vector<Camera> pinholes;
      for (const TrainingPhoto& photo : photos.photos) pinholes.push_back(photo.camera);
      write_segmentation(run / "segmentation.h5", term->segmentation(state, pinholes, options.render), provenance);
    }
    json results = results_json(key, stage, photos, state, start, warnings);
    results["source"] = fs::weakly_canonical(source).string();
    write_json(run / "results.json", results);
    context.progress.say(
        fmt::format("reconstruct: {} Gaussians after {} iterations{}", state.cloud.size(), state.iteration,
                    held_out == 0 ? ""
                                  : fmt::format(", {:.2f} dB and SSIM {:.3f} on the photos held out",
                                                results["psnr"].get<double>(), results["ssim"].get<double>())));
    return {{"gaussians", results["gaussians"]}, {"iterations", results["iterations"]}, {"psnr", results["psnr"]},
            {"ssim", results["ssim"]},           {"seconds", results["seconds"]},       {"start", start}};
  });
  fs::remove(checkpoint);
  return summary;
}

}  // namespace pliant
