#include "app/reconstruct/reconstruct_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
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
#include "gaussians/reconstruct/check_poses.h"
#include "segmentation/field/joint_term.h"
#include "segmentation/labels/mask_layouts.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kCheckpoint = "checkpoint.h5";

/// The options' color, else that of the scene file; none where neither says.
std::optional<Vec3d> background_of(const PhotoSet& set, const ReconstructStage& stage) {
  if (stage.background.empty()) return set.settings.background;
  return Vec3d(stage.background[0], stage.background[1], stage.background[2]);
}

/// What the options ask for.
TrainOptions train_options(const PhotoSet& set, const ReconstructStage& stage, uint64_t seed) {
  const std::map<std::string, Densification> strategies = {
      {"mcmc", Densification::kMcmc}, {"classic", Densification::kClassic}, {"none", Densification::kNone}};
  TrainOptions options = stage.train;
  options.densification = strategies.at(stage.strategy);
  options.seed = seed;
  if (const std::optional<Vec3d> background = background_of(set, stage)) {
    options.render.background = background->cast<float>();
    options.changing_backdrop = false;
  }
  return options;
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
  MaskSet masks = training_masks(folder, labels_of(folder, set.settings.labels), cameras, photos);
  for (const std::string& warning : masks.warnings) context.progress.warn(warning);
  if (!stage.mask_zero.empty()) label_background(masks);
  JointOptions options;
  options.seed = context.seed;
  for (size_t i = 0; i < photos.photos.size(); ++i)
    if (photos.photos[i].held_out) options.held_out.push_back(static_cast<int>(i));
  return std::make_unique<JointTerm>(options, masks);
}

/// The checkpoint of an unfinished training with the same options and inputs; one of another is moved aside.
std::optional<TrainingCheckpoint> unfinished(const Context& context, RunDirectory& run, const std::string& provenance) {
  const fs::path file = run / kCheckpoint;
  if (!fs::exists(file)) return std::nullopt;
  std::string changed;
  try {
    const json before = json::parse(read_training_provenance(file), nullptr, false);
    if (!before.is_object())
      throw input_error(file.string(), "provenance", "is not a record of options and inputs", "");
    changed = first_difference(before, json::parse(provenance));
    if (changed.empty()) {
      TrainingCheckpoint checkpoint = read_training(file);
      const json start = json::parse(checkpoint.start_json, nullptr, false);
      if (!start.is_object() || !start.contains("warnings"))
        throw input_error(file.string(), "start", "is not a record of an initialization", "");
      return checkpoint;
    }
  } catch (const Error& error) {
    if (error.failure != Failure::kInput) throw;
    changed = error.problem;
  }
  const std::string aside = run.move_aside({kCheckpoint}).at(kCheckpoint);
  context.progress.say(
      fmt::format("reconstruct: {}, starting over; the previous checkpoint is kept as {}", changed, aside));
  return std::nullopt;
}

/// Points that belong to the cameras, once poses, photos and points are found to belong together.
SparsePoints checked_points(const Context& context, const ReconstructStage& stage, const PhotoSet& set,
                            const CameraFile& cameras, const TrainingPhotos& photos, json& start) {
  std::vector<Camera> pinholes;
  for (const TrainingPhoto& photo : photos.photos) pinholes.push_back(photo.camera);
  SparsePoints points = read_sparse_points(set.cameras, pinholes);
  const PoseReport report = check_poses({.refuse = stage.poses == "auto", .chosen = pose_convention_named(stage.poses)},
                                        cameras, photos, points);
  context.progress.say("reconstruct: " + report.sentence);
  for (const std::string& warning : report.warnings) context.progress.warn(warning);
  for (const std::string& warning : points.warnings) context.progress.warn(warning);
  start["poses"] = report.sentence;
  start["warnings"] = report.warnings;
  for (const std::string& warning : points.warnings) start["warnings"].push_back(warning);
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

json results_json(const json& options, const TrainOptions& train, const TrainingPhotos& photos,
                  const TrainingState& state, const json& start, const std::vector<std::string>& warnings) {
  const std::vector<PhotoQuality> quality = held_out_quality(state.cloud, photos, train.render);
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
                  {"options", options},
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

json train_scene(const Context& context, RunDirectory& run, const StageInputs<ReconstructStage>& in,
                 const PhotoSet& set, const CameraFile& cameras, std::chrono::steady_clock::time_point begin,
                 const std::string& provenance) {
  check_own_scene(run);
  ReconstructStage stage = in.options;
  std::optional<TrainingCheckpoint> earlier = unfinished(context, run, provenance);

  std::vector<std::string> warnings = cameras.warnings;
  TrainOptions options = train_options(set, stage, context.seed);
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
  if (!stage.splats.empty()) trained = start_from_splats(stage, set.settings, options);
  const bool z_is_up = trained && trained->z_is_up;
  stage.train = options;
  std::optional<Trainer> trainer;
  if (earlier) {
    start = json::parse(earlier->start_json);
    context.progress.say(fmt::format("reconstruct: resuming after iteration {}", earlier->state.iteration));
    trainer.emplace(options, photos, std::move(earlier->state), term.get());
  } else {
    const SparsePoints points = checked_points(context, stage, set, cameras, photos, start);
    TrainingStart first = trained ? std::move(*trained) : start_training(context, stage, points, photos);
    start.update(first.description);
    for (const std::string& warning : first.warnings) {
      context.progress.warn(warning);
      start["warnings"].push_back(warning);
    }
    context.progress.say("reconstruct: initialization: " + start["sentence"].get<std::string>());
    trainer.emplace(options, photos, std::move(first.cloud), term.get());
  }
  // Reading and matching count, but leave at least half of the time for training; of a resumed one they have counted.
  const double spent = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (options.seconds > 0 && !earlier && spent > options.seconds / 2)
    context.progress.warn(fmt::format(
        "reading the photos took {:.1f} s of {:.1f} s; training still gets half of the time", spent, options.seconds));
  for (const json& warning : start["warnings"]) warnings.push_back(warning);
  if (options.seconds == 0 || !earlier)
    trainer->spend(options.seconds > 0 ? std::min(spent, options.seconds / 2) : spent);

  train_to_end(context, stage, photos, *trainer, run / "preview.png", [&](const TrainingState& state) {
    write_training(run / kCheckpoint, {state, start.dump(), provenance});
  });

  const TrainingState& state = trainer->state();
  const std::vector<std::string> lost =
      write_trained_scene(run, {set, cameras, photos, state.cloud, state.iteration, options.render.antialiased, z_is_up,
                                background_of(set, in.options)});
  for (const std::string& sentence : lost) {
    context.progress.warn(sentence);
    warnings.push_back(sentence);
  }
  if (term) {
    std::vector<Camera> pinholes;
    for (const TrainingPhoto& photo : photos.photos) pinholes.push_back(photo.camera);
    const JointResult joint = term->result(state, pinholes, options.render);
    write_segmentation(run / "segmentation.h5", joint.segmentation, provenance);
    if (std::string warning = warning_of_zero(joint.segmentation.class_name, joint.unlabelled);
        stage.mask_zero.empty() && !warning.empty()) {
      context.progress.warn(warning);
      warnings.push_back(std::move(warning));
    }
  }
  json results = results_json(key_of(in).options, options, photos, state, start, warnings);
  results["source"] = fs::weakly_canonical(set.source).string();
  write_json(run / "results.json", results);
  fs::remove(run / kCheckpoint);
  context.progress.say(
      fmt::format("reconstruct: {} Gaussians after {} iterations{}", state.cloud.size(), state.iteration,
                  held_out == 0 ? ""
                                : fmt::format(", {:.2f} dB and SSIM {:.3f} on the held-out photos",
                                              results["psnr"].get<double>(), results["ssim"].get<double>())));
  return {{"gaussians", results["gaussians"]}, {"iterations", results["iterations"]}, {"psnr", results["psnr"]},
          {"ssim", results["ssim"]},           {"seconds", results["seconds"]},       {"start", start}};
}

}  // namespace

StageInputs<ReconstructStage> inputs_of(const PhotoSet& set, const CameraFile& cameras, const ReconstructStage& stage) {
  StageInputs<ReconstructStage> in;
  in.options = stage;
  in.outputs = {"point_cloud", "scene.json", "cameras.json", "transforms.json", "results.json"};
  in.kept = {"point_cloud", "results.json"};
  for (const fs::path& file : cameras.files) in.files["cameras " + file.filename().string()] = file;
  for (const Camera& camera : cameras.cameras)
    if (!camera.photo.empty()) in.files["photo " + camera.name] = camera.photo;
  if (const fs::path points = sparse_points_file(set.cameras); !points.empty()) in.files["points"] = points;
  // The written scene gets its own masks, for photos without distortion.
  if (!set.settings.masks.empty()) in.files["masks"] = set.settings.masks;
  if (stage.joint) {
    if (!stage.masks.empty()) in.files["joint masks"] = stage.masks;
    const std::set<std::string> trained =
        trained_photos(stage.masks.empty() ? set.settings.masks : fs::path(stage.masks));
    if (!trained.empty()) in.found["images_train"] = trained;
    in.found["joint"] = true;
    if (!stage.mask_zero.empty()) in.found["mask_zero"] = stage.mask_zero;
    const fs::path labels = labels_of(masks_of(set, stage), set.settings.labels);
    if (!labels.empty()) in.files["labels"] = labels;
    in.outputs.push_back("segmentation.h5");
    in.kept.push_back("segmentation.h5");
  }
  // Each level of detail has files of its own, so that they tell the level.
  for (const fs::path& file : stage.splats) {
    const bool first = &file == &stage.splats.front();
    const fs::path folder = stage.splats.front().parent_path();
    in.files[first ? "splats" : "splats " + file.lexically_proximate(folder).string()] = file;
  }
  const SceneFile& settings = set.settings;
  if (settings.background && stage.background.empty())
    in.found["background"] = {settings.background->x(), settings.background->y(), settings.background->z()};
  if (settings.antialiased && !stage.splats.empty()) in.found["antialiased"] = *settings.antialiased;
  return in;
}

json run_reconstruct(const Context& context, RunDirectory& run, const fs::path& source, const ReconstructStage& stage) {
  const auto begin = std::chrono::steady_clock::now();
  refuse_other_run(run);
  const PhotoSet set = find_photo_set(source, stage.photos, stage.splats);
  CameraFile cameras = read_photo_cameras(set);
  if (const auto convention = pose_convention_named(stage.poses))
    cameras.cameras = apply_convention(*convention, cameras.format, std::move(cameras.cameras));
  const StageInputs<ReconstructStage> in = inputs_of(set, cameras, stage);
  const json summary = run.stage(context, key_of(in), [&](const std::string& provenance) {
    return train_scene(context, run, in, set, cameras, begin, provenance);
  });
  update_scene_file(run, set, cameras);
  return summary;
}

}  // namespace pliant
