// Videos of one motion: their frames are of the same instants, and each counts where it has something to compare.

#include "app/fit/fit_report.h"
#include "gaussians/io/cameras/cameras.h"
#include "tests/app/fit_video_scene.h"

namespace pliant {
namespace {

class SeveralVideos : public FitVideo {
 protected:
  static FitScene load_with(const std::string& second, double first = 0) {
    Progress progress(true);
    const RunDirectory run = RunDirectory::open(folder / "run");
    FitStage stage;
    stage.videos = {file.string(), second};
    stage.cameras = {camera, camera};
    stage.first = first;
    return load_fit_scene({progress, [] { return false; }}, run, inputs_of(run, load_run_scene(run), stage));
  }
};

TEST_F(SeveralVideos, TheirFramesAreOfTheSameInstants) {
  // Of twice the rate, with a frame halfway between every two.
  VideoWriter writer(folder / "twice.mp4", 2 * fps, frames[0].width, frames[0].height);
  for (size_t f = 0; f + 1 < frames.size(); ++f) {
    ImageF between = frames[f];
    for (size_t i = 0; i < between.data.size(); ++i) between.data[i] = (frames[f].data[i] + frames[f + 1].data[i]) / 2;
    writer.write(frames[f]);
    writer.write(between);
  }
  writer.close();
  // The frame nearest to it is the third of the one, and the fifth of the other.
  const FitScene scene = load_with((folder / "twice.mp4").string(), 2.7 / fps);
  const ReferenceVideo &one = scene.video, &other = scene.further[0].video;
  EXPECT_NEAR(one.start, 3 / fps, 1e-6);
  EXPECT_EQ(other.start, one.start);
  EXPECT_EQ(other.fps, one.fps);
  EXPECT_EQ(other.blended, 0);
}

TEST_F(SeveralVideos, EveryCameraThatIsRefinedIsKeptTheFirstVideosFirst) {
  Progress progress(true);
  const RunDirectory run = RunDirectory::open(folder / "run");
  FitStage stage;
  stage.videos = {file.string(), file.string()};
  stage.cameras = {camera, camera};
  stage.refine_camera = true;
  const FitScene scene =
      load_fit_scene({progress, [] { return false; }}, run, inputs_of(run, load_run_scene(run), stage));
  const std::vector<Camera> kept = read_cameras(folder / "run/fit/transforms.json", {}, PhotoFit::kView).cameras;
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_EQ(kept[0].name, camera);
  EXPECT_EQ(kept[1].name, camera + "_2") << "names are told apart";
  const std::vector<const FitView*> views = scene.views();
  for (size_t i = 0; i < 2; ++i)
    EXPECT_TRUE(kept[i].cam_from_world.isApprox(views[i]->video.camera.cam_from_world, 1e-6)) << i;
}

TEST_F(SeveralVideos, AFurtherOneWithoutACameraIsNotTakenForThatOfTheScene) {
  const Scene scene = load_run_scene(RunDirectory::open(folder / "run"));
  ASSERT_EQ(scene.settings.video->camera, camera);
  FitStage stage;
  stage.videos = {file.string(), file.string()};
  const nlohmann::json unnamed = video_records(scene, stage);
  EXPECT_EQ(unnamed[0]["camera"], camera);
  EXPECT_EQ(unnamed[1]["camera"], "");
  EXPECT_FALSE(knows_cameras(scene, stage));
  stage.cameras = {camera, camera};
  EXPECT_EQ(video_records(scene, stage)[1]["camera"], camera);
}

TEST_F(SeveralVideos, WhatAMaskHidesInTheFirstFrameDoesNotCountInAnyScore) {
  FitScene scene = load_with(file.string());
  scene.further.clear();
  const FittedMotion still{0, std::vector<SimulationState>(frames.size(), initial_state(scene.body.particles))};
  // Something is before the lower half of the first frame.
  const int width = scene.moving.width, height = scene.moving.height;
  ImageU8 bright(width, height, 1);
  bright.data.assign(bright.data.size(), 255);
  scene.compared.assign(frames.size(), bright);
  std::fill(scene.compared[0].data.begin() + scene.compared[0].data.size() / 2, scene.compared[0].data.end(), 0);
  const MotionScores clean = compare_motion(scene, still, scene.used - 1, "");
  for (int y = (height + 1) / 2; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) scene.video.frames[0](x, y, c) = static_cast<float>((x + y) % 2);
  const MotionScores hidden = compare_motion(scene, still, scene.used - 1, "");
  EXPECT_NEAR(hidden.rest, clean.rest, 1e-9);
  EXPECT_NEAR(hidden.fitted.still, clean.fitted.still, 1e-9);
  EXPECT_NEAR(hidden.fitted.psnr, clean.fitted.psnr, 1e-9);
}

TEST_F(SeveralVideos, AFrameThatEqualsTheFirstCountsAsOneOfTheMostDecibels) {
  FitScene scene = load_with(file.string());
  scene.further.clear();
  scene.video.frames[1] = scene.video.frames[0];
  const auto still_from = [&](int first) {
    const FittedMotion motion{first,
                              std::vector<SimulationState>(frames.size() - first, initial_state(scene.body.particles))};
    return compare_motion(scene, motion, scene.used - 1, "").fitted;
  };
  const MotionScores::Span with = still_from(1), without = still_from(2);
  ASSERT_EQ(with.frames, without.frames + 1);
  EXPECT_LT(without.still, kMostPsnr);
  EXPECT_NEAR(with.still, (kMostPsnr + without.frames * without.still) / with.frames, 1e-9);
}

TEST_F(SeveralVideos, OneWithoutFramesInASpanDoesNotCountThere) {
  const size_t shorter = frames.size() - 8;
  FitScene scene = load_with(write("shorter.mp4", {frames.begin(), frames.begin() + shorter}));
  const FittedMotion still{0, std::vector<SimulationState>(frames.size(), initial_state(scene.body.particles))};
  const auto scores = [&](const FitScene& of) { return compare_motion(of, still, of.used - 1, ""); };
  const auto alone = [&](const FitView& view) {
    FitScene one = scene;
    static_cast<FitView&>(one) = view;
    one.further.clear();
    return scores(one);
  };
  ASSERT_EQ(scene.used, static_cast<int>(shorter));
  const FitView first = scene, second = scene.further[0];
  MotionScores both = scores(scene), one = alone(first), other = alone(second);
  EXPECT_EQ(other.later.frames, 0);
  EXPECT_EQ(both.later.frames, 8);
  EXPECT_NEAR(both.later.psnr, one.later.psnr, 1e-9);
  EXPECT_NEAR(both.later.still, one.later.still, 1e-9);
  EXPECT_NEAR(both.fitted.psnr, (one.fitted.psnr + other.fitted.psnr) / 2, 1e-9);
  // The first one is dark in what is held out.
  scene.used = 6;
  const ImageU8 dark(first.moving.width, first.moving.height, 1);
  ImageU8 bright = dark;
  bright.data.assign(bright.data.size(), 255);
  scene.compared.assign(6, bright);
  scene.compared.resize(frames.size(), dark);
  both = scores(scene);
  other = alone(second);
  EXPECT_EQ(both.later.frames, static_cast<int>(shorter) - 6);
  EXPECT_NEAR(both.later.psnr, other.later.psnr, 1e-9);
}

}  // namespace
}  // namespace pliant
