// Videos of one motion: their frames are of the same instants, and each counts where it has something to compare.

#include "app/fit/fit_report.h"
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
