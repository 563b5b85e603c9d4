// An option is obeyed or refused: in every situation in which a stage may run, each of its options either changes the
// key of the result or is refused by its name.  Options come from the parser, so that a new one is tried as well.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <set>

#include "app/commands/stage_options.h"
#include "app/fit/fit_stage.h"
#include "app/page/page_stage.h"
#include "app/predict/predict_stage.h"
#include "app/reconstruct/photo_set.h"
#include "app/render/render_stage.h"
#include "app/seed/seed_stage.h"
#include "app/segment/extract_stage.h"
#include "app/segment/label_choice.h"
#include "app/segment/repair_stage.h"
#include "app/simulate/simulate_stage.h"
#include "app/store/velocity.h"
#include "gaussians/base/error.h"
#include "tests/app/fit_video_scene.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

using Words = std::vector<std::string>;

/// A number that an option takes besides its default.
double another_number(const Option& option, double usual) {
  if (usual + 1 <= option.high) return usual + 1;
  const double low = std::isfinite(option.low) ? option.low : 0;
  return low < usual ? (low + usual) / 2 : usual / 2;
}

class OptionEffects : public FitVideo {
 protected:
  void SetUp() override {
    const RunDirectory run = RunDirectory::open(folder / "run");
    scene_ = load_run_scene(run);
    for (const char* recorded : {"recording.h5", "recording_particles.h5"})
      write_text(run / (object_folder(run) + "/" + recorded), recorded);
    write_text(file("config.json"), "{}");
    for (const char* network : {"detector", "tagger", "segmenter", "tracker", "inpainter"})
      write_text(file(network) + ".onnx", network);
    write_text(file("names.txt"), "flower");
    write_text(file("camera_path.json"), read_text(folder / "scene/transforms.json"));
    write_text(file("masks/view_000.png"), "other masks");
    write_text(file("model/classifier.pth"), "a classifier");
    write_text(folder / "scene/segmentation.h5", "a joint training's");
    write_text(folder / "run/labelled/labels.json", "{}");
    const std::string camera = scene_.cameras[1].name;
    values_ = {
        {"segment.box", "0,20,20,90,90"},
        {"segment.click", "0,60,60"},
        {"segment.stroke", "fg,0,60,60,70,70"},
        {"segment.aabb", "-0.1,-0.1,0.1,0.1,0.1,0.4"},
        {"segment.sphere", "0,0,0.2,0.1"},
        {"segment.masks", file("masks")},
        {"segment.gaussian-grouping", file("model")},
        {"segment.physgaussian", file("config.json")},
        {"segment.text", "leaf"},
        {"segment.detector", file("detector.onnx")},
        {"segment.tagger", file("tagger.onnx")},
        {"segment.segmenter", file("segmenter.onnx")},
        {"segment.tracker", file("tracker.onnx")},
        {"segment.vocabulary", file("names.txt")},
        {"extract.object", "table"},
        {"repair.inpainter", file("inpainter.onnx")},
        {"seed.particles", "500"},
        {"seed.material", file("names.txt")},
        {"seed.physgaussian", file("config.json")},
        {"fit.video", folder / "scene/reference.mp4"},
        {"fit.video-camera", camera},
        {"fit.video-mask", file("names.txt")},
        {"fit.video-pose", file("names.txt")},
        {"fit.start", "0.3"},
        {"fit.periods", "2"},
        {"fit.field", "smooth"},
        {"fit.loss", "both"},
        {"fit.part-labels", file("names.txt")},
        {"fit.initial-material", file("names.txt")},
        {"fit.guidance-cmd", "true"},
        {"fit.guidance-load", file("config.json")},
        {"fit.video-model-cmd", "true"},
        {"fit.video-model-prompt", "a gust"},
        {"fit.markers", file("names.txt")},
        {"fit.marker-axes", "y,-x,z"},
        {"fit.marker-offset", "0,0,1"},
        {"fit.marker-load", file("config.json")},
        {"fit.young", "3e4"},
        {"fit.poisson", "0.2"},
        {"fit.density", "400"},
        {"simulate.interactions", file("config.json")},
        {"simulate.material", file("names.txt")},
        {"simulate.velocity", file("names.txt")},
        {"simulate.physgaussian", file("config.json")},
        {"simulate.young", "3e4"},
        {"simulate.poisson", "0.2"},
        {"simulate.density", "400"},
        {"simulate.rest-shape", "solve"},
        {"render.camera", camera},
        {"render.cameras", file("camera_path.json")},
        {"render.size", "64x48"},
        {"render.clip-fps", "25"},
        {"predict.label", "palm"},
        {"predict.material", "oak"},
        {"predict.weights", file("names.txt")},
        {"predict.llm-url", "http://127.0.0.1:9/v1"},
        {"predict.llm-model", "m"},
        {"predict.young", "3e4"},
        {"predict.poisson", "0.2"},
        {"predict.density", "400"},
        {"page.html-license", "CC BY 4.0"},
        {"reconstruct.photos", file("masks")},
        {"reconstruct.background", "1,1,1"},
    };
  }
  static std::string file(const std::string& name) { return (folder / "option_files" / name).string(); }

  Words words_of(const std::string& stage, const Option& option) const {
    const std::string name = "--" + option.name;
    if (std::holds_alternative<bool*>(option.field)) return {name};
    if (const auto value = values_.find(stage + "." + option.name); value != values_.end())
      return {name, value->second};
    if (const auto* field = std::get_if<int*>(&option.field))
      return {name, fmt::format("{}", static_cast<int>(another_number(option, **field)))};
    if (const auto* field = std::get_if<double*>(&option.field))
      return {name, fmt::format("{}", another_number(option, **field))};
    if (std::holds_alternative<std::optional<int>*>(option.field)) return {name, "3"};
    if (std::holds_alternative<std::optional<double>*>(option.field) ||
        std::holds_alternative<EntryField>(option.field))
      return {name, "0.25"};
    if (std::holds_alternative<CountField>(option.field)) return {name, "5k"};
    if (std::holds_alternative<TimeField>(option.field)) return {name, "60s"};
    for (const std::string& choice : option.choices)
      if (const auto* field = std::get_if<std::string*>(&option.field); field && **field != choice)
        return {name, choice};
    ADD_FAILURE() << "no value is known for --" << stage << "." << option.name;
    return {name, ""};
  }

  /// The keys that a command line gives: what the commands do before a stage begins.
  template <class Stage>
  json keys(const Words& words) const {
    CLI::App app;
    Program program;
    Stage stage;
    add_options(app, program, options_of(stage));
    app.parse(Words(words.rbegin(), words.rend()));
    if constexpr (requires { check_given(app, stage); }) check_given(app, stage);
    if constexpr (std::is_same_v<Stage, ReconstructStage>) {
      const PhotoSet set = find_photo_set(folder / "scene", stage.photos);
      return record_of(key_of(inputs_of(set, read_photo_cameras(set), stage)), 1);
    } else {
      const RunDirectory run = RunDirectory::open(folder / "run");
      json out = {record_of(key_of(inputs_of(run, scene_, stage)), 1)};
      if constexpr (std::is_same_v<Stage, SegmentStage>)
        if (labels_photos(stage)) out.push_back(record_of(key_of(inputs_of(run, scene_, stage.label)), 1));
      return out;
    }
  }

  /// Tries every option beside `base`: those of `refused` are refused, all others change the key, but for kNoResult.
  /// An option that is recorded changes the key whether or not it has an effect: only that it reaches the record is
  /// seen here, and that it has none must be said by `refused`.
  template <class Stage>
  void try_all(const Words& base, const std::set<std::string>& refused) {
    Stage stage;
    const OptionTable table = options_of(stage);
    const json usual = keys<Stage>(base);
    for (const std::string& name : refused)
      EXPECT_TRUE(
          std::any_of(table.options.begin(), table.options.end(), [&](const Option& o) { return o.name == name; }))
          << table.stage << " has no --" << name;
    for (const Option& option : table.options) {
      Words words = words_of(table.stage, option);
      if (std::count(base.begin(), base.end(), words[0])) continue;
      words.insert(words.begin(), base.begin(), base.end());
      const std::string where = fmt::format("{} {}", table.stage, fmt::join(words, " "));
      ++tried;
      try {
        const json key = keys<Stage>(words);
        EXPECT_FALSE(refused.count(option.name)) << "is not refused: " << where;
        EXPECT_TRUE(key != usual || kNoResult.count(table.stage + "." + option.name)) << "does nothing: " << where;
      } catch (const Error& error) {
        const std::string said = error.what();
        EXPECT_EQ(error.failure, Failure::kUsage) << where;
        EXPECT_TRUE(refused.count(option.name)) << "is refused: " << where << ": " << said;
        bool named = said.find("--" + option.name) != std::string::npos;
        for (const std::string& word : base) named = named || said.find(word) != std::string::npos;
        EXPECT_TRUE(named) << where << " is refused without a name: " << said;
      }
    }
  }

  /// Options that do something, but not to results: how long a program may take, how often a training is saved, what
  /// may run, and a wish that others imply.
  inline static const std::set<std::string> kNoResult = {"reconstruct.checkpoint-every", "fit.guidance-timeout",
                                                         "segment.trust-torchscript", "repair.trust-torchscript",
                                                         "segment.label-photos"};
  int tried = 0;
  void TearDown() override { RecordProperty("options_tried", tried); }

  Scene scene_;
  std::map<std::string, std::string> values_;
};

}  // namespace

TEST_F(OptionEffects, OfSegment) {
  using Names = std::set<std::string>;
  const auto v = [&](const char* option) { return values_.at(std::string("segment.") + option); };
  const auto with = [](Names a, const Names& b) {
    a.insert(b.begin(), b.end());
    return a;
  };
  // Without a detector and with nothing to point at.
  const Names networks = {"label-photos", "text",    "track",      "tagger",
                          "segmenter",    "tracker", "vocabulary", "trust-torchscript"};
  const Names masks = {"masks", "mask-zero", "associate"};
  const Names trained = {"iterations", "no-vote", "associate"}, learnt = {"iterations", "no-vote"};
  const Names others = {"auto", "joint", "gaussian-grouping", "physgaussian", "everything", "detector"};
  const Names gestures = {"box", "click", "stroke", "stroke-width", "grow", "aabb", "sphere"};
  try_all<SegmentStage>({}, with(networks, {"stroke-width", "grow"}));
  try_all<SegmentStage>({"--auto"}, with(with(with(networks, with(masks, learnt)), gestures), others));
  Names by_gesture = with(with(networks, masks), others);
  by_gesture.erase("segmenter");
  try_all<SegmentStage>({"--click", v("click")}, with(by_gesture, learnt));
  try_all<SegmentStage>({"--box", v("box")}, with(with(by_gesture, learnt), {"stroke-width"}));
  Names by_segmenter = by_gesture;
  by_segmenter.erase("trust-torchscript");
  by_segmenter.insert({"grow", "aabb", "sphere", "stroke-width"});
  try_all<SegmentStage>({"--click", v("click"), "--segmenter", v("segmenter")}, by_segmenter);
  Names by_shape = with(with(networks, with(with(masks, learnt), others)), {"stroke-width", "grow", "aabb"});
  try_all<SegmentStage>({"--sphere", v("sphere")}, by_shape);
  try_all<SegmentStage>({"--joint"}, with(with(networks, with(trained, gestures)), others));
  try_all<SegmentStage>({"--gaussian-grouping", v("gaussian-grouping")},
                        with(with(networks, with(trained, gestures)), with(others, {"masks", "mask-zero"})));
  try_all<SegmentStage>({"--physgaussian", v("physgaussian")},
                        with(with(networks, with(with(masks, learnt), gestures)), others));
  const Names not_labelled = with(gestures, {"auto", "masks", "joint", "gaussian-grouping", "physgaussian"});
  const Names everything = with(not_labelled, {"text", "detector", "tagger", "vocabulary"});
  try_all<SegmentStage>({"--everything"}, with(everything, {"tracker", "trust-torchscript"}));
  try_all<SegmentStage>({"--everything", "--track"}, with(everything, {"associate", "trust-torchscript"}));
  try_all<SegmentStage>({"--detector", v("detector")}, with(not_labelled, {"everything", "tracker", "mask-zero"}));
}

TEST_F(OptionEffects, OfPredict) {
  try_all<PredictStage>({}, {"llm-url", "llm-model"});
  try_all<PredictStage>({"--label", "palm"}, {"material", "llm-url", "llm-model"});
  try_all<PredictStage>({"--young", "2e4"}, {"softness", "llm-url", "llm-model"});
  try_all<PredictStage>({"--llm-url", values_.at("predict.llm-url"), "--llm-model", "other"}, {"material"});
}

TEST_F(OptionEffects, OfReconstructExtractRepairSeedAndRender) {
  try_all<ReconstructStage>({}, {});
  try_all<ReconstructStage>({"--time-limit", "60s"}, {"iterations"});
  try_all<ExtractStage>({"--object", "flower"}, {});
  try_all<RepairStage>({}, {"trust-torchscript"});
  try_all<RepairStage>({"--inpainter", values_.at("repair.inpainter")}, {});
  try_all<SeedStage>({}, {"material"});
  try_all<SeedStage>({"--sampling", "pgas"}, {});
  try_all<SeedStage>({"--pin-below", "0.1"}, {"material", "no-pin-contact", "physgaussian"});
  try_all<SeedStage>({"--physgaussian", values_.at("seed.physgaussian")},
                     {"material", "particles", "pin-below", "no-pin-contact"});
  write_text(folder / "run" / object_folder(RunDirectory::open(folder / "run")) / "trajectory.h5", "a trajectory");
  json record = json::parse(read_text(folder / "run/run.json"));
  record["stages"]["simulate"] = record["stages"]["seed"];
  write_text(folder / "run/run.json", record.dump());
  try_all<RenderStage>({}, {});
  try_all<PageStage>({}, {});
}

TEST_F(OptionEffects, OfFit) {
  using Names = std::set<std::string>;
  const auto with = [](Names a, const Names& b) {
    a.insert(b.begin(), b.end());
    return a;
  };
  const Names markers = {"marker-axes", "marker-units",   "marker-offset", "marker-reach",
                         "marker-rest", "marker-release", "marker-window", "marker-load"};
  const Names parts = {"parts", "part-labels"}, gradients = {"gradient-window", "gradient-iterations"},
              images = {"loss-lambda", "image-weight"}, drawing = {"guidance-frames", "guidance-load"},
              guide = with(drawing, {"guidance-weight", "guidance-timeout"}),
              model = {"video-model-frames", "video-model-prompt"};
  // This is no scene folder of PhysDreamer.
  const Names always = {"released-fields"};
  const Names to_video = with(with(with(markers, guide), with(model, always)), {"markers"});
  const Names by_tracks = with(with(to_video, gradients), images);
  Names none = by_tracks;
  none.erase("markers");  // instead of the scene's video
  const Names one_field = with(parts, {"fit-density"});
  try_all<FitStage>({}, with(none, one_field));
  try_all<FitStage>({"--field", "parts"}, by_tracks);
  for (const char* network : {"triplanes", "kan"})
    try_all<FitStage>({"--field", network}, with(with(to_video, images), parts));
  try_all<FitStage>({"--loss", "image"}, with(to_video, one_field));
  try_all<FitStage>({"--recipe", "physdreamer"}, with(to_video, with(parts, {"guidance-cmd", "periods"})));
  try_all<FitStage>({"--guidance-cmd", "true"}, with(with(with(markers, drawing), with(model, always)),
                                                     with(with(images, one_field), {"markers", "recipe"})));
  try_all<FitStage>(
      {"--recipe", "dreamgaussian4d"},
      with(to_video, with(parts, {"guidance-cmd", "periods", "field", "young", "poisson", "density", "solver",
                                  "fit-poisson", "fit-density", "gradient-window", "initial-material", "start"})));
  try_all<FitStage>({"--initial-material", values_.at("fit.initial-material")},
                    with(with(none, one_field), {"young", "poisson", "density"}));
  Names generated =
      with(with(by_tracks, one_field), {"video", "video-first", "video-last", "refine-camera", "compare-fps"});
  for (const std::string& name : model) generated.erase(name);
  try_all<FitStage>({"--video-model-cmd", "true"}, generated);
  Names all;
  FitStage stage;
  for (const Option& option : options_of(stage).options) all.insert(option.name);
  for (const std::string& name :
       with(markers, {"young", "poisson", "density", "initial-material", "solver", "markers"}))
    all.erase(name);
  try_all<FitStage>({"--markers", values_.at("fit.markers")}, all);
}

TEST_F(OptionEffects, OfSimulate) {
  using Names = std::set<std::string>;
  const auto v = [&](const char* option) { return values_.at(std::string("simulate.") + option); };
  Names constants, all;
  SimulateStage stage;
  for (const Option& option : options_of(stage).options) {
    all.insert(option.name);
    if (option.group == "Constants of the law" && option.name != "viscosity-time") constants.insert(option.name);
  }
  Names usual = constants;
  usual.insert({"physgaussian-bugs", "no-fit"});  // nothing was fitted here
  const auto with = [&](const Names& more) {
    Names both = usual;
    both.insert(more.begin(), more.end());
    return both;
  };
  try_all<SimulateStage>({}, usual);
  try_all<SimulateStage>({"--interactions", v("interactions")}, with({"auto-push", "physgaussian", "velocity"}));
  try_all<SimulateStage>({"--material", v("material")}, with({"young", "poisson", "density", "physgaussian"}));
  try_all<SimulateStage>({"--velocity", v("velocity")}, with({"auto-push", "interactions", "physgaussian"}));
  try_all<SimulateStage>({"--no-gravity"}, with({"rest-shape", "physgaussian"}));
  const std::map<std::string, Names> laws = {
      {"metal", {"yield-stress", "hardening"}},
      {"plasticine", {"yield-stress", "hardening"}},
      {"sand", {"friction-angle"}},
      {"snow", {"critical-compression", "critical-stretch", "compaction-hardening"}},
      {"foam", {"yield-stress", "plastic-viscosity"}},
      {"fluid", {"bulk-modulus", "pressure-exponent", "dynamic-viscosity"}},
      {"viscoelastic", {"branch-shear", "branch-lambda", "branch-viscosity"}}};
  for (const auto& [law, own] : laws) {
    Names refused = with({"physgaussian"});
    for (const std::string& name : own) refused.erase(name);
    Words words = {"--law", law};
    if (law == "fluid") refused.insert("viscosity-time");  // it has its own
    if (own.count("branch-viscosity")) words.insert(words.end(), {"--branch-viscosity", "10"});
    if (own.count("plastic-viscosity")) words.insert(words.end(), {"--plastic-viscosity", "10"});
    if (own.count("yield-stress")) words.insert(words.end(), {"--yield-stress", "100"});
    try_all<SimulateStage>(words, refused);
  }
  for (const char* name : {"physgaussian", "physgaussian-bugs"}) all.erase(name);
  try_all<SimulateStage>({"--physgaussian", v("physgaussian")}, all);
}

TEST_F(OptionEffects, OfSimulateWithAFit) {
  const fs::path run = folder / "run", object = run / object_folder(RunDirectory::open(run));
  json record = json::parse(read_text(run / "run.json"));
  json& fit = record["stages"]["fit"] = record["stages"]["seed"];
  fit["inputs"] = {{"particles", hash_of_input(object / "particles.h5")}};
  fit["scene"] = {{"metres_per_unit", scene_.metres_per_unit}};
  fit["outputs"] = json::array({object_folder(RunDirectory::open(run)) + "/material.h5"});
  record["stages"]["simulate"] = fit;
  write_text(run / "run.json", record.dump());
  write_text(object / "material.h5", "a fit's");
  write_text(object / "trajectory.h5", "a simulation's");
  VelocityFile moving;
  moving.velocity = moving.displacement = {Vec3f(1, 0, 0)};
  moving.F = moving.C = {Mat3f::Identity()};
  write_velocity(object / "velocity.h5", moving, "{}");
  std::set<std::string> refused = {"physgaussian-bugs", "poisson", "density", "auto-push"};
  SimulateStage stage;
  for (const Option& option : options_of(stage).options)
    if (option.group == "Constants of the law" && option.name != "viscosity-time") refused.insert(option.name);
  try_all<SimulateStage>({}, refused);
  for (const char* option : {"poisson", "density", "auto-push"}) refused.erase(option);
  refused.insert("physgaussian");
  try_all<SimulateStage>({"--no-fit"}, refused);
  try_all<RenderStage>({}, {});

  // Of other particles, and of another scale.
  EXPECT_NO_THROW(keys<SimulateStage>({}));
  const double scale = scene_.metres_per_unit;
  scene_.metres_per_unit = 2 * scale;
  EXPECT_THROW(keys<SimulateStage>({}), Error);
  scene_.metres_per_unit = scale;
  write_text(object / "particles.h5", "others");
  EXPECT_THROW(keys<SimulateStage>({}), Error);
  EXPECT_NO_THROW(keys<SimulateStage>({"--no-fit"}));
  EXPECT_THROW(keys<RenderStage>({}), Error);
}

}  // namespace pliant
