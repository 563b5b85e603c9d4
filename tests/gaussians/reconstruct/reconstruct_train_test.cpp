// Training recovers scenes that it was shown, from points and from nothing, equal bit for bit for any number of threads
// and over a break; its small parts against closed forms and finite differences.

#include <gtest/gtest.h>
#include <omp.h>

#include "gaussians/base/adam.h"
#include "gaussians/base/error.h"
#include "gaussians/reconstruct/adam_rows.h"
#include "gaussians/reconstruct/exposure.h"
#include "gaussians/reconstruct/schedule.h"
#include "gaussians/reconstruct/start_cloud.h"
#include "tests/check_adjoint.h"
#include "tests/gaussians/made_photos.h"

namespace pliant {
namespace {

/// Pictures this small are not worth more than one thread.
class TrainerOnOneThread : public ::testing::Test {
 protected:
  TrainerOnOneThread() : threads_(omp_get_max_threads()) { omp_set_num_threads(1); }
  ~TrainerOnOneThread() override { omp_set_num_threads(threads_); }

 private:
  int threads_;
};

TrainOptions quick(int iterations, size_t gaussians) {
  TrainOptions options;
  options.iterations = iterations;
  options.most_gaussians = gaussians;
  options.refine_every = 20;
  return options;
}

double trained_psnr(Trainer& trainer) {
  while (!trainer.finished()) trainer.step();
  trainer.measure();
  return trainer.state().curve.back().psnr;
}

void expect_equal(const TrainingState& a, const TrainingState& b) {
  EXPECT_EQ(a.iteration, b.iteration);
  EXPECT_EQ(a.cloud.position, b.cloud.position);
  EXPECT_EQ(a.cloud.rotation, b.cloud.rotation);
  EXPECT_EQ(a.cloud.log_scale, b.cloud.log_scale);
  EXPECT_EQ(a.cloud.opacity_logit, b.cloud.opacity_logit);
  EXPECT_EQ(a.cloud.sh, b.cloud.sh);
  EXPECT_EQ(a.exposure, b.exposure);
}

TEST(AdamRows, FollowAdamInEveryColumn) {
  std::vector<float> x(12, 1.0f), y = x, g(12);
  Moments moments;
  moments.resize(12);
  Adam<float> adam(12, 0.9f, 0.999f, 1e-15f);
  for (int step = 1; step <= 20; ++step) {
    for (size_t k = 0; k < 12; ++k) g[k] = std::sin(0.7f * step + k);
    adam_rows(x, g, std::vector<float>(3, 0.01f), step, moments);
    adam.step(y, g, 0.01f);
  }
  for (size_t k = 0; k < 12; ++k) EXPECT_NEAR(x[k], y[k], 1e-5);
  const std::vector<float> before = x;
  adam_rows(x, g, std::vector<float>{0.0f, 0.01f, 0.0f}, 21, moments);
  EXPECT_EQ(x[3], before[3]);
  EXPECT_NE(x[4], before[4]);
}

TEST(Exposure, DerivativesFollowFiniteDifferences) {
  Image<double> color(5, 4, 3), adj(5, 4, 3);
  std::vector<double> exposure(kExposureSize);
  for (size_t k = 0; k < color.data.size(); ++k) {
    color.data[k] = Random(1, k).uniform();
    adj.data[k] = Random(2, k).normal();
  }
  for (int k = 0; k < kExposureSize; ++k) exposure[k] = kNeutralExposure[k] + 0.2 * Random(3, k).normal();
  const auto value = [&](const Image<double>& image, const std::vector<double>& M) {
    const Image<double> out = expose(image, M.data());
    double sum = 0;
    for (size_t k = 0; k < out.data.size(); ++k) sum += out.data[k] * adj.data[k];
    return sum;
  };
  Image<double> adj_color = adj;
  std::vector<double> adj_exposure(kExposureSize, 0.0);
  expose_adjoint(color, exposure.data(), adj_color, adj_exposure.data());
  const double h = 1e-5;
  for (int k = 0; k < kExposureSize; ++k) {
    std::vector<double> up = exposure, down = exposure;
    up[k] += h;
    down[k] -= h;
    EXPECT_NEAR(adj_exposure[k], (value(color, up) - value(color, down)) / (2 * h), 1e-6);
  }
  for (size_t k = 0; k < color.data.size(); ++k) {
    Image<double> up = color, down = color;
    up.data[k] += h;
    down.data[k] -= h;
    EXPECT_NEAR(adj_color.data[k], (value(up, exposure) - value(down, exposure)) / (2 * h), 1e-6);
  }
}

TEST(Exposure, IsFoundAgainByLeastSquares) {
  ImageF color(20, 15, 3);
  for (size_t k = 0; k < color.data.size(); ++k) color.data[k] = static_cast<float>(Random(4, k).uniform());
  const float truth[kExposureSize] = {0.8f, 0.1f, 0, 0.05f, 0, 1.1f, 0.02f, -0.1f, 0.03f, 0, 0.7f, 0};
  ImageF target = expose(color, truth), weight(20, 15, 1, 1.0f);
  target(3, 3, 0) = 50;
  weight(3, 3) = 0;
  const auto found = fit_exposure(color, target, weight);
  for (int k = 0; k < kExposureSize; ++k) EXPECT_NEAR(found[k], truth[k], 1e-5);
}

TEST(Schedule, RunsThroughTheSameStagesWhateverTheLength) {
  TrainOptions options;
  options.iterations = 1000;
  EXPECT_DOUBLE_EQ(training_progress(options, 250, 99), 0.25);
  options.seconds = 60;
  EXPECT_DOUBLE_EQ(training_progress(options, 250, 30), 0.5);
  EXPECT_NEAR(exponential_rate(1e-2f, 1e-4f, 0.5), 1e-3f, 1e-8);
  EXPECT_EQ(sh_degree_at(options, 0), 0);
  EXPECT_EQ(sh_degree_at(options, 0.1), 3);
  EXPECT_EQ(level_at(options, 0.0, 960), 2);
  EXPECT_EQ(level_at(options, 0.2, 960), 1);
  EXPECT_EQ(level_at(options, 0.9, 960), 0);
  EXPECT_EQ(level_at(options, 0.0, 420), 1);
  EXPECT_EQ(planned_gaussians(options, 100, 10000, 0.0), 100u);
  EXPECT_EQ(planned_gaussians(options, 100, 10000, options.grow_until), 10000u);
  EXPECT_NEAR(
      static_cast<double>(planned_gaussians(options, 100, 10000, 0.5 * (options.refine_from + options.grow_until))),
      1000, 1);
  EXPECT_EQ(planned_gaussians(options, 500, 100, 1.0), 500u);
}

TEST(StartCloud, RandomOneFillsWhatTheCamerasLookAt) {
  const TrainingPhotos photos = photos_of(painted_ball(10, 1), 12, 64, 48);
  const GaussianCloud cloud = random_cloud(cameras_of(photos), 4000, 1);
  const Box box = cloud.bounds();
  EXPECT_LT(box.centre().norm(), 0.1);
  EXPECT_NEAR(box.size().x() / 2, 3.5 / (2 * 1.3), 0.25);  // distance times half the field of view
}

TEST(StartCloud, PointsKeepTheirColourAndReachTheirNeighbours) {
  std::vector<Vec3f> position, color;
  for (int i = 0; i < 64; ++i) {
    position.emplace_back(i % 4, i / 4 % 4, i / 16);
    color.emplace_back(0.25f, 0.5f, i / 64.0f);
  }
  const GaussianCloud cloud = cloud_from_points(position, color);
  for (int i = 0; i < 64; ++i) {
    EXPECT_NEAR(std::exp(cloud.log_scale[i].x()), 1, 1e-5);
    EXPECT_NEAR(0.5f + kSh0 * cloud.sh_of(i)[2], i / 64.0f, 1e-6);
  }
}

TEST_F(TrainerOnOneThread, RecoversAScenesPhotosFromRandomGaussians) {
  const TrainingPhotos photos = photos_of(painted_ball(300, 5), 12, 56, 44);
  for (const Densification strategy : {Densification::kMcmc, Densification::kClassic}) {
    TrainOptions options = quick(400, 900);
    options.densification = strategy;
    options.resets = 0;
    Trainer trainer(options, photos, random_cloud(cameras_of(photos), 400, 1));
    trainer.measure();
    const double before = trainer.state().curve[0].psnr, after = trained_psnr(trainer);
    EXPECT_GT(after, 20) << static_cast<int>(strategy);
    EXPECT_GT(after, before + 8) << static_cast<int>(strategy);
    EXPECT_LE(trainer.state().cloud.size(), 900u);
    EXPECT_GT(trainer.state().cloud.size(), 400u);
    EXPECT_EQ(trainer.state().cloud.sh_degree, 3);
  }
}

TEST_F(TrainerOnOneThread, ExposureTakesUpHowBrightAPhotoIs) {
  TrainingPhotos photos = photos_of(painted_ball(200, 6), 12, 40, 32);
  for (size_t i = 1; i < photos.photos.size(); i += 2)
    for (uint8_t& value : photos.photos[i].pixels.data) value = static_cast<uint8_t>(0.6 * value);
  for (TrainingPhoto& photo : photos.photos) photo.held_out = false;
  TrainOptions options = quick(500, 400);
  options.exposure = true;
  options.exposure_rate = 0.05f;  // each photo is shown 40 times only
  options.sh_degree = 0;          // else colours that depend on the view take it up
  Trainer trainer(options, photos, random_cloud(cameras_of(photos), 300, 1));
  while (!trainer.finished()) trainer.step();
  const auto shown_grey = [&](size_t photo) {
    const ImageF grey = expose(ImageF(1, 1, 3, 0.5f), trainer.state().exposure.data() + photo * kExposureSize);
    return (grey.data[0] + grey.data[1] + grey.data[2]) / 3;
  };
  double bright = 0, dark = 0;
  for (size_t i = 0; i < 12; ++i) (i % 2 ? dark : bright) += shown_grey(i) / 6;
  EXPECT_NEAR(dark / bright, 0.6, 0.08);
}

TEST(Trainer, IsEqualBitForBitForAnyThreadCountAndOverABreak) {
  const TrainingPhotos photos = photos_of(painted_ball(200, 7), 9, 48, 40);
  const int threads_before = omp_get_max_threads();
  for (const Densification strategy : {Densification::kMcmc, Densification::kClassic}) {
    TrainOptions options = quick(90, 600);
    options.densification = strategy;
    options.exposure = true;
    options.screen_gradient = 1e-5f;
    const GaussianCloud start = random_cloud(cameras_of(photos), 300, 1);
    omp_set_num_threads(1);
    Trainer one(options, photos, start);
    while (!one.finished()) one.step();
    for (const int threads : {2, 3}) {
      omp_set_num_threads(threads);
      Trainer other(options, photos, start);
      while (other.state().iteration < 53) other.step();
      Trainer resumed(options, photos, TrainingState(other.state()));
      while (!resumed.finished()) resumed.step();
      expect_equal(one.state(), resumed.state());
    }
  }
  omp_set_num_threads(threads_before);
}

TEST_F(TrainerOnOneThread, DoesNotLearnFromPixelsThatDoNotCount) {
  TrainingPhotos photos = photos_of(painted_ball(200, 8), 8, 48, 40);
  for (TrainingPhoto& photo : photos.photos) {
    photo.weight = ImageU8(48, 40, 1, 255);
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 10; ++x) photo.weight(x, y) = 0;
  }
  TrainingPhotos spoilt = photos;
  for (TrainingPhoto& photo : spoilt.photos)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 10; ++x)
        for (int c = 0; c < 3; ++c) photo.pixels(x, y, c) = 255;
  const TrainOptions options = quick(40, 300);
  const GaussianCloud start = random_cloud(cameras_of(photos), 300, 1);
  Trainer a(options, photos, start), b(options, spoilt, start);
  while (!a.finished()) {
    a.step();
    b.step();
  }
  expect_equal(a.state(), b.state());
}

/// Photos of `cloud` before black with its opacity as their alpha.
TrainingPhotos cut_out_photos(const GaussianCloud& cloud) {
  TrainingPhotos photos = photos_of(cloud, 12, 48, 40);
  for (TrainingPhoto& photo : photos.photos) {
    const ImageF alpha = render(cloud, photo.camera).alpha;
    photo.alpha = ImageU8(48, 40, 1);
    for (size_t i = 0; i < alpha.data.size(); ++i)
      photo.alpha.data[i] = static_cast<uint8_t>(255 * alpha.data[i] + 0.5f);
  }
  return photos;
}

TEST_F(TrainerOnOneThread, AHoleStaysOpenOnlyWhenTheColourBehindItChanges) {
  // A thick ring, and what would be invisible before black: a dark plug in its hole.
  GaussianCloud ring = painted_ball(500, 10);
  for (int i = 0; i < 500; ++i) {
    const double turn = 0.0125663706 * i;
    const Vec3f out(std::cos(turn), 0, std::sin(turn));
    ring.position[i] = out + 0.15f * (i % 3 - 1) * Vec3f(0, 1, 0);
    ring.log_scale[i].setConstant(std::log(0.1f));
  }
  GaussianCloud plugged = ring;
  GaussianCloud plug = painted_ball(80, 11);
  for (int i = 0; i < 80; ++i) {
    plug.position[i] = plug.position[i].cwiseProduct(Vec3f(0.35f, 0.05f, 0.35f));
    plug.log_scale[i].setConstant(std::log(0.12f));
    for (int c = 0; c < 3; ++c) plug.sh_of(i)[c] = -0.5f / kSh0;
  }
  plugged.append(plug);
  // Only views through the hole: from the side the plug hides the far part of the ring and would have to go in any
  // case.
  TrainingPhotos photos = cut_out_photos(ring);
  std::erase_if(photos.photos, [](const TrainingPhoto& photo) { return std::abs(photo.camera.centre().y()) < 3; });
  const Camera front = look_at({0, 3.5, 0}, {0, 0, 0}, {0, 0, 1}, 48, 40, 62);
  for (const bool changing : {true, false}) {
    TrainOptions options = quick(150, 1000);
    options.densification = Densification::kNone;
    options.changing_backdrop = changing;
    Trainer trainer(options, photos, plugged);
    while (!trainer.finished()) trainer.step();
    const ImageF alpha = render(trainer.state().cloud, front).alpha;
    if (changing)
      EXPECT_LT(alpha(24, 20), 0.05f);
    else
      EXPECT_GT(alpha(24, 20), 0.9f);
    EXPECT_GT(alpha(24 + 18, 20), 0.8f);  // the ring
  }
}

TEST_F(TrainerOnOneThread, OpacitiesAreResetWhereTimeBetweenTwoStepsLeadsOverTheMark) {
  const TrainingPhotos photos = photos_of(painted_ball(50, 9), 4, 24, 20);
  TrainOptions options = quick(1, 100);
  options.densification = Densification::kClassic;
  options.seconds = 1e6;
  Trainer trainer(options, photos, random_cloud(cameras_of(photos), 50, 1));
  const auto most_opacity = [&] {
    const std::vector<float>& logits = trainer.state().cloud.opacity_logit;
    return *std::max_element(logits.begin(), logits.end());
  };
  const double mark = options.seconds * options.grow_until / (options.resets + 1);
  const float reset = std::log(0.01f / 0.99f) + 1e-4f;
  // What passed before the first step is no training.
  trainer.spend(1.5 * mark);
  trainer.step();
  EXPECT_GT(most_opacity(), reset);
  trainer.spend(mark);
  trainer.step();
  EXPECT_LE(most_opacity(), reset);
}

TEST_F(TrainerOnOneThread, TheCurveMeasuresAFewHeldOutPhotosEvenlySpread) {
  const GaussianCloud cloud = painted_ball(50, 9);
  TrainingPhotos photos = photos_of(cloud, 26, 24, 20);
  for (size_t i = 0; i < photos.photos.size(); ++i) photos.photos[i].held_out = i < 24;
  const std::vector<PhotoQuality> few = held_out_quality(cloud, photos, {}, 8);
  ASSERT_EQ(few.size(), 8u);
  for (size_t i = 0; i < 8; ++i) EXPECT_EQ(few[i].name, "photo_" + std::to_string(3 * i));
  EXPECT_EQ(held_out_quality(cloud, photos, {}, 30).size(), 24u);
  EXPECT_EQ(held_out_quality(cloud, photos, {}).size(), 24u);
  Trainer trainer(quick(5, 100), photos, cloud);
  trainer.measure();
  double mean = 0;
  for (const PhotoQuality& q : few) mean += q.psnr / 8;
  EXPECT_NEAR(trainer.state().curve.at(0).psnr, mean, 1e-9);
}

TEST_F(TrainerOnOneThread, RefusesPhotosThatAreAllHeldOutAndStatesOfOtherPhotos) {
  TrainingPhotos photos = photos_of(painted_ball(50, 9), 4, 48, 40);
  TrainOptions options = quick(5, 100);
  options.exposure = true;
  Trainer trainer(options, photos, random_cloud(cameras_of(photos), 50, 1));
  TrainingPhotos more = photos;
  more.photos.push_back(photos.photos[1]);
  EXPECT_THROW(Trainer(options, more, TrainingState(trainer.state())), Error);
  for (TrainingPhoto& photo : photos.photos) photo.held_out = true;
  EXPECT_THROW(Trainer(options, photos, random_cloud(cameras_of(photos), 50, 1)), Error);
}

}  // namespace
}  // namespace pliant
