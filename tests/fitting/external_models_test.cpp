// Programs that make or judge videos: the protocols, against small stand-ins, and everything that such programs do wrong.

#include <chrono>
#include <numeric>

#include "fitting/fit/generate_video.h"
#include "fitting/fit/guidance.h"
#include "gaussians/io/files.h"
#include "gaussians/io/image_io.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;

Camera camera_of(int width, int height) {
  Camera camera;
  camera.name = "view_a", camera.width = width, camera.height = height, camera.fx = camera.fy = 30, camera.cx = 12, camera.cy = 8;
  return camera;
}

struct ExternalModels : testing::Test {
  TemporaryFolder folder;
  /// A command that runs the shell script with the folder as $1.
  std::string script(const std::string& text) { return "sh " + folder.file("stand_in.sh", text).string(); }

  ReferenceVideo generate(const std::string& text, double time_limit = 20) {
    GenerateOptions options;
    options.command = script(text), options.frames = 3, options.fps = 12, options.time_limit = time_limit, options.seed = 41;
    ImageF first(24, 16, 3, 0.25f);
    return generate_video(options, first, camera_of(24, 16), folder / "work");
  }
};

TEST_F(ExternalModels, AGeneratorGetsThePictureTheCameraAndTheRequest) {
  const ReferenceVideo video = generate("cd \"$1\"; cat camera.json request.json > seen.txt; for k in 0 1 2; do cp first.png frames/000$k.png; done; cp first.png frames/0003.png");
  ASSERT_EQ(video.frames.size(), 3u);
  EXPECT_DOUBLE_EQ(video.fps, 12);
  EXPECT_NEAR(video.frames[2](5, 5, 1), 0.25, 0.003);
  EXPECT_EQ(video.warnings.size(), 1u);
  const std::string seen = read_text(folder / "work/seen.txt");
  for (const char* word : {"view_a", "cam_from_world", "\"frames\": 3", "\"seed\": 41", "\"width\": 24", "frames/%04d.png"})
    EXPECT_NE(seen.find(word), std::string::npos) << word;
}

TEST_F(ExternalModels, WhatAGeneratorDoesWrongIsSaid) {
  expect_error(Failure::kInput, {"exit code 3", "out of memory"}, [&] { generate("echo out of memory >&2; exit 3"); });
  expect_error(Failure::kInput, {"0001.png", "is missing", "1 pictures"}, [&] { generate("cp \"$1/first.png\" \"$1/frames/0000.png\""); });
  write_image(folder / "small.png", ImageF(8, 8, 3));
  expect_error(Failure::kInput, {"0000.png", "8 x 8", "24 x 16"}, [&] { generate("cp \"$1/../small.png\" \"$1/frames/0000.png\""); });
  expect_error(Failure::kInput, {"0000.png"}, [&] { generate("echo no picture > \"$1/frames/0000.png\""); });
  const auto start = std::chrono::steady_clock::now();
  expect_error(Failure::kInput, {"within 0.3 s"}, [&] { generate("sleep 30 & sleep 30", 0.3); });
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 10);
  GenerateOptions options;
  options.command = "/no/such/program";
  expect_error(Failure::kInput, {"exit code 127"}, [&] { generate_video(options, ImageF(24, 16, 3), camera_of(24, 16), folder / "work"); });
  options.interrupted = [] { return true; };
  options.command = "sleep 30;";
  EXPECT_THROW(generate_video(options, ImageF(24, 16, 3), camera_of(24, 16), folder / "work"), Error);
}

TEST_F(ExternalModels, TheStableVideoDiffusionScriptSpeaksTheProtocol) {
  if (system("command -v python3 > /dev/null") != 0) GTEST_SKIP() << "python3 is not installed";
  // Modules of the same interface: pictures are the bytes of their file, whose size they do not change.
  folder.file("modules/torch.py", R"(
float16 = float32 = None
class cuda:
    is_available = staticmethod(lambda: False)
def manual_seed(seed): return seed
)");
  folder.file("modules/diffusers/__init__.py", R"(
class StableVideoDiffusionPipeline:
    @staticmethod
    def from_pretrained(model, torch_dtype=None, variant=None): return StableVideoDiffusionPipeline()
    def __call__(self, image, width, height, num_frames, fps, motion_bucket_id, noise_aug_strength, decode_chunk_size, generator):
        assert width % 64 == 0 and height % 64 == 0 and (width, height) == image.size and generator == 5 and fps == 24
        class Result: frames = [[image] * num_frames]
        return Result
)");
  folder.file("modules/diffusers/utils.py", R"(
class Picture:
    def __init__(self, data, size): self.data, self.size = data, size
    def resize(self, size): return Picture(self.data, size)
    def save(self, file): open(file, "wb").write(self.data)
def load_image(file): return Picture(open(file, "rb").read(), None)
)");
  GenerateOptions options;
  options.command = "PYTHONPATH=" + (folder / "modules").string() + " python3 " PLIANT_SOURCE_DIR "/fitting/fit/adapters/stable_video_diffusion.py";
  options.frames = 4, options.seed = 5;
  const ReferenceVideo video = generate_video(options, ImageF(24, 16, 3, 0.5f), camera_of(24, 16), folder / "work");
  EXPECT_EQ(video.frames.size(), 4u);
  options.frames = 99;
  expect_error(Failure::kInput, {"exit code 1", "at most 25"}, [&] { generate_video(options, ImageF(24, 16, 3), camera_of(24, 16), folder / "work"); });
}

/// Loss 1 + step; the gradient is the picture itself.
const char* const kGuide = R"(cd "$1"; echo loading the model; echo '{"ready": 1, "name": "stand-in"}'; step=0
while read line; do case "$line" in *quit*) echo bye > ended.txt; exit 0;; esac
  echo "$line" >> seen.txt; cp frames.f32 gradient.f32; echo "{\"step\": $step, \"loss\": $((step + 1)).5}"; step=$((step + 1)); done)";

TEST_F(ExternalModels, AGuideKeepsRunningAndGivesAGradientForEveryPixel) {
  std::vector<ImageF> frames(2, ImageF(6, 4, 3));
  for (ImageF& frame : frames) std::iota(frame.data.begin(), frame.data.end(), &frame == &frames[0] ? 0.0f : 0.5f);
  {
    GuidanceOptions options;
    options.command = script(kGuide);
    Guidance guide(options, folder / "work");
    EXPECT_EQ(guide.name(), "stand-in");
    for (int step = 0; step < 3; ++step) {
      const GuidanceResult result = guide.evaluate(frames, 24);
      EXPECT_DOUBLE_EQ(result.loss, step + 1.5);
      ASSERT_EQ(result.gradient.size(), 2u);
      for (int t = 0; t < 2; ++t) EXPECT_EQ(result.gradient[t].data, frames[t].data);
      frames[1].data[7] += 1;
    }
  }
  EXPECT_TRUE(fs::exists(folder / "work/ended.txt"));
  EXPECT_NE(read_text(folder / "work/seen.txt").find("\"shape\":[2,4,6,3]"), std::string::npos);
}

TEST_F(ExternalModels, WhatAGuideDoesWrongIsSaid) {
  const std::vector<ImageF> frames(2, ImageF(6, 4, 3, 0.5f));
  const std::string ready = "cd \"$1\"; echo '{\"ready\": 1}'; read line; ";
  const auto run = [&](const std::string& text, double limit = 20) {
    GuidanceOptions options;
    options.command = script(text), options.start_limit = 20, options.step_limit = limit;
    Guidance guide(options, folder / "work");
    guide.evaluate(frames, 24);
  };
  expect_error(Failure::kInput, {"its start", "exit code 4", "no weights"}, [&] { run("echo no weights >&2; exit 4"); });
  expect_error(Failure::kInput, {"ready", "2"}, [&] { run("echo '{\"ready\": 2}'; sleep 30"); });
  expect_error(Failure::kInput, {"step 0", "exit code 5"}, [&] { run(ready + "exit 5"); });
  expect_error(Failure::kInput, {"step 0", "within 0.2 s"}, [&] { run(ready + "sleep 30", 0.2); });
  expect_error(Failure::kInput, {"step 0", "too dark"}, [&] { run(ready + "echo '{\"error\": \"too dark\"}'; read line"); });
  expect_error(Failure::kInput, {"NUMBER"}, [&] { run(ready + "echo '{\"step\": 1, \"loss\": 2}'; read line"); });
  expect_error(Failure::kInput, {"nothing", "576 bytes"}, [&] { run(ready + "echo '{\"step\": 0, \"loss\": 2}'; read line"); });
  expect_error(Failure::kInput, {"5 bytes", "576"}, [&] { run(ready + "echo four > gradient.f32; echo '{\"step\": 0, \"loss\": 2}'; read line"); });
  const std::string all_ones = "head -c 576 /dev/zero | tr '\\000' '\\377' > gradient.f32; ";
  expect_error(Failure::kInput, {"not finite", "frame 0"}, [&] { run(ready + all_ones + "echo '{\"step\": 0, \"loss\": 2}'; read line"); });
  expect_error(Failure::kInput, {"its answer"}, [&] { run(ready + "echo '{broken'; read line"); });
}

}  // namespace
}  // namespace pliant
