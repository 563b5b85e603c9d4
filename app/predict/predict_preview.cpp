#include "app/predict/predict_preview.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "app/render/render_stage.h"
#include "app/run/attach_scene.h"
#include "app/simulate/simulate_stage.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/video.h"

namespace pliant {
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

constexpr double kSoftness[] = {0, 0.5, 1};
constexpr double kDuration = 2.5;  // s: the push ends after 0.6 s
constexpr double kFps = 24;
constexpr const char* kSize = "480x360";
constexpr const char* kFolder = "softness";
/// Stages that say what the object is and how it is filled.
constexpr const char* kTaken[] = {"segment", "extract", "repair", "fill", "seed"};

/// The run directory of one softness: the object of `run`, and what was simulated with it before.
RunDirectory directory_of(const RunDirectory& run, double softness) {
  const fs::path path = run / fmt::format("{}/{:g}", kFolder, softness);
  const std::string object = object_folder(run);
  json manifest = run.manifest(), taken = json::object();
  for (const char* name : kTaken)
    if (manifest["stages"].contains(name)) taken[name] = manifest["stages"][name];
  // What is unfinished in `run` is none of its concern.
  manifest.erase("begun");
  manifest.erase("failed");
  if (const fs::path file = path / "run.json"; fs::exists(file)) {
    const json before = read_json(file), begun = before.value("begun", json::object());
    for (const char* name : {"predict", "simulate", "render"}) {
      if (before["stages"].contains(name)) taken[name] = before["stages"][name];
      if (begun.contains(name)) manifest["begun"][name] = begun[name];
    }
  }
  manifest["stages"] = taken;
  if (run.scene().is_object()) manifest["scene"]["source"] = recorded_place(run).string();
  fs::create_directories(path / object);
  for (const std::string& name : {object + "/object.ply", object + "/solid.h5", object + "/particles.h5",
                                  std::string("background.ply"), std::string("background_repaired.ply")})
    if (fs::exists(run / name)) fs::copy_file(run / name, path / name, fs::copy_options::overwrite_existing);
  write_text(path / "run.json", manifest.dump(2));
  return RunDirectory::open(path);
}

ImageF with_caption(const ImageF& picture, const std::string& caption) {
  ImageF out = picture;
  cv::Mat view(out.height, out.width, CV_32FC3, out.data.data());
  const double size = std::max(0.4, out.width / 800.0);
  for (const auto& [color, width] : {std::pair{cv::Scalar::all(0), 4}, std::pair{cv::Scalar::all(1), 1}})
    cv::putText(view, caption, {out.width / 40, out.height - out.height / 24}, cv::FONT_HERSHEY_SIMPLEX, size, color,
                width, cv::LINE_AA);
  return out;
}

}  // namespace

void check_preview(const RunDirectory& run, const Scene& scene, const PredictStage& stage) {
  check_seeded(run);
  if (stage.given.young)
    throw usage_error("predict", "--preview", "does nothing with --young, which has no band",
                      "predict without --young");
  if (scene.settings.material.young && !asks_for_material(stage))
    throw usage_error("predict", "--preview", "does nothing with E in \"material\" of scene.json, which has no band",
                      "ask for a predicted E with --label, --material or --softness");
}

fs::path run_preview(const Context& context, const RunDirectory& run, const Scene& scene, const PredictStage& stage) {
  check_preview(run, scene, stage);
  std::vector<fs::path> folders;
  std::vector<std::string> captions;
  for (const double softness : kSoftness) {
    RunDirectory part = directory_of(run, softness);
    PredictStage predict = stage;
    predict.softness = softness;
    predict.answers = run / kAnswers;
    const json prediction = run_predict(context, part, scene, predict);
    SimulateStage simulate;
    simulate.duration = kDuration;
    simulate.fps = kFps;
    run_simulate(context, part, scene, simulate);
    RenderStage render;
    render.orbit = false;
    render.frames = true;
    render.shot.size = kSize;
    run_render(context, part, scene, render);
    folders.push_back(part / "clip");
    captions.push_back(fmt::format("softness {:g}: E {:.2g} Pa", softness, prediction["young"].get<double>()));
  }
  const fs::path out = run / "softness.mp4";
  std::unique_ptr<VideoWriter> video;
  for (int frame = 0;; ++frame) {
    const std::string name = fmt::format("{:06d}.png", frame);
    if (!fs::exists(folders[0] / name)) break;
    std::vector<cv::Mat> parts;
    std::vector<ImageF> pictures;
    for (size_t k = 0; k < folders.size(); ++k)
      pictures.push_back(with_caption(read_image(folders[k] / name), captions[k]));
    ImageF row(pictures[0].width * static_cast<int>(pictures.size()), pictures[0].height, 3);
    for (int y = 0; y < row.height; ++y)
      for (size_t k = 0; k < pictures.size(); ++k)
        std::copy_n(&pictures[k](0, y, 0), 3 * pictures[k].width, &row(static_cast<int>(k) * pictures[k].width, y, 0));
    if (!video) video = std::make_unique<VideoWriter>(out, kFps, row.width, row.height);
    video->write(row);
  }
  CHECK(video);
  video->close();
  context.progress.say("predict: stiff, usual and soft side by side: " + out.string());
  return out;
}

}  // namespace pliant
