// The semantic attribute that trains with the scene: derivatives against finite differences in double, and training of
// a painted ball whose two halves are two objects.

#include "segmentation/field/joint_term.h"

#include <gtest/gtest.h>
#include <omp.h>

#include "gaussians/base/error.h"
#include "gaussians/reconstruct/start_cloud.h"
#include "tests/gaussians/made_photos.h"

namespace pliant {
namespace {

constexpr uint32_t kLeft = 4, kRight = 9;

/// Which half of the ball a pixel shows; 0 beside it.
IdImage halves(const Camera& camera) {
  IdImage ids(camera.width, camera.height, 1, 0);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Vec3d eye = camera.centre(), ray = camera.ray(x + 0.5, y + 0.5);
      const double along = -eye.dot(ray), distance = (eye + along * ray).norm();
      if (distance >= 1) continue;
      const Vec3d hit = eye + (along - std::sqrt(1 - distance * distance)) * ray;
      ids(x, y) = hit.z() > 0 ? kLeft : kRight;
    }
  }
  return ids;
}

TEST(BlendedSemanticLoss, DerivativesFollowFiniteDifferences) {
  const int rows = 9, classes = 3;
  std::vector<double> S(rows * kSemanticChannels);
  for (size_t k = 0; k < S.size(); ++k) S[k] = Random(1, k).normal();
  SemanticModel<double> model;
  model.resize(0, classes);
  for (size_t k = 0; k < model.classifier.size(); ++k) model.classifier[k] = 0.5 * Random(2, k).normal();
  for (int c = 0; c < classes; ++c) model.bias[c] = 0.1 * c;
  const std::vector<int> target = {0, 1, 2, -1, 2, 0, 1, 1, -1};
  const auto value = [&](const std::vector<double>& at, const SemanticModel<double>& with) {
    std::vector<double> ignored(at.size(), 0.0);
    SemanticModel<double> unused = with;
    return blended_semantic_loss_adjoint<double>(at, target, with, ignored, unused);
  };
  std::vector<double> adj(S.size(), 0.0);
  SemanticModel<double> gradient = model;
  gradient.set_zero();
  blended_semantic_loss_adjoint<double>(S, target, model, adj, gradient);
  const double h = 1e-5;
  for (size_t k = 0; k < S.size(); ++k) {
    std::vector<double> up = S, down = S;
    up[k] += h;
    down[k] -= h;
    EXPECT_NEAR(adj[k], (value(up, model) - value(down, model)) / (2 * h), 1e-8);
  }
  for (size_t k = 0; k < model.classifier.size(); ++k) {
    SemanticModel<double> up = model, down = model;
    up.classifier[k] += h;
    down.classifier[k] -= h;
    EXPECT_NEAR(gradient.classifier[k], (value(S, up) - value(S, down)) / (2 * h), 1e-8);
  }
  for (int c = 0; c < classes; ++c) {
    SemanticModel<double> up = model, down = model;
    up.bias[c] += h;
    down.bias[c] -= h;
    EXPECT_NEAR(gradient.bias[c], (value(S, up) - value(S, down)) / (2 * h), 1e-8);
  }
}

class JointTraining : public ::testing::Test {
 protected:
  JointTraining() : photos_(photos_of(painted_ball(300, 5), 12, 56, 44)), threads_(omp_get_max_threads()) {
    omp_set_num_threads(1);  // pictures this small are not worth more
    for (size_t i = 0; i < photos_.photos.size(); ++i) {
      masks_.views.push_back({static_cast<int>(i), halves(photos_.photos[i].camera)});
      if (photos_.photos[i].held_out) joint_.held_out.push_back(static_cast<int>(i));
    }
    options_.iterations = 400;
    options_.most_gaussians = 700;
    options_.refine_every = 20;
    start_ = random_cloud(cameras_of(photos_), 400, 1);
  }

  ~JointTraining() override { omp_set_num_threads(threads_); }

  TrainingPhotos photos_;
  int threads_;
  MaskSet masks_;
  JointOptions joint_;
  TrainOptions options_;
  GaussianCloud start_;
};

TEST_F(JointTraining, LabelsHeldOutPhotosAndKeepsThePictures) {
  const JointTerm term(joint_, masks_);
  Trainer alone(options_, photos_, start_), joint(options_, photos_, start_, &term);
  while (!joint.finished()) {
    alone.step();
    joint.step();
  }
  alone.measure();
  joint.measure();
  EXPECT_GT(joint.state().curve[0].psnr, alone.state().curve[0].psnr - 0.5);

  const Segmentation segmentation = term.result(joint.state(), cameras_of(photos_), {}).segmentation;
  ASSERT_EQ(segmentation.label.size(), joint.state().cloud.size());
  EXPECT_EQ(segmentation.class_id, (std::vector<uint32_t>{kLeft, kRight}));
  std::vector<IdImage> predicted, truth;
  for (int i : joint_.held_out) {
    predicted.push_back(render_ids(segmentation, joint.state().cloud, photos_.photos[i].camera));
    truth.push_back(masks_.views[i].ids);
  }
  EXPECT_GT(id_agreement(predicted, truth).mean, 0.9);
}

TEST(JointTerm, WhatNoPixelWithAnIdShowsTakesTheLabelOfItsNeighbours) {
  // Three bodies side by side, of four balls each.  The third, beside the second, is always under ID 0.
  constexpr int kEach = 4;
  const float place[] = {-1, 0, 0.6f};
  TrainingState state;
  state.cloud.resize(3 * kEach);
  state.attribute.assign(3 * kEach * kSemanticChannels, 0.0f);
  for (int i = 0; i < 3 * kEach; ++i) {
    const int body = i / kEach;
    state.cloud.position[i] = Vec3f(place[body], 0.15f * (static_cast<float>(i % kEach) - 1.5f), 0);
    state.cloud.log_scale[i].setConstant(std::log(0.05f));
    state.cloud.opacity_logit[i] = 3;
    state.attribute[i * kSemanticChannels + (body == 1)] = 1;  // the third one's is that of the first, by chance
  }
  state.shared.assign(2 * (kSemanticChannels + 1), 0.0f);
  state.shared[0] = state.shared[kSemanticChannels + 1] = 10;
  const Camera camera = look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 120, 60, 120);
  IdImage ids(camera.width, camera.height, 1, 0);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const Vec3d eye = camera.centre(), ray = camera.ray(x + 0.5, y + 0.5);
      const double along_x = eye.x() - eye.z() / ray.z() * ray.x();
      ids(x, y) = along_x < -0.5 ? kLeft : along_x < 0.3 ? kRight : 0;
    }
  MaskSet masks;
  masks.views.push_back({0, ids});
  const JointResult result = JointTerm({}, masks).result(state, {camera}, {});
  for (int i = 0; i < 3 * kEach; ++i) {
    EXPECT_EQ(result.segmentation.label[i], i < kEach ? kLeft : kRight) << i;
    EXPECT_EQ(result.segmentation.seen[i], i < 2 * kEach) << i;
  }
  EXPECT_NEAR(result.unlabelled, 1 / 3.0, 0.02);
}

TEST_F(JointTraining, NeverLooksAtMasksThatAreHeldOut) {
  options_.iterations = 12;
  MaskSet spoilt = masks_;
  for (int i : joint_.held_out)
    for (uint32_t& id : spoilt.views[i].ids.data) id = kRight;
  const JointTerm term(joint_, masks_), other(joint_, spoilt);
  Trainer a(options_, photos_, start_, &term), b(options_, photos_, start_, &other);
  while (!a.finished()) {
    a.step();
    b.step();
  }
  EXPECT_EQ(a.state().attribute, b.state().attribute);
  EXPECT_EQ(a.state().shared, b.state().shared);
}

TEST_F(JointTraining, GoesOnFromAState) {
  options_.iterations = 50;
  const JointTerm term(joint_, masks_);
  Trainer whole(options_, photos_, start_, &term), first(options_, photos_, start_, &term);
  while (!whole.finished()) whole.step();
  while (first.state().iteration < 27) first.step();
  Trainer second(options_, photos_, TrainingState(first.state()), &term);
  while (!second.finished()) second.step();
  EXPECT_EQ(whole.state().attribute, second.state().attribute);
  EXPECT_EQ(whole.state().shared, second.state().shared);
  EXPECT_EQ(whole.state().cloud.position, second.state().cloud.position);
  EXPECT_THROW(Trainer(options_, photos_, TrainingState(first.state())), Error);
}

TEST_F(JointTraining, RefusesMasksWithoutIds) {
  for (MaskSet::View& view : masks_.views) std::fill(view.ids.data.begin(), view.ids.data.end(), 0u);
  EXPECT_THROW(JointTerm(joint_, masks_), Error);
}

}  // namespace
}  // namespace pliant
