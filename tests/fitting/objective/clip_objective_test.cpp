// What a clip is compared with, beside points that are followed: its pictures, its optical flow, and what another
// program thinks of the drawn motion.

#include "fitting/objective/clip_objective.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "fitting/fields/part_field.h"
#include "fitting/fit/fit_clip.h"
#include "gaussians/base/error.h"
#include "tests/fitting/made_motion.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using namespace fixture;

constexpr int kFrames = 8;

/// A block that swings, filmed, and the same with another stiffness to begin with.
struct Filmed {
  Motion<float> truth = swinging_block<float>(kFrames, 3e4), motion = swinging_block<float>(kFrames, 1.5e4);
  std::shared_ptr<DrawnObject<float>> drawn = drawn_block<float>(truth.particles, 300, 0.1);
  Camera camera;
  SeenFrames<float> seen = film<float, true>(truth, *drawn, camera);
  ClipFrames frames{0, kFrames, 0, 1, 100};
  ClipTerms terms;

  explicit Filmed(int size = 1) : camera(block_camera(64 * size, 56 * size, 0.1)) {
    terms.drawn = drawn;
    terms.seen = {seen};
    terms.track_weight = 0;
  }

  /// ln of the factor of E that gradients find; 0.69 is right.
  double found(int iterations = 25, double first_window = kFrames) const {
    ClipFitOptions options;
    options.material = std::make_shared<PartField>(motion.particles.size(), 1);
    options.damping = false;
    options.gradient.iterations = iterations;
    options.gradient.material_rate = 0.08;
    options.gradient.first_window = static_cast<int>(first_window);
    options.gradient.noisy = terms.guide != nullptr;
    const ClipFit fit = fit_clip(options, motion, clip_objective(terms, nullptr, frames), {});
    return std::log(fit.motion.particles.young[0] / motion.particles.young[0]);
  }
};

TEST(ClipObjective, PicturesAloneFindTheStiffness) {
  Filmed filmed;
  filmed.terms.picture_weight = 1;
  EXPECT_NEAR(filmed.found(), std::log(2.0), 0.1);
}

TEST(ClipObjective, PoissonsRatioIsFoundWithTheStiffness) {
  // Tracks of exact places, since pictures say little of it.
  Filmed filmed;
  for (float& nu : filmed.truth.particles.poisson) nu = 0.42f;
  PointTracks tracks;
  for (int k = 0; k < 16; ++k)
    tracks.rest.push_back(Vec3f(0.02f * static_cast<float>(k % 2), 0.02f * static_cast<float>(k / 2 % 2),
                                0.01f + 0.008f * static_cast<float>(k / 4)));
  std::vector<Vec3f> drivers(filmed.truth.particles.position);
  const BodyPoints<float> points(tracks.rest, drivers, 1);
  for (const auto& state :
       rollout<float>(filmed.truth.options, filmed.truth.particles, filmed.truth.interactions, filmed.truth.start)
           .frames) {
    tracks.weight.emplace_back(16, 1.0);
    tracks.place.emplace_back();
    for (const Vec3f& X : points.positions(state)) tracks.place.back().push_back(X.cast<double>());
  }
  ClipFitOptions options;
  options.material = options.poisson = std::make_shared<PartField>(drivers.size(), 1);
  options.damping = false;
  options.gradient.iterations = 60;
  options.gradient.material_rate = 0.06;
  options.gradient.poisson_rate = 0.1;
  options.gradient.first_window = kFrames;
  Objective<float> objective;
  objective.terms.push_back({1e6, std::make_shared<TrackLoss<float>>(tracks, drivers, 1, 1e-2)});
  const Particles found = fit_clip(options, filmed.motion, objective, {}).motion.particles;
  EXPECT_NEAR(std::log(found.young[0] / 3e4), 0, 0.05);
  EXPECT_NEAR(found.poisson[0], 0.42, 0.03);
}

TEST(ClipObjective, FlowAloneFindsTheStiffness) {
  Filmed filmed;
  filmed.terms.flow_weight = 1;
  EXPECT_NEAR(filmed.found(), std::log(2.0), 0.2);
}

TEST(ClipObjective, AShortGradientWindowStillFindsTheStiffness) {
  Filmed filmed;
  filmed.terms.picture_weight = 1;
  filmed.motion.options.gradient_window = 3;
  EXPECT_NEAR(filmed.found(), std::log(2.0), 0.15);
}

TEST(ClipObjective, WhatIsCutAwayDoesNotCount) {
  Filmed filmed;
  ImageF weight(64, 56, 1, 0.0f);
  for (int y = 18; y < 30; ++y)
    for (int x = 20; x < 41; ++x) weight(x, y) = 0.5f + 0.01f * static_cast<float>(x);
  SeenFrames<float> whole = filmed.seen;
  whole.weight = {weight};
  const SeenFrames<float> part = cut_to_weight(filmed.camera, filmed.seen.frames, {&weight, 1});
  EXPECT_EQ(part.camera.width, 21 + 12);
  EXPECT_EQ(part.camera.height, 12 + 12);
  Objective<float> a, b;
  a.terms.push_back({1, std::make_shared<PictureLoss<float>>(PictureLossOptions{}, filmed.drawn, whole)});
  b.terms.push_back({1, std::make_shared<PictureLoss<float>>(PictureLossOptions{}, filmed.drawn, part)});
  const MotionGradient<float> by_a = motion_loss_adjoint(filmed.motion, a),
                              by_b = motion_loss_adjoint(filmed.motion, b);
  EXPECT_GT(by_a.loss, 1e-3);
  EXPECT_NEAR(by_b.loss, by_a.loss, 1e-4 * by_a.loss);
  double size = 0, difference = 0;
  for (size_t i = 0; i < filmed.motion.particles.size(); ++i) {
    size += std::abs(by_a.by.young[i]);
    difference += std::abs(by_a.by.young[i] - by_b.by.young[i]);
  }
  EXPECT_LT(difference, 1e-3 * size);
  const ImageF none(64, 56, 1, 0.0f);
  EXPECT_THROW(cut_to_weight(filmed.camera, filmed.seen.frames, {&none, 1}), Error);
}

TEST(ClipObjective, WhatAFrameHidesIsLeftOutOfThatFrameAlone) {
  constexpr int kDark = 3, kHalf = 5;  // frames, hidden wholly and in their upper half
  Filmed filmed;
  const auto hidden = [](int frame, int y) { return frame == kDark || (frame == kHalf && y < 28); };
  std::vector<ImageF> weight(kFrames + 1, ImageF(64, 56, 1, 0.0f));
  for (int f = 0; f <= kFrames; ++f)
    for (int y = 10; y < 46; ++y)
      for (int x = 12; x < 52; ++x) weight[f](x, y) = !hidden(f, y);
  // Every other frame of the roll-out shows one of the video.
  filmed.motion.options.simulate.fps *= 2;
  filmed.motion.options.simulate.substeps /= 2;
  filmed.frames.every = 2;
  filmed.terms.picture_weight = 1;
  filmed.terms.picture.photometric = {1, 0};
  const auto loss_with_other = [&](int frame) {
    std::vector<ImageF> pictures = filmed.seen.frames;
    for (int y = 0; y < 56 && frame >= 0; ++y)
      for (int x = 0; x < 64; ++x)
        for (int c = 0; c < 3; ++c) pictures[frame](x, y, c) += y < 28 ? 1.0f : 0.0f;
    filmed.terms.seen = {cut_to_weight(filmed.camera, pictures, weight)};
    return motion_loss(filmed.motion, clip_objective(filmed.terms, nullptr, filmed.frames));
  };
  const double clean = loss_with_other(-1);
  for (const int frame : {kDark, kHalf}) EXPECT_NEAR(loss_with_other(frame), clean, 1e-9) << frame;
  EXPECT_GT(loss_with_other(kHalf - 1), clean + 0.01);

  const SeenFrames<float> seen = cut_to_weight(filmed.camera, filmed.seen.frames, weight);
  for (int f = 0; f <= kFrames; ++f) EXPECT_EQ(seen.frames[f].empty(), f == kDark) << f;
  const SeenFlow<float> flow = flow_of_clip(seen, {0, kFrames, 0, 1, 100});
  EXPECT_EQ(flow.pairs.size(), kFrames - 2u);
  const int upper = 28 - (56 - seen.camera.height) / 2;  // rows of the cut
  for (const auto& pair : flow.pairs) {
    EXPECT_TRUE(pair.from != kDark && pair.to != kDark);
    float most = 0;
    for (int y = 0; y < upper; ++y)
      for (int x = 0; x < seen.camera.width; ++x) most = std::max(most, pair.weight(x, y));
    EXPECT_EQ(most > 0, pair.from != kHalf && pair.to != kHalf) << pair.from;
  }
  for (ImageF& w : weight) w.data.assign(w.data.size(), 0.0f);
  expect_error(Failure::kInput, {"video", "--video-mask"},
               [&] { cut_to_weight(filmed.camera, filmed.seen.frames, weight); });
}

TEST(ClipObjective, FlowOfFilmedFramesIsWhatIsDrawn) {
  Filmed filmed(3);
  const auto loss_of = [&](const Motion<float>& motion) {
    Objective<float> objective;
    objective.whole.push_back(
        {1, std::make_shared<FlowLoss<float>>(filmed.drawn, flow_of_clip(filmed.seen, filmed.frames), 1)});
    return motion_loss(motion, objective);
  };
  Motion<float> still = filmed.truth;
  for (Vec3f& v : still.start.v) v.setZero();
  EXPECT_LT(loss_of(filmed.truth), 0.25 * loss_of(still));
  EXPECT_LT(loss_of(filmed.truth), 0.6 * loss_of(filmed.motion));
}

/// Loss and gradient of half the mean square difference from the clip in truth.f32.
const char* const kPull = R"(
import array, json, sys
folder = sys.argv[1]
truth = array.array('f'); truth.frombytes(open(folder + '/../truth.f32', 'rb').read())
print(json.dumps({'ready': 1, 'name': 'pull'}), flush=True)
for line in sys.stdin:
    request = json.loads(line)
    if 'quit' in request: break
    frames = array.array('f'); frames.frombytes(open(folder + '/frames.f32', 'rb').read())
    n = len(frames)
    assert n == len(truth) and request['fps'] == 100
    pull = array.array('f', [(a - b) / n for a, b in zip(frames, truth)])
    pull.tofile(open(folder + '/gradient.f32', 'wb'))
    print(json.dumps({'step': request['step'], 'loss': 0.5 * n * sum(p * p for p in pull)}), flush=True)
)";

TEST(ClipObjective, AProgramThatPullsPixelsToAClipLeadsToItsStiffness) {
  if (system("command -v python3 > /dev/null") != 0) GTEST_SKIP() << "python3 is not installed";
  TemporaryFolder folder;
  Filmed filmed;
  std::ofstream truth(folder / "truth.f32", std::ios::binary);
  for (const ImageF& frame : filmed.seen.frames)
    for (const float value : frame.data) {
      const float clamped = std::clamp(value, 0.0f, 1.0f);
      truth.write(reinterpret_cast<const char*>(&clamped), sizeof clamped);
    }
  truth.close();
  GuidanceOptions options;
  options.command = "python3 " + folder.file("pull.py", kPull).string();
  filmed.terms.guide = std::make_shared<Guidance>(options, folder / "work");
  filmed.terms.guide_weight = 100;
  filmed.terms.guide_camera = filmed.camera;
  EXPECT_NEAR(filmed.found(20), std::log(2.0), 0.15);
}

/// Its loss is the number of values that are clamped at 1 ("bright"), or that are not; its gradient is 1 there.
const char* const kBright = R"(
import array, json, sys
wanted, folder = sys.argv[1] == 'bright', sys.argv[2]
print(json.dumps({'ready': 1, 'name': 'bright'}), flush=True)
for line in sys.stdin:
    request = json.loads(line)
    if 'quit' in request: break
    frames = array.array('f'); frames.frombytes(open(folder + '/frames.f32', 'rb').read())
    pull = array.array('f', [(value == 1) == wanted for value in frames])
    pull.tofile(open(folder + '/gradient.f32', 'wb'))
    print(json.dumps({'step': request['step'], 'loss': sum(pull)}), flush=True)
)";

TEST(ClipObjective, WhatIsBrighterThanTheProgramSeesFollowsNoGradient) {
  if (system("command -v python3 > /dev/null") != 0) GTEST_SKIP() << "python3 is not installed";
  const TemporaryFolder folder;
  const Filmed filmed;
  for (int k = 0; k < 3; ++k) filmed.drawn->object.sh_of(0)[k] = 30;
  const std::string program = "python3 " + folder.file("bright.py", kBright).string();
  const auto pull_of = [&](const std::string& values) {
    GuidanceOptions options;
    options.command = program + " " + values;
    const GuidanceLoss loss(std::make_shared<Guidance>(options, folder / values), filmed.drawn, filmed.camera, {});
    StateGradient<float> gradient = StateGradient<float>::zero(filmed.motion.start.size());
    EXPECT_GT(loss.value_adjoint(std::span(&filmed.motion.start, 1), 1, std::span(&gradient, 1)), 10) << values;
    float sum = 0;
    for (const Vec3f& x : gradient.x) sum += x.cwiseAbs().sum();
    return sum;
  };
  EXPECT_EQ(pull_of("bright"), 0);
  EXPECT_GT(pull_of("others"), 0);
}

}  // namespace
}  // namespace pliant
