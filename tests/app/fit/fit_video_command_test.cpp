// Which videos a fit takes, by the way that the command goes: cameras that are named, given in a file or found; videos
// that another program makes; and what is refused with a reason.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <numeric>

#include "app/fit/fit_outcome.h"
#include "app/fit/fit_scene.h"
#include "app/run/attach_scene.h"
#include "app/store/lenses.h"
#include "gaussians/base/lens.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/images/image_io.h"
#include "tests/app/fit_video_scene.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

double degrees_between(const Camera& a, const Camera& b) {
  return 180 / M_PI *
         Eigen::AngleAxisd(a.cam_from_world.linear() * b.cam_from_world.linear().transpose().eval()).angle();
}

TEST_F(FitVideo, WhatTheObjectsMotionCannotExplainIsRefusedWithItsReason) {
  expect_refused({"--video-camera", camera == "view_001" ? "view_002" : "view_001"},
                 {"does not show the scene from camera"});
  expect_refused({"--video", write("still.mp4", std::vector<ImageF>(12, frames[0])), "--video-camera", camera},
                 {"still.mp4", "does not move"});
  std::vector<ImageF> cut = frames;
  for (size_t f = cut.size() / 2; f < cut.size(); ++f) std::reverse(cut[f].data.begin(), cut[f].data.end());
  expect_refused({"--video", write("cut.mp4", cut), "--video-camera", camera},
                 {"cut.mp4", "jumps at frame " + std::to_string(cut.size() / 2)});
  std::vector<ImageF> other = frames;
  for (ImageF& picture : other) std::reverse(picture.data.begin(), picture.data.end());
  const std::string other_file = write("other.mp4", other);
  expect_refused({"--video", other_file, "--video-camera", camera},
                 {"other.mp4", "check that the video shows this scene"});
  expect_refused({"--video", other_file, "--video-camera", "find"}, {"none of the 8 known cameras"});
  // The scene file tells another rate than the file.
  const std::string settings = read_text(folder / "scene/scene.json");
  json wrong = json::parse(settings);
  wrong["video"]["fps"] = 2 * fps;
  write_text(folder / "scene/scene.json", wrong.dump());
  expect_refused({}, {"frames per second", "scales with the square of the rate"});
  write_text(folder / "scene/scene.json", settings);
}

TEST_F(FitVideo, TheCameraComesFromAPoseFileOrIsFoundByTheFirstFrame) {
  FitStage stage;
  Camera truth = load(stage).camera;
  EXPECT_EQ(truth.name, camera);
  Camera beside = truth;
  beside.name = "phone";
  beside.cam_from_world.linear() =
      Eigen::AngleAxisd(0.02, Vec3d::UnitY()).toRotationMatrix() * beside.cam_from_world.linear();
  write_cameras(folder / "pose/transforms.json", {beside});
  stage.pose = (folder / "pose/transforms.json").string();
  EXPECT_NEAR(degrees_between(load(stage).camera, beside), 0, 1e-3);
  stage.refine_camera = true;
  EXPECT_LT(degrees_between(load(stage).camera, truth), 0.3);
  FitStage search;
  search.cameras = {"find"};
  const ReferenceVideo found = load(search);
  EXPECT_LT(degrees_between(found.camera, truth), 0.3);
  EXPECT_EQ(found.camera.name, camera + "_found");
  // What was found is a pose file.
  const std::vector<Camera> kept = read_cameras(folder / "run/fit/transforms.json", {}, PhotoFit::kView).cameras;
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].name, found.camera.name);
  FitStage again;
  again.pose = (folder / "run/fit/transforms.json").string();
  EXPECT_LT(degrees_between(load(again).camera, found.camera), 1e-3);

  FitStage wrong = search;
  wrong.pose = stage.pose;
  expect_error(Failure::kUsage, {"--video-camera", "--video-pose"}, [&] { load(wrong); });
  wrong = FitStage();
  wrong.cameras = {"fnd"};
  expect_error(Failure::kUsage, {"did you mean 'find'"}, [&] { load(wrong); });
  beside.photo = (folder / "scene/photos" / (camera == "view_001" ? "view_002.png" : "view_001.png")).string();
  truth.photo = (folder / "scene/photos" / (camera + ".png")).string();
  write_cameras(folder / "pose/transforms.json", {beside, truth});
  wrong = FitStage();
  wrong.pose = stage.pose;
  expect_error(Failure::kUsage, {"2 cameras", "--video-camera"}, [&] { load(wrong); });
  write_text(folder / "pose/bad.json", "{}");
  wrong.pose = (folder / "pose/bad.json").string();
  EXPECT_THROW(load(wrong), Error);
}

TEST_F(FitVideo, TheLensThatTheTrainingRemovedFromThePhotoIsRemovedFromTheVideo) {
  FitStage stage;
  const ReferenceVideo plain = load(stage);
  TrainingPhotos photos;
  photos.photos.resize(1);
  Camera& lens = photos.photos[0].lens = plain.camera;
  lens.distortion[0] = 2;
  const Camera& pinhole = plain.camera;
  std::vector<ImageF> filmed;
  for (const ImageF& frame : plain.frames) {
    ImageF picture(lens.width, lens.height, 3);
    for (int y = 0; y < lens.height; ++y)
      for (int x = 0; x < lens.width; ++x) {
        const Eigen::Vector2d ray = unproject(lens, {x + 0.5, y + 0.5}).value();
        const int u = static_cast<int>(std::floor(pinhole.fx * ray.x() + pinhole.cx)),
                  v = static_cast<int>(std::floor(pinhole.fy * ray.y() + pinhole.cy));
        std::copy_n(frame.at(std::clamp(u, 0, frame.width - 1), std::clamp(v, 0, frame.height - 1)), 3,
                    picture.at(x, y));
      }
    filmed.push_back(std::move(picture));
  }
  stage.videos = {write("filmed.mp4", filmed)};
  stage.cameras = {camera};
  const auto error = [&](const ReferenceVideo& video) {
    double sum = 0;
    for (int y = video.camera.height / 4; y < video.camera.height * 3 / 4; ++y)
      for (int x = video.camera.width / 4; x < video.camera.width * 3 / 4; ++x)
        sum += std::abs(video.frames[0](x, y, 1) - plain.frames[0](x, y, 1));
    return sum;
  };
  const double without = error(load(stage));
  const fs::path lenses = folder / "scene" / kLensFile;
  write_lenses(lenses, photos);
  const ReferenceVideo through = load(stage);
  EXPECT_TRUE(through.lens);
  EXPECT_LT(error(through), 0.5 * without);
  const RunDirectory run = RunDirectory::open(folder / "run");
  EXPECT_TRUE(video_files(load_run_scene(run), stage).count("lenses"));
  // A pose file has the camera that is to be taken.
  write_cameras(folder / "pose/transforms.json", {plain.camera});
  stage.cameras.clear();
  stage.pose = (folder / "pose/transforms.json").string();
  EXPECT_FALSE(load(stage).lens);
  fs::remove(lenses);
}

TEST_F(FitVideo, APartOfTheFileIsTaken) {
  FitStage stage;
  stage.first = 5 / fps;
  stage.last = 14 / fps;
  const ReferenceVideo part = load(stage);
  EXPECT_EQ(part.frames.size(), 10u);
  EXPECT_NEAR(part.start, 5 / fps, 1e-6);
}

TEST_F(FitVideo, AllTimesAreThoseOfTheFile) {
  Progress progress(true);
  const Context context{progress, [] { return false; }};
  const RunDirectory run = RunDirectory::open(folder / "run");
  const auto loaded = [&](double first, double from, double until) {
    FitStage stage;
    stage.first = first / fps;
    stage.from = from < 0 ? -1 : from / fps;
    stage.until = until / fps;
    return load_fit_scene(context, run, inputs_of(run, load_run_scene(run), stage));
  };
  const FitScene whole = loaded(0, 10, 20), part = loaded(2, 10, 20);
  EXPECT_EQ(whole.used, 21);
  EXPECT_NEAR(whole.free_after, 10 / fps, 1e-6);
  EXPECT_EQ(part.used, 19);
  EXPECT_NEAR(part.free_after, 8 / fps, 1e-6);
  VibrationFit found;
  found.start = initial_state(part.body.particles);
  found.time = 8 / fps;
  EXPECT_NEAR(fitted_velocity(part, found, {}).time, 10 / fps, 1e-6);
  EXPECT_LT(loaded(0, -1, static_cast<double>(frames.size())).free_after, 0);
  const auto refused = [&](double first, double from, double until, const char* option) {
    expect_error(Failure::kUsage, {option, "seconds from the start of the file"}, [&] { loaded(first, from, until); });
  };
  refused(2, -1, 2, "--end");
  refused(0, -1, static_cast<double>(frames.size()) + 1, "--end");
  refused(2, 1, 0, "--start");
  refused(0, 20, 20, "--start");
}

TEST_F(FitVideo, APartThatBeginsAwayFromRestIsTrackedFromTheSceneAtRest) {
  Progress progress(true);
  const Context context{progress, [] { return false; }};
  const RunDirectory run = RunDirectory::open(folder / "run");
  FitStage stage;
  const auto loaded = [&] { return load_fit_scene(context, run, inputs_of(run, load_run_scene(run), stage)); };
  const FitScene whole = loaded();
  EXPECT_EQ(whole.displaced, 0);
  const PointTracks all = follow_points(context, whole);
  // Between two frames, of the points that both follow.
  const auto apart = [&](const PointTracks& a, size_t i, const PointTracks& b, size_t j) {
    double sum = 0, weight = 0;
    for (size_t k = 0; k < whole.pixel.size(); ++k) {
      const double w = a.weight[i][k] * b.weight[j][k];
      sum += w * (a.place[i][k] - b.place[j][k]).norm();
      weight += w;
    }
    return sum / weight;
  };
  size_t farthest = 0;
  for (size_t f = 0; f + 10 < all.place.size(); ++f)
    if (apart(all, f, all, 0) > apart(all, farthest, all, 0)) farthest = f;
  stage.first = static_cast<double>(farthest) / fps;
  const FitScene part = loaded();
  EXPECT_GT(part.displaced, 0);
  ASSERT_EQ(part.pixel.size(), whole.pixel.size());
  const PointTracks later = follow_points(context, part);
  EXPECT_EQ(static_cast<int>(later.place.size()), part.used);
  EXPECT_LT(apart(later, 0, all, farthest), 0.2 * apart(all, farthest, all, 0));
}

TEST_F(FitVideo, WhatAMaskLeavesDarkIsNotCompared) {
  Progress progress(true);
  const Context context{progress, [] { return false; }};
  const RunDirectory run = RunDirectory::open(folder / "run");
  const Scene scene = load_run_scene(run);
  FitStage stage;
  const FitScene whole = load_fit_scene(context, run, inputs_of(run, scene, stage));
  const int width = whole.moving.width, height = whole.moving.height;
  double middle = 0;
  for (const Eigen::Vector2d& x : whole.pixel) middle += x.x() / static_cast<double>(whole.pixel.size());
  const auto mask_from = [&](double left) {
    ImageF mask(width, height, 3);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int c = 0; c < 3; ++c) mask(x, y, c) = x >= left;
    return mask;
  };
  // One for all frames: no point begins, and no pixel counts, in its dark half.
  write_image(folder / "mask.png", mask_from(middle));
  stage.masks = {(folder / "mask.png").string()};
  const FitScene half = load_fit_scene(context, run, inputs_of(run, scene, stage));
  EXPECT_GT(half.pixel.size(), 20u);
  for (const Eigen::Vector2d& x : half.pixel) EXPECT_GE(x.x() + 1, middle);
  ImageF weight(width, height, 1, -1);
  weight.data.assign(weight.data.size(), 1.0f);
  leave_out(weight, half, 3);
  EXPECT_EQ(weight(static_cast<int>(middle) - 2, height / 2), 0);
  EXPECT_EQ(weight(static_cast<int>(middle) + 2, height / 2), 1);

  // One for every frame: what is dark from the fourth on is followed until then.
  fs::create_directories(folder / "masks");
  char name[32];
  for (size_t f = 0; f < frames.size(); ++f) {
    std::snprintf(name, sizeof name, "%04zu.png", f);
    write_image(folder / "masks" / name, mask_from(f < 3 ? 0 : width));
  }
  stage.masks = {(folder / "masks").string()};
  const FitScene some = load_fit_scene(context, run, inputs_of(run, scene, stage));
  EXPECT_EQ(some.pixel.size(), whole.pixel.size());
  const PointTracks tracks = follow_points(context, some);
  for (size_t f = 0; f < frames.size(); ++f) {
    const double seen = std::accumulate(tracks.weight[f].begin(), tracks.weight[f].end(), 0.0);
    EXPECT_EQ(seen > 0, f < 3) << f;
  }
  // Each video has its own.
  FitStage both;
  both.videos = {file.string(), file.string(), file.string()};
  both.cameras = {camera, camera, camera};
  both.masks = {"none", (folder / "mask.png").string()};
  const FitScene three = load_fit_scene(context, run, inputs_of(run, scene, both));
  ASSERT_EQ(three.further.size(), 2u);
  EXPECT_EQ(three.pixel.size(), whole.pixel.size());
  EXPECT_EQ(three.further[0].pixel.size(), half.pixel.size());
  EXPECT_TRUE(three.compared.empty() && three.further[1].compared.empty());
  EXPECT_FALSE(is_compared(three.further[0], 3, middle - 2, height / 2));

  fs::remove(folder / "masks" / name);
  expect_error(Failure::kInput, {"masks", std::to_string(frames.size())},
               [&] { load_fit_scene(context, run, inputs_of(run, scene, stage)); });
  write_image(folder / "square.png", ImageF(64, 64, 3, 1.0f));
  const std::string square = (folder / "square.png").string();
  expect_refused({"--video", file.string(), "--video-camera", camera, "--video", file.string(), "--video-camera",
                  camera, "--video-mask", "none", "--video-mask", square},
                 {"square.png", "64 x 64"});
  EXPECT_EQ(run_quietly(fit(
                {"--video", file.string(), "--video-camera", camera, "--video-mask", "none", "--video-mask", square})),
            2);
  EXPECT_EQ(run_quietly(fit({"--video-mask", "nothing.png"})), 2);
}

TEST_F(FitVideo, WhatWasFittedSearchedAndHeldOutIsSaidFrameByFrame) {
  fs::copy(folder / "run", folder / "few", fs::copy_options::recursive);
  const std::string out = (folder / "few").string();
  ASSERT_EQ(run_quietly({"seed", out, "--particles", "200"}), 0);
  const auto fitted = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"fit", out, "--overwrite", "--points", "60", "--compare-fps", "12", "--end", "1.1"});
    EXPECT_EQ(run_quietly(more), 0);
    return json::parse(read_text(folder / "few/fit/results.json"));
  };
  const json some = fitted({"--periods", "1"}), all = fitted({"--periods", "all"});
  const int used = some["frames_used"], first = some["first_frame"];
  ASSERT_GT(some["periods"], 1.2);
  for (const json& fit : {some, all}) {
    EXPECT_EQ(fit["frames_fitted"][0], first);
    EXPECT_EQ(fit["frames_later"][0], used);
    for (const char* key : {"psnr_fitted", "still_fitted", "psnr_later", "still_later"}) EXPECT_GT(fit[key], 5) << key;
  }
  // Of one period of the strongest mode, and of everything before --end.
  EXPECT_NEAR(some["frames_fitted"][1].get<int>() - first, (used - 1 - first) / some["periods"].get<double>(), 1.001);
  EXPECT_EQ(some["frames_searched"], (json{some["frames_fitted"][1].get<int>() + 1, used - 1}));
  EXPECT_GT(some["psnr_searched"], 5);
  EXPECT_EQ(all["frames_fitted"][1], used - 1);
  EXPECT_TRUE(all["frames_searched"].is_null());
  EXPECT_NE(read_text(folder / "few/fit/report.html").find("PSNR of held-out frames"), std::string::npos);
  for (const char* wrong : {"0", "none", "nan"})
    EXPECT_EQ(run_quietly({"fit", out, "--overwrite", "--periods", wrong}), 2) << wrong;
}

TEST_F(FitVideo, FramesAreComparedAtTheRateThatIsAskedFor) {
  Progress progress(true);
  const Context context{progress, [] { return false; }};
  const RunDirectory run = RunDirectory::open(folder / "run");
  FitStage stage;
  stage.compare_fps = fps / 2;
  stage.videos = {file.string(), file.string()};
  stage.cameras = {camera, camera};
  const FitScene scene = load_fit_scene(context, run, inputs_of(run, load_run_scene(run), stage));
  for (const FitView* view : scene.views()) {
    EXPECT_DOUBLE_EQ(view->video.fps, fps / 2);
    EXPECT_EQ(view->video.frames.size(), (frames.size() + 1) / 2);
    EXPECT_EQ(view->video.blended, 0);
    EXPECT_DOUBLE_EQ(view->video.source_fps, fps);
  }
  // Every second frame tells the same material.
  const auto fitted = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--points", "100"});
    EXPECT_EQ(run_quietly(fit(more)), 0);
    return json::parse(read_text(folder / "run/fit/results.json"));
  };
  const json all = fitted({}), half = fitted({"--compare-fps", std::to_string(fps / 2)});
  EXPECT_EQ(all["fps"], fps);
  EXPECT_EQ(half["fps"], fps / 2);
  EXPECT_EQ(all["frames_used"], frames.size());
  EXPECT_EQ(half["frames_used"], (frames.size() + 1) / 2);
  EXPECT_NEAR(half["young_pa"].get<double>() / all["young_pa"].get<double>(), 1, 0.04);
  // What a wrong rate would do to E is said with the numbers.
  const double young = half["young_pa"];
  const std::string said = half["undetermined"].dump();
  for (const std::string& words :
       {fmt::format("{:.4g} frames per second", fps), fmt::format("4 times as large, {:.3g} Pa", 4 * young),
        fmt::format("a quarter, {:.3g} Pa", young / 4)})
    EXPECT_NE(said.find(words), std::string::npos) << words << " in: " << said;
  // A folder of frames has no rate of its own.
  fs::create_directories(folder / "no_rate");
  for (int f = 0; f < 3; ++f) write_image(folder / "no_rate" / (std::to_string(f) + ".png"), frames[f]);
  expect_refused({"--video", (folder / "no_rate").string(), "--video-camera", camera},
                 {"no_rate", "has no frame rate", "--video-fps"});
}

TEST_F(FitVideo, AnInterruptedFitGoesOnWithTheVideoThatAProgramHasMadeForIt) {
  Progress progress(true);
  const Context context{progress, [] { return false; }};
  RunDirectory run = RunDirectory::open(folder / "run");
  run.forget("fit");
  fs::remove_all(folder / "run/fit");
  fs::create_directories(folder / "films");
  char name[32];
  for (size_t f = 0; f < 4; ++f) {
    std::snprintf(name, sizeof name, "%04zu.png", f);
    write_image(folder / "films" / name, frames[f]);
  }
  write_text(folder / "films.sh",
             "echo call >> \"$1/calls.txt\"; cp " + (folder / "films").string() + "/*.png \"$1/frames/\"\n");
  FitStage stage;
  stage.generate.command = "sh " + (folder / "films.sh").string();
  stage.generate.frames = 4;
  stage.cameras = {camera};
  const Scene scene = load_run_scene(run);
  const auto made = [&](const FitStage& of) {
    return load_fit_video(context, run, inputs_of(run, scene, of), of).frames.size();
  };
  const fs::path calls = folder / "run/fit/generated/calls.txt";
  const std::string without = with_video(run, FitStage(), "{\"inputs\": {}}");
  EXPECT_EQ(without, "{\"inputs\": {}}");
  EXPECT_EQ(made(stage), 4u);
  const std::string first = with_video(run, stage, without);
  EXPECT_EQ(made(stage), 4u);
  EXPECT_EQ(read_text(calls), "call\n");
  EXPECT_EQ(with_video(run, stage, without), first);
  FitStage other = stage;
  other.generate.prompt = "faster";
  write_image(folder / "films/0003.png", frames[5]);
  EXPECT_EQ(made(other), 4u);
  EXPECT_EQ(read_text(calls), "call\ncall\n");
  EXPECT_NE(with_video(run, other, without), first);
}

TEST_F(FitVideo, AProgramMakesTheVideoThatIsFitted) {
  // It films what the scene's own video shows, whatever it is asked.
  fs::create_directories(folder / "film");
  char name[32];
  for (size_t f = 0; f < frames.size(); ++f) {
    std::snprintf(name, sizeof name, "%04zu.png", f);
    write_image(folder / "film" / name, frames[f]);
  }
  write_text(folder / "film.sh", "cp " + (folder / "film").string() + "/*.png \"$1/frames/\"\n");
  const std::string command = "sh " + (folder / "film.sh").string();
  ASSERT_EQ(run_quietly(fit({"--video-model-cmd", command, "--video-model-frames", std::to_string(frames.size()),
                             "--video-model-prompt", "it swings", "--video-camera", camera, "--video-fps",
                             std::to_string(fps)})),
            0);
  const json request = json::parse(read_text(folder / "run/fit/generated/request.json"));
  EXPECT_EQ(request["prompt"], "it swings");
  EXPECT_EQ(request["frames"], frames.size());
  const json result = json::parse(read_text(folder / "run/fit/results.json"));
  EXPECT_GT(result["young_pa"].get<double>(), 0);
  EXPECT_LT(result["rms_px"].get<double>(), 0.5 * result["rms_still_px"].get<double>());
  EXPECT_GE(result["undetermined"].size(), 3u);
  for (const char* picture : {"slices.png", "search.png", "loss.png", "young.png", "uncertainty.png", "report.html"})
    EXPECT_TRUE(fs::exists(folder / "run/fit" / picture)) << picture;
  EXPECT_NE(read_text(folder / "run/fit/report.html").find("Limits of this fit"), std::string::npos);
  EXPECT_EQ(run_quietly(fit({"--video-model-cmd", "exit 3;", "--video-camera", camera})), 1);
  EXPECT_EQ(run_quietly(fit({"--video-model-cmd", command, "--video", file.string()})), 2);
}

}  // namespace
}  // namespace pliant
