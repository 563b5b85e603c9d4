// Masks of a video: at which instants they count, what of them is bright, and that they leave something of the object.

#include <nlohmann/json.hpp>

#include "app/fit/fit_options.h"
#include "app/fit/fit_video.h"
#include "gaussians/io/images/image_io.h"
#include "tests/app/fit_video_scene.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;

/// Bright, and dark in its left eighth from `from` s on.
ImageF mask_at(double time, double from, int width, int height) {
  ImageF mask(width, height, 3, 1.0f);
  if (time >= from - 1e-9)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width / 8; ++x)
        for (int c = 0; c < 3; ++c) mask(x, y, c) = 0;
  return mask;
}

class FitVideoMask : public FitVideo {
 protected:
  /// A video of masks at its own rate, dark in a corner from the instant of frame `from` of the video on.
  static std::string masks_at(double rate, int from) {
    const int width = frames[0].width, height = frames[0].height;
    const std::string name = (folder / ("masks_" + std::to_string(rate) + ".mp4")).string();
    VideoWriter writer(name, rate, width, height);
    for (int k = 0; k < std::lround(static_cast<double>(frames.size()) * rate / fps); ++k)
      writer.write(mask_at(k / rate, from / fps, width, height));
    writer.close();
    return name;
  }
  static int dark_from(const FitStage& stage) {
    const std::vector<ImageU8> compared = load_compared(stage, load(stage));
    EXPECT_EQ(compared.size(), frames.size());
    const int x = frames[0].width / 16, y = frames[0].height / 2;
    for (size_t f = 0; f < compared.size(); ++f)
      if (!compared[f](x, y)) return static_cast<int>(f);
    return -1;
  }
  static std::string picture(const std::string& name, const ImageF& mask) {
    write_image(folder / name, mask);
    return (folder / name).string();
  }
};

TEST_F(FitVideoMask, AVideoOfMasksRunsAtItsOwnRate) {
  FitStage stage;
  for (const double share : {0.5, 1.0, 2.0}) {
    stage.masks = {masks_at(share * fps, 6)};
    // Between two masks the nearer one counts.
    EXPECT_NEAR(dark_from(stage), 6, share < 1 ? 1 : 0) << share;
  }
  // The rate that is given for the video is that of its masks too: these are too many then.
  stage.fps = fps;
  expect_error(Failure::kInput, {stage.masks[0], "frames", "give masks that last as long"},
               [&] { load_compared(stage, load(stage)); });
}

TEST_F(FitVideoMask, MasksThatEndBeforeTheVideoAreRefused) {
  const int width = frames[0].width, height = frames[0].height;
  FitStage stage;
  stage.masks = {write("short.mp4", std::vector<ImageF>(frames.size() - 1, ImageF(width, height, 3, 1.0f)))};
  expect_error(Failure::kInput, {"short.mp4", "frames", std::to_string(frames.size() - 1)},
               [&] { load_compared(stage, load(stage)); });
}

TEST_F(FitVideoMask, AFolderHasOneMaskForEachFrameOfTheFile) {
  const int width = frames[0].width, height = frames[0].height;
  fs::create_directories(folder / "some");
  // Their names have gaps, their number has not.
  for (size_t f = 0; f < frames.size(); ++f)
    write_image(folder / "some" / (std::to_string(f < 9 ? f : f + 3) + ".png"),
                mask_at(static_cast<double>(f), 12, width, height));
  FitStage stage;
  stage.masks = {(folder / "some").string()};
  EXPECT_EQ(dark_from(stage), 12);
  fs::remove(folder / "some/3.png");
  expect_error(Failure::kInput, {"some", "frames", std::to_string(frames.size() - 1)},
               [&] { load_compared(stage, load(stage)); });
}

TEST_F(FitVideoMask, AMaskThatIsMissingIsNamedAndNotReplacedByTheNext) {
  const auto fill = [](const std::string& name, const std::vector<ImageF>& pictures, std::vector<size_t> missing) {
    fs::remove_all(folder / name);
    fs::create_directories(folder / name);
    for (size_t f = 0; f < pictures.size(); ++f)
      if (std::find(missing.begin(), missing.end(), f) == missing.end())
        write_image(folder / name / (std::to_string(f) + ".png"), pictures[f]);
    return (folder / name).string();
  };
  const std::vector<ImageF> white(frames.size(), ImageF(frames[0].width, frames[0].height, 3, 1.0f));
  FitStage stage;
  const auto refused = [&](const std::vector<std::string>& words) {
    expect_error(Failure::kInput, words, [&] { load_compared(stage, load(stage)); });
  };
  const auto compared = [&] { return load_compared(stage, load(stage)).size(); };
  stage.masks = {fill("lacking", white, {12})};
  stage.last = static_cast<double>(frames.size() - 3) / fps;
  refused({"lacking", "frames", "no mask numbered 12", "one mask for every frame"});
  stage.last = 8 / fps;
  EXPECT_EQ(compared(), 9u);
  // Of a folder of pictures, those of the same numbers.
  stage.videos = {fill("pictures", frames, {5})};
  stage.cameras = {camera};
  stage.fps = fps;
  for (const double last : {0.0, static_cast<double>(frames.size() - 3) / fps}) {
    stage.last = last;
    fill("lacking", white, {12});
    refused({"lacking", "no mask numbered 12"});
    fill("lacking", white, {5});
    EXPECT_EQ(compared(), last == 0 ? frames.size() : frames.size() - 2);
    fill("lacking", white, {});
    refused({"lacking", "are " + std::to_string(frames.size())});
  }
}

TEST_F(FitVideoMask, AFrameThatIsHiddenIsLeftOutOfThePicturesAlone) {
  constexpr size_t kDark = 5;
  const int width = frames[0].width, height = frames[0].height;
  std::vector<ImageF> masks(frames.size(), ImageF(width, height, 3, 1.0f));
  masks[kDark] = ImageF(width, height, 3, 0.0f);
  FitStage stage;
  stage.masks = {write("once.mp4", masks)};
  stage.compare.loss = "image";
  Progress progress(true);
  const Context context{progress, [] { return false; }};
  const RunDirectory run = RunDirectory::open(folder / "run");
  const Scene scene = load_run_scene(run);
  const FitInputs in = inputs_of(run, scene, stage);
  const FitScene fit = load_fit_scene(context, run, in);
  const ClipTerms terms = material_fit_options(context, run, in.scene, in.options, fit, 0).clip;
  ASSERT_EQ(terms.seen.size(), 1u);
  ASSERT_EQ(terms.seen[0].frames.size(), static_cast<size_t>(fit.used));
  for (size_t f = 0; f < terms.seen[0].frames.size(); ++f) EXPECT_EQ(terms.seen[0].frames[f].empty(), f == kDark) << f;
}

TEST_F(FitVideoMask, AnyColourIsBright) {
  const int width = frames[0].width, height = frames[0].height;
  FitStage stage;
  for (int c = 0; c < 3; ++c) {
    ImageF mask(width, height, 3, 0.0f);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) mask(x, y, c) = 1;
    stage.masks = {picture("colour.png", mask)};
    const std::vector<ImageU8> compared = load_compared(stage, load(stage));
    ASSERT_EQ(compared.size(), 1u);
    EXPECT_EQ(std::count(compared[0].data.begin(), compared[0].data.end(), 0), 0) << c;
  }
}

TEST_F(FitVideoMask, AMaskThatIsDarkOverTheObjectIsRefusedByName) {
  const int width = frames[0].width, height = frames[0].height;
  const ImageF black(width, height, 3, 0.0f), white(width, height, 3, 1.0f);
  expect_refused({"--video-mask", picture("black.png", black)}, {"black.png", "mask", "dark over the whole object"});
  std::vector<ImageF> turning(frames.size(), white);
  for (size_t f = 0; f < 3; ++f) turning[f] = black;
  expect_refused({"--video-mask", write("turning.mp4", turning)},
                 {"turning.mp4", "in 3 of " + std::to_string(frames.size()) + " frames, the first among them"});
  // Later on that is possible, and said.
  std::reverse(turning.begin(), turning.end());
  FitStage stage;
  stage.masks = {write("covered.mp4", turning)};
  testing::internal::CaptureStderr();
  Progress progress(false);
  const RunDirectory run = RunDirectory::open(folder / "run");
  load_fit_video({progress, [] { return false; }}, run, inputs_of(run, load_run_scene(run), stage), stage);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("in 3 of " + std::to_string(frames.size()) + " frames"), std::string::npos) << said;
}

}  // namespace
}  // namespace pliant
