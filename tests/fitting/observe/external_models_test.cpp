// Programs that make or judge videos: the protocols, against small stand-ins, and everything that such programs do
// wrong.

#include <chrono>
#include <cmath>
#include <numeric>

#include "fitting/observe/generate_video.h"
#include "fitting/observe/guidance.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;

Camera camera_of(int width, int height) {
  Camera camera;
  camera.name = "view_a";
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 30;
  camera.cx = 12;
  camera.cy = 8;
  return camera;
}

struct ExternalModels : testing::Test {
  TemporaryFolder folder;
  /// A command that runs the shell script with the folder as $1.
  std::string script(const std::string& text) { return "sh " + folder.file("stand_in.sh", text).string(); }

  ReferenceVideo generate(const std::string& text, double time_limit = 20) {
    GenerateOptions options;
    options.command = script(text);
    options.frames = 3;
    options.fps = 12;
    options.time_limit = time_limit;
    options.seed = 41;
    ImageF first(24, 16, 3, 0.25f);
    return generate_video(options, first, camera_of(24, 16), folder / "work");
  }
};

TEST_F(ExternalModels, FramesThatAreThereForTheSamePurposeAreReadAgain) {
  GenerateOptions options;
  options.command = script(
      "cd \"$1\"; echo call >> ../calls.txt; for k in 0 1 2; do cp first.png frames/000$k.png; done; [ ! -e ../fails "
      "]");
  options.frames = 3;
  const auto level = [&](const std::string& made_for, float grey) {
    options.made_for = made_for;
    return generate_video(options, ImageF(24, 16, 3, grey), camera_of(24, 16), folder / "work").frames[2](5, 5, 1);
  };
  const auto calls = [&] { return read_text(folder / "calls.txt").size() / 5; };
  EXPECT_NEAR(level("one", 0.2f), 0.2, 0.003);
  EXPECT_NEAR(level("one", 0.6f), 0.2, 0.003);
  EXPECT_EQ(calls(), 1u);
  EXPECT_NEAR(level("other", 0.6f), 0.6, 0.003);
  fs::remove(folder / "work/frames/0001.png");
  EXPECT_FALSE(has_generated(options, folder / "work"));
  EXPECT_NEAR(level("other", 0.4f), 0.4, 0.003);
  EXPECT_EQ(calls(), 3u);
  // What is not known, and what a program failed to make, is made again.
  folder.file("fails", "");
  EXPECT_THROW(level("", 0.8f), Error);
  EXPECT_THROW(level("other", 0.8f), Error);
  EXPECT_FALSE(has_generated(options, folder / "work"));
}

TEST_F(ExternalModels, AGeneratorGetsThePictureTheCameraAndTheRequest) {
  const ReferenceVideo video = generate(
      "cd \"$1\"; cat camera.json request.json > seen.txt; for k in 0 1 2; do cp first.png frames/000$k.png; done; cp "
      "first.png frames/0003.png");
  ASSERT_EQ(video.frames.size(), 3u);
  EXPECT_DOUBLE_EQ(video.fps, 12);
  EXPECT_NEAR(video.frames[2](5, 5, 1), 0.25, 0.003);
  EXPECT_EQ(video.warnings.size(), 1u);
  const std::string seen = read_text(folder / "work/seen.txt");
  for (const char* word :
       {"view_a", "cam_from_world", "\"frames\": 3", "\"seed\": 41", "\"width\": 24", "frames/%04d.png"})
    EXPECT_NE(seen.find(word), std::string::npos) << word;
}

TEST_F(ExternalModels, WhatAGeneratorDoesWrongIsSaid) {
  expect_error(Failure::kInput, {"exit code 3", "out of memory"}, [&] { generate("echo out of memory >&2; exit 3"); });
  expect_error(Failure::kInput, {"0001.png", "is missing", "1 images"},
               [&] { generate("cp \"$1/first.png\" \"$1/frames/0000.png\""); });
  write_image(folder / "small.png", ImageF(8, 8, 3));
  expect_error(Failure::kInput, {"0000.png", "8 x 8", "24 x 16"},
               [&] { generate("cp \"$1/../small.png\" \"$1/frames/0000.png\""); });
  expect_error(Failure::kInput, {"0000.png"}, [&] { generate("echo no picture > \"$1/frames/0000.png\""); });
  const auto start = std::chrono::steady_clock::now();
  expect_error(Failure::kInput, {"within 0.3 s"}, [&] { generate("sleep 30 & sleep 30", 0.3); });
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 10);
  GenerateOptions options;
  options.command = "/no/such/program";
  expect_error(Failure::kInput, {"exit code 127"},
               [&] { generate_video(options, ImageF(24, 16, 3), camera_of(24, 16), folder / "work"); });
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
  options.command = "PYTHONPATH=" + (folder / "modules").string() +
                    " python3 " PLIANT_SOURCE_DIR "/fitting/fit/adapters/stable_video_diffusion.py";
  options.frames = 4;
  options.seed = 5;
  const ReferenceVideo video = generate_video(options, ImageF(24, 16, 3, 0.5f), camera_of(24, 16), folder / "work");
  EXPECT_EQ(video.frames.size(), 4u);
  options.frames = 99;
  expect_error(Failure::kInput, {"exit code 1", "at most 25"},
               [&] { generate_video(options, ImageF(24, 16, 3), camera_of(24, 16), folder / "work"); });
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
    options.command = script(text);
    options.start_limit = 20;
    options.step_limit = limit;
    Guidance guide(options, folder / "work");
    guide.evaluate(frames, 24);
  };
  expect_error(Failure::kInput, {"its start", "exit code 4", "no weights"},
               [&] { run("echo no weights >&2; exit 4"); });
  expect_error(Failure::kInput, {"ready", "2"}, [&] { run("echo '{\"ready\": 2}'; sleep 30"); });
  expect_error(Failure::kInput, {"step 0", "exit code 5"}, [&] { run(ready + "exit 5"); });
  expect_error(Failure::kInput, {"step 0", "within 0.2 s"}, [&] { run(ready + "sleep 30", 0.2); });
  expect_error(Failure::kInput, {"step 0", "too dark"},
               [&] { run(ready + "echo '{\"error\": \"too dark\"}'; read line"); });
  expect_error(Failure::kInput, {"NUMBER"}, [&] { run(ready + "echo '{\"step\": 1, \"loss\": 2}'; read line"); });
  expect_error(Failure::kInput, {"nothing", "576 bytes"},
               [&] { run(ready + "echo '{\"step\": 0, \"loss\": 2}'; read line"); });
  expect_error(Failure::kInput, {"5 bytes", "576"},
               [&] { run(ready + "echo four > gradient.f32; echo '{\"step\": 0, \"loss\": 2}'; read line"); });
  const std::string all_ones = "head -c 576 /dev/zero | tr '\\000' '\\377' > gradient.f32; ";
  expect_error(Failure::kInput, {"not finite", "frame 0"},
               [&] { run(ready + all_ones + "echo '{\"step\": 0, \"loss\": 2}'; read line"); });
  expect_error(Failure::kInput, {"its answer"}, [&] { run(ready + "echo '{broken'; read line"); });
}

/// A pipeline whose latents are means of 8 x 8 pixels and whose model knows one video for each prompt: grey levels 0.3
/// and 0.1.
const char* const kPipeline = R"(
import os, types, torch
MIX = torch.tensor([[1.0, 0.5, 0.0], [0.0, 1.0, -0.5], [0.25, 0.0, 1.0], [1.0, -1.0, 1.0]])
SCALE = 0.5
def encode(x): return torch.einsum('kc,tchw->tkhw', MIX, torch.nn.functional.avg_pool2d(x, 8))
class Vae(torch.nn.Module):
    config = types.SimpleNamespace(scaling_factor=SCALE)
    def encode(self, x):
        assert x.shape[2] % 64 == 0 and x.shape[3] % 64 == 0 and len(x) <= 2
        return types.SimpleNamespace(latent_dist=types.SimpleNamespace(mode=lambda: encode(x)))
class Unet(torch.nn.Module):
    def __init__(self):
        super().__init__()
        self.weight = torch.nn.Parameter(torch.zeros(1))
    def forward(self, noisy, t, encoder_hidden_states):
        assert not torch.is_grad_enabled() and noisy.shape[:3] == (2, 4, 3) and t.dtype == torch.int64
        a = DiffusionPipeline.scheduler.alphas_cumprod[t]
        grey = encoder_hidden_states.reshape(2, 1, 1, 1, 1)
        known = SCALE * (2 * grey - 1) * MIX.sum(1).reshape(1, 4, 1, 1, 1).expand_as(noisy)
        noise = (noisy - a ** 0.5 * known) / (1 - a) ** 0.5
        kind = DiffusionPipeline.scheduler.config.prediction_type
        return types.SimpleNamespace(sample=a ** 0.5 * noise - (1 - a) ** 0.5 * known if kind == 'v_prediction' else noise)
class DiffusionPipeline:
    scheduler = types.SimpleNamespace(alphas_cumprod=torch.linspace(0.9, 0.1, 101),
                                      config=types.SimpleNamespace(num_train_timesteps=101, prediction_type=os.environ['KIND']))
    def __init__(self): self.vae, self.unet = Vae(), Unet()
    @staticmethod
    def from_pretrained(model, torch_dtype=None, variant=None): return DiffusionPipeline()
    def to(self, device): return self
    def encode_prompt(self, prompt, device, num_images_per_prompt, do_classifier_free_guidance, negative_prompt):
        assert prompt == 'it swings' and negative_prompt == '' and do_classifier_free_guidance
        return torch.full((1, 1, 1), 0.3), torch.full((1, 1, 1), 0.1)
)";

std::vector<ImageF> coloured_frames(int width, int height) {
  std::vector<ImageF> frames(3, ImageF(width, height, 3));
  for (size_t t = 0; t < 3; ++t)
    for (size_t i = 0; i < frames[t].data.size(); ++i)
      frames[t].data[i] =
          static_cast<float>(0.5 + 0.4 * std::sin(0.37 * static_cast<double>(i) + 1.3 * static_cast<double>(t)));
  return frames;
}

TEST_F(ExternalModels, ScoreDistillationPullsFramesToWhatTheModelKnows) {
  std::string python;
  for (const char* name : {"/usr/bin/python3", "python3"})
    if (python.empty() &&
        system((std::string(name) + " -W ignore -c 'import numpy, torch' > /dev/null 2>&1").c_str()) == 0)
      python = name;
  if (python.empty()) GTEST_SKIP() << "needs python3 with torch and numpy";
  folder.file("modules/diffusers.py", kPipeline);
  const auto start = [&](const std::string& kind) {
    GuidanceOptions options;
    options.command = "PYTHONDONTWRITEBYTECODE=1 OMP_NUM_THREADS=1 KIND=" + kind +
                      " PYTHONPATH=" + (folder / "modules").string() + " " + python +
                      " -W ignore " PLIANT_SOURCE_DIR
                      "/fitting/fit/adapters/score_distillation.py --prompt 'it swings' --guidance-scale 2 --area 8192 "
                      "--noise 0.5 0.5";
    return std::make_unique<Guidance>(options, folder / kind);
  };
  // The noise leaves no trace: eps_hat - eps = sqrt(a / (1 - a)) (z - z*), with a = 0.5 in the middle of the times and
  // z* of the grey level 0.1 + 2 (0.3 - 0.1).  Through means of 64 pixels, the mix of colours and 2 x - 1:
  const double mix[4][3] = {{1, 0.5, 0}, {0, 1, -0.5}, {0.25, 0, 1}, {1, -1, 1}}, scale = 0.5, grey = 0.5;
  const int width = 128, height = 64;
  const double latents = 3 * 4 * (width / 8) * (height / 8);
  const std::vector<ImageF> frames = coloured_frames(width, height);
  const auto guide = start("epsilon");
  const GuidanceResult result = guide->evaluate(frames, 24);
  double loss = 0, pull = 0;
  for (size_t t = 0; t < 3; ++t)
    for (int v = 0; v < height; v += 8)
      for (int u = 0; u < width; u += 8) {
        double mean[3] = {0, 0, 0}, back[3] = {0, 0, 0};
        for (int k = 0; k < 64; ++k)
          for (int c = 0; c < 3; ++c) mean[c] += frames[t](u + k % 8, v + k / 8, c) / 64;
        for (const auto& row : mix) {
          double away = 0;
          for (int c = 0; c < 3; ++c) away += 2 * scale * row[c] * (mean[c] - grey);
          loss += 0.25 * away * away / latents;
          for (int c = 0; c < 3; ++c) back[c] += 0.5 * away * 2 * scale * row[c] / 64 / latents;
        }
        for (int k = 0; k < 64; ++k)
          for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(result.gradient[t](u + k % 8, v + k / 8, c), back[c], 1e-4 * std::abs(back[c]) + 1e-9);
            pull += back[c] * (frames[t](u + k % 8, v + k / 8, c) - grey);
          }
      }
  EXPECT_NEAR(result.loss, loss, 1e-5 * loss);
  EXPECT_GT(pull, 0);  // against the gradient frames come nearer to it

  // At a = 0.5 it is the derivative of the loss that is told; also through the change of size.
  std::vector<ImageF> small = coloured_frames(50, 30);
  const GuidanceResult there = guide->evaluate(small, 24);
  for (const size_t i : {0u, 1000u, 2222u, 4499u}) {
    float& value = small[1].data[i];
    const float before = value, h = 0.2f;
    value = before + h;
    const double above = guide->evaluate(small, 24).loss;
    value = before - h;
    const double below = guide->evaluate(small, 24).loss;
    value = before;
    EXPECT_NEAR((above - below) / (2 * h), there.gradient[1].data[i], 0.01 * std::abs(there.gradient[1].data[i]) + 2e-8)
        << i;
  }

  // A model of v tells the same; another kind is refused by its name.
  const GuidanceResult of_v = start("v_prediction")->evaluate(frames, 24);
  for (size_t i = 0; i < frames[0].data.size(); i += 97)
    EXPECT_NEAR(of_v.gradient[0].data[i], result.gradient[0].data[i],
                1e-4 * std::abs(result.gradient[0].data[i]) + 1e-9);
  expect_error(Failure::kInput, {"step 0", "prediction_type is flow"}, [&] { start("flow")->evaluate(frames, 24); });
}

}  // namespace
}  // namespace pliant
