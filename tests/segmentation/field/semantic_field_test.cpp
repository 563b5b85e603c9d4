// The semantic attribute on scenes with known truth: recovery from noise and from the vote, order, threads, wide ids.

#include "segmentation/field/semantic_field.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <set>

#include "segmentation/field/vote.h"
#include "segmentation/labels/agreement.h"
#include "segmentation/select/selection.h"
#include "tests/segmentation/made_scene.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

constexpr int kY = kSemanticChannels;

/// mIoU on views 0 and 5, which are held out.
double held_out_miou(const MadeScene& scene, const Segmentation& segmentation) {
  std::vector<IdImage> predicted, truth;
  for (int v : {0, 5}) {
    predicted.push_back(render_ids(segmentation, scene.cloud, scene.cameras[v]));
    truth.push_back(cast_ids(scene, scene.cameras[v]));
  }
  return id_agreement(predicted, truth).mean;
}

double right_labels(const MadeScene& scene, const Segmentation& segmentation) {
  size_t right = 0;
  for (size_t p = 0; p < scene.truth.size(); ++p) right += segmentation.label[p] == scene.truth[p];
  return static_cast<double>(right) / static_cast<double>(scene.truth.size());
}

/// Masks as true labels draw them with a low-pass filter of this variance [px^2].
MaskSet masks_of_truth(const MadeScene& scene, double screen_variance) {
  Segmentation s;
  s.class_id = cast_masks(scene).ids();
  s.screen_variance = screen_variance;
  const int classes = static_cast<int>(s.class_id.size());
  s.classifier = class_codes(classes, 1);
  s.classifier_bias.assign(classes, 0.0f);
  s.attribute.resize(scene.cloud.size() * kY);
  for (size_t p = 0; p < scene.cloud.size(); ++p)
    std::copy_n(s.classifier.begin() + class_of_id(s, scene.truth[p]) * kY, kY,
                s.attribute.begin() + static_cast<std::ptrdiff_t>(p) * kY);
  MaskSet masks;
  for (size_t c = 0; c < scene.cameras.size(); ++c)
    masks.views.push_back({static_cast<int>(c), render_ids(s, scene.cloud, scene.cameras[c])});
  return masks;
}

SemanticOptions quick_options() {
  SemanticOptions options;
  options.held_out = {0, 5};
  return options;
}

TEST(SemanticField, RandomAttributesReachTheTruthThroughBlendingAlone) {
  const MadeScene scene = made_scene(two_balls());
  SemanticOptions options = quick_options();
  options.start_from_vote = false;
  options.iterations = 100;
  options.attribute_rate = 0.05;
  const SemanticResult result = fit_semantic_field(options, scene.cloud, scene.cameras, cast_masks(scene));
  EXPECT_EQ(result.segmentation.class_id, (std::vector<uint32_t>{3, 300, 70000}));
  EXPECT_GT(held_out_miou(scene, result.segmentation), 0.95);
  EXPECT_GT(right_labels(scene, result.segmentation), 0.97);
}

TEST(SemanticField, VoteAloneAndPolishedAgreeWithTheTruth) {
  const MadeScene scene = made_scene(two_balls());
  const MaskSet masks = cast_masks(scene);
  SemanticOptions options = quick_options();
  options.iterations = 0;
  const double vote = held_out_miou(scene, fit_semantic_field(options, scene.cloud, scene.cameras, masks).segmentation);
  options.iterations = 60;
  const double polished =
      held_out_miou(scene, fit_semantic_field(options, scene.cloud, scene.cameras, masks).segmentation);
  EXPECT_GT(vote, 0.93);
  EXPECT_GT(polished, 0.95);
  EXPECT_GE(polished, vote - 0.003);
}

TEST(SemanticField, SplatsThatStickOutOfTheSilhouetteDoNotTakeTheLabelBehindThem) {
  MadeScene scene = made_scene({{Vec3f(0, 0, 0.5f), 0.3f, 300, Vec3f(0.8f, 0.1f, 0.1f)}});  // a ball in the air
  scene.cameras.clear();  // from one side, so that what lies at the silhouette is met there only
  for (int v = 0; v < 6; ++v)
    scene.cameras.push_back(look_at({2.2, -0.8 + 0.32 * v, 1.1}, {0, 0, 0.1}, {0, 0, 1}, 160, 120, 144));
  std::vector<int> kept;
  std::vector<uint32_t> truth;
  for (size_t p = 0; p < scene.truth.size(); ++p) {
    bool visible = scene.truth[p] == MadeScene::kTable;
    if (!visible) {
      const Vec3f normal = (scene.cloud.position[p] - scene.balls[0].centre).normalized();
      for (const Camera& camera : scene.cameras)
        visible = visible || normal.dot((camera.centre().cast<float>() - scene.cloud.position[p]).normalized()) > -0.1f;
      scene.cloud.position[p] += 0.02f * normal;
    }
    if (visible) {
      kept.push_back(static_cast<int>(p));
      truth.push_back(scene.truth[p]);
    }
  }
  scene.cloud = scene.cloud.select(kept);
  scene.truth = truth;
  const MaskSet masks = cast_masks(scene);
  auto lost = [&](int border) {  // Gaussians of balls labelled table
    SemanticOptions options;
    options.iterations = 0;
    options.border = border;
    const auto labels = fit_semantic_field(options, scene.cloud, scene.cameras, masks).segmentation.label;
    size_t count = 0;
    for (size_t p = 0; p < labels.size(); ++p)
      count += scene.truth[p] != MadeScene::kTable && labels[p] == MadeScene::kTable;
    return count;
  };
  const size_t without = lost(0), with = lost(2);
  EXPECT_GT(without, 20u);
  EXPECT_LT(3 * with, without);
}

TEST(SemanticField, MasksTellWithWhichFilterTheyWereDrawn) {
  const MadeScene scene = made_scene(two_balls());
  const MaskSet drawn = masks_of_truth(scene, 0.3), sharp = masks_of_truth(scene, 0.075);
  const auto found = [&](const MaskSet& masks) {
    return fit_semantic_field(quick_options(), scene.cloud, scene.cameras, masks).segmentation.screen_variance;
  };
  EXPECT_NEAR(found(drawn), 0.3, 1e-9);
  EXPECT_LT(found(sharp), 0.16);
}

TEST(SemanticField, SilhouettesOfSplatsThatStickOutAreDrawnWithASharperFilter) {
  // The Gaussians end at the ball's surface only before the filter widens them.
  MadeScene scene = made_scene(two_balls());
  for (size_t p = 0; p < scene.cloud.size(); ++p) {
    if (scene.truth[p] == MadeScene::kTable) continue;
    const Vec3f& centre = scene.balls[scene.truth[p] == scene.balls[0].id ? 0 : 1].centre;
    scene.cloud.position[p] += 0.012f * (scene.cloud.position[p] - centre).normalized();
  }
  const MaskSet masks = cast_masks(scene);
  SemanticOptions options = quick_options();
  const auto edges = [&](bool find_filter) {
    options.find_filter = find_filter;
    const Segmentation found = fit_semantic_field(options, scene.cloud, scene.cameras, masks).segmentation;
    std::vector<IdImage> predicted, truth;
    for (int v : {0, 5}) {
      predicted.push_back(render_ids(found, scene.cloud, scene.cameras[v]));
      truth.push_back(cast_ids(scene, scene.cameras[v]));
    }
    return boundary_agreement(predicted, truth, 2).mean;
  };
  const double as_colour = edges(false), found = edges(true);
  EXPECT_GT(found, as_colour + 0.02);
}

TEST(SemanticField, OrderOfTheViewsDoesNotMatter) {
  const MadeScene scene = made_scene(two_balls());
  MaskSet masks = cast_masks(scene);
  SemanticOptions options = quick_options();
  options.iterations = 12;
  const auto forwards = fit_semantic_field(options, scene.cloud, scene.cameras, masks).segmentation;
  std::reverse(masks.views.begin(), masks.views.end());
  const auto backwards = fit_semantic_field(options, scene.cloud, scene.cameras, masks).segmentation;
  EXPECT_EQ(forwards.attribute, backwards.attribute);
}

TEST(SemanticField, EqualBitForBitForAnyNumberOfThreadsAndWithoutTheCache) {
  const MadeScene scene = made_scene(two_balls());
  const MaskSet masks = cast_masks(scene);
  SemanticOptions options = quick_options();
  options.iterations = 12;
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const auto one = fit_semantic_field(options, scene.cloud, scene.cameras, masks);
  omp_set_num_threads(3);
  const auto three = fit_semantic_field(options, scene.cloud, scene.cameras, masks);
  options.memory_bytes = 0;
  const auto uncached = fit_semantic_field(options, scene.cloud, scene.cameras, masks);
  omp_set_num_threads(threads);
  EXPECT_EQ(one.segmentation.attribute, three.segmentation.attribute);
  EXPECT_EQ(one.segmentation.classifier, three.segmentation.classifier);
  EXPECT_EQ(one.segmentation.attribute, uncached.segmentation.attribute);
  EXPECT_GT(one.summary.cached_bytes, 0u);
  EXPECT_EQ(uncached.summary.cached_bytes, 0u);
}

TEST(SemanticField, RenderedAttributeEqualsWTimesY) {
  const MadeScene scene = made_scene(two_balls());
  std::vector<float> y(scene.cloud.size() * kY);
  for (size_t i = 0; i < y.size(); ++i) y[i] = static_cast<float>(Random(5, i).normal());
  const RenderResult picture = render(scene.cloud, scene.cameras[1], {}, y, kY);
  const BlendWeights W = blend_weights(scene.cloud, scene.cameras[1]);
  float worst = 0;
  for (size_t pixel = 0; pixel < W.pixels(); ++pixel)
    for (int k = 0; k < kY; ++k) {
      double sum = 0;
      for (uint32_t e = W.row_start[pixel]; e < W.row_start[pixel + 1]; ++e)
        sum += double(W.weight[e]) * y[W.gaussian[e] * kY + k];
      worst = std::max(worst, std::abs(picture.features.data[pixel * kY + k] - static_cast<float>(sum)));
    }
  EXPECT_LT(worst, 1e-5f);
}

TEST(SemanticField, UnseenGaussiansTakeTheirNeighboursLabelAndAreFlagged) {
  MadeScene scene = made_scene(two_balls());
  const size_t first = scene.cloud.size();
  add_disc(scene.cloud, scene.balls[0].centre, Vec3f::UnitZ(), 0.01f, Vec3f::Zero());  // inside the first ball
  add_disc(scene.cloud, scene.balls[1].centre, Vec3f::UnitZ(), 0.01f, Vec3f::Zero());
  SemanticOptions options = quick_options();
  options.iterations = 10;
  const auto result = fit_semantic_field(options, scene.cloud, scene.cameras, cast_masks(scene));
  EXPECT_EQ(result.segmentation.seen[first], 0);
  EXPECT_EQ(result.segmentation.seen[first + 1], 0);
  EXPECT_EQ(result.segmentation.label[first], 300u);
  EXPECT_EQ(result.segmentation.label[first + 1], 70000u);
  EXPECT_GE(result.summary.unseen, 2u);
}

TEST(SemanticField, HeldOutMasksAreNeverLookedAt) {
  const MadeScene scene = made_scene(two_balls());
  MaskSet masks = cast_masks(scene), wrong = masks;
  for (auto& id : wrong.views[5].ids.data) id = 999;
  SemanticOptions options = quick_options();
  options.iterations = 10;
  const auto a = fit_semantic_field(options, scene.cloud, scene.cameras, masks);
  const auto b = fit_semantic_field(options, scene.cloud, scene.cameras, wrong);
  EXPECT_EQ(a.segmentation.attribute, b.segmentation.attribute);
  EXPECT_EQ(b.segmentation.class_id.size(), 3u);
  masks.views.resize(1);
  expect_error(Failure::kInput, {"--hold-out", "masks of other photos"},
               [&] { fit_semantic_field(options, scene.cloud, scene.cameras, masks); });
}

TEST(SemanticField, ObjectsAreListedWithBoundsAndViews) {
  const MadeScene scene = made_scene(two_balls());
  SemanticOptions options;
  options.iterations = 0;
  const auto result = fit_semantic_field(options, scene.cloud, scene.cameras, cast_masks(scene));
  const auto objects = list_objects(result.segmentation, scene.cloud.position);
  ASSERT_EQ(objects.size(), 3u);
  EXPECT_EQ(objects[1].id, 300u);
  EXPECT_EQ(objects[1].views, 10);
  EXPECT_LT((objects[1].bounds.centre() - scene.balls[0].centre).head<2>().norm(), 0.05f);
  EXPECT_GT(objects[1].score, 0.8f);
}

TEST(SemanticField, TellsHowMuchOfWhatTheViewsShowHasNoLabel) {
  const MadeScene scene = made_scene(two_balls());
  MaskSet masks = cast_masks(scene);
  SemanticOptions options;
  options.iterations = 0;
  EXPECT_LT(fit_semantic_field(options, scene.cloud, scene.cameras, masks).summary.unlabelled, 0.1);
  for (MaskSet::View& view : masks.views)
    std::replace(view.ids.data.begin(), view.ids.data.end(), MadeScene::kTable, 0u);
  size_t table = 0, balls = 0;  // pixels
  for (const MaskSet::View& view : cast_masks(scene).views)
    for (const uint32_t id : view.ids.data) {
      table += id == MadeScene::kTable;
      balls += id == 300 || id == 70000;
    }
  EXPECT_NEAR(fit_semantic_field(options, scene.cloud, scene.cameras, masks).summary.unlabelled,
              static_cast<double>(table) / static_cast<double>(table + balls), 0.05);
}

TEST(IdAgreement, CountsIntersectionsOverUnionsAndLeavesUnlabelledPixelsOut) {
  IdImage truth(4, 1, 1), predicted(4, 1, 1);
  truth.data = {5, 5, 9, 0};
  predicted.data = {5, 9, 9, 5};
  const IdAgreement agreement = id_agreement(std::vector{predicted}, std::vector{truth});
  EXPECT_DOUBLE_EQ(agreement.iou.at(5), 0.5);
  EXPECT_DOUBLE_EQ(agreement.iou.at(9), 0.5);
  EXPECT_DOUBLE_EQ(agreement.mean, 0.5);
}

TEST(Selection, ShapesThatSelectNothingOrMakeNoSenseAreUsageErrors) {
  const MadeScene scene = made_scene(two_balls(), 2);
  expect_error(Failure::kUsage, {"--aabb", "no Gaussian"}, [&] {
    shape_members(SelectionShape::from_aabb({5, 5, 5, 6, 6, 6}), scene.cloud);
  });
  expect_error(Failure::kUsage, {"--sphere"}, [&] { SelectionShape::from_sphere({0, 0, 0, -1}); });
  expect_error(Failure::kUsage, {"--aabb"}, [&] { SelectionShape::from_aabb({0, 0, 0, 1, 1}); });
  expect_error(Failure::kUsage, {"--aabb", "volume"}, [&] { SelectionShape::from_aabb({0, 0, 0, 1, 0, 1}); });
}

}  // namespace
}  // namespace pliant
