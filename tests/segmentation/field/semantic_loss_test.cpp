// The loss of the semantic attribute: S = W y, derivatives against central differences in double, closed forms.

#include "segmentation/field/semantic_loss.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

constexpr int kChannels = kSemanticChannels;

SparseView<double> random_view(int rows, int gaussians, uint64_t seed) {
  SparseView<double> view;
  view.row_start = {0};
  for (int r = 0; r < rows; ++r) {
    Random random(seed, r);
    double transmittance = 1;
    for (int p = 0; p < gaussians; ++p) {
      if (random.uniform() < 0.5) continue;
      const double alpha = random.uniform(0.05, 0.7);
      view.gaussian.push_back(p);
      view.weight.push_back(alpha * transmittance);
      transmittance *= 1 - alpha;
    }
    view.row_start.push_back(static_cast<uint32_t>(view.gaussian.size()));
  }
  view.index_columns(gaussians);
  return view;
}

SemanticModel<double> random_model(int gaussians, int classes, uint64_t seed) {
  SemanticModel<double> model;
  model.resize(gaussians, classes);
  Random random(seed);
  for (double& v : model.attribute) v = random.normal();
  for (double& v : model.classifier) v = 0.7 * random.normal();
  for (double& v : model.bias) v = 0.3 * random.normal();
  return model;
}

/// Compares every derivative in `gradient` with central differences of `loss`.
template <class Loss>
void expect_derivatives(SemanticModel<double> model, const SemanticModel<double>& gradient, const Loss& loss) {
  const double h = 1e-5;
  auto compare = [&](std::vector<double>& x, const std::vector<double>& g, const char* what) {
    for (size_t i = 0; i < x.size(); ++i) {
      const double keep = x[i];
      x[i] = keep + h;
      const double above = loss(model);
      x[i] = keep - h;
      const double below = loss(model);
      x[i] = keep;
      EXPECT_NEAR(g[i], (above - below) / (2 * h), 1e-6 * std::max(1.0, std::abs(g[i]))) << what << " " << i;
    }
  };
  compare(model.attribute, gradient.attribute, "dL/dy");
  compare(model.classifier, gradient.classifier, "dL/dclassifier");
  compare(model.bias, gradient.bias, "dL/dbias");
}

TEST(SemanticLoss, BlendedAttributeIsWTimesY) {
  const auto W = random_view(7, 9, 1);
  const auto model = random_model(9, 4, 2);
  std::vector<double> S;
  multiply<double>(W, model.attribute, S);
  for (size_t r = 0; r < W.rows(); ++r)
    for (int k = 0; k < kChannels; ++k) {
      double sum = 0;
      for (uint32_t e = W.row_start[r]; e < W.row_start[r + 1]; ++e)
        sum += W.weight[e] * model.attribute[W.gaussian[e] * kChannels + k];
      EXPECT_NEAR(S[r * kChannels + k], sum, 1e-14);
    }
}

TEST(SemanticLoss, TransposedProductIsTheAdjointOfTheProduct) {
  const auto W = random_view(11, 6, 3);
  const auto a = random_model(6, 2, 4), b = random_model(11, 2, 5);
  std::vector<double> Wa, Wtb(6 * kChannels, 0.0);
  multiply<double>(W, a.attribute, Wa);
  multiply_transposed<double>(W, b.attribute, std::span<double>(Wtb));
  double left = 0, right = 0;
  for (size_t i = 0; i < Wa.size(); ++i) left += Wa[i] * b.attribute[i];
  for (size_t i = 0; i < Wtb.size(); ++i) right += Wtb[i] * a.attribute[i];
  EXPECT_NEAR(left, right, 1e-12 * std::abs(left));
}

TEST(SemanticLoss, CrossEntropyDerivativesEqualFiniteDifferences) {
  const auto W = random_view(12, 8, 6);
  const auto model = random_model(8, 5, 7);
  std::vector<int> target;
  for (int r = 0; r < 12; ++r) target.push_back(r % 6 - 1);  // with unlabelled rows
  SemanticModel<double> gradient;
  gradient.resize(8, 5);
  const double value = semantic_loss_adjoint(W, std::span<const int>(target), model, gradient);
  EXPECT_NEAR(value, semantic_loss(W, std::span<const int>(target), model), 1e-15);
  expect_derivatives(model, gradient, [&](const auto& m) { return semantic_loss(W, std::span<const int>(target), m); });
}

TEST(SemanticLoss, GroupingDerivativesEqualFiniteDifferences) {
  const auto model = random_model(7, 4, 8);
  const std::vector<int> anchors = {0, 3, 6, 3}, graph = {1, 2, 0, 2, 0, 1, 4, 5, 3, 6, 4, -1, 5, 3};
  SemanticModel<double> gradient;
  gradient.resize(7, 4);
  grouping_loss_adjoint<double>(anchors, graph, 2, 2.0, model, gradient);
  expect_derivatives(model, gradient, [&](const auto& m) { return grouping_loss<double>(anchors, graph, 2, 2.0, m); });
}

TEST(SemanticLoss, UniformPredictionCostsOneBecauseOfTheLogarithmOfC) {
  const auto W = random_view(5, 4, 9);
  SemanticModel<double> model;
  model.resize(4, 37);
  const std::vector<int> target = {0, 3, 36, -1, 8};
  EXPECT_NEAR(semantic_loss(W, std::span<const int>(target), model), 1.0, 1e-13);
}

TEST(SemanticLoss, GroupingOfTwoGaussiansIsTheirDivergenceOverC) {
  SemanticModel<double> model;
  model.resize(2, 2);
  model.classifier[0] = 1;             // logit of class 0 = y[0]
  model.attribute[0] = std::log(3.0);  // P = (3/4, 1/4); Q = (1/2, 1/2)
  const std::vector<int> anchors = {0}, graph = {1, 0};
  const double kl = 0.75 * std::log(0.75 / 0.5) + 0.25 * std::log(0.25 / 0.5);
  EXPECT_NEAR(grouping_loss<double>(anchors, graph, 1, 2.0, model), 2.0 * kl / 2, 1e-14);
}

TEST(SemanticLoss, SixteenBitWeightsAreWithinTheirRounding) {
  BlendWeights weights;
  weights.width = 2;
  weights.height = 1;
  weights.row_start = {0, 2, 3};
  weights.gaussian = {1, 0, 1};
  weights.weight = {0.123456f, 0.77f, 0.99f};
  const std::vector<uint32_t> pixels = {0, 1};
  const CompactView view = compact_view(weights, pixels, 2);
  for (size_t e = 0; e < 3; ++e) EXPECT_NEAR(view.weight[e] * view.unit, weights.weight[e], 7.7e-6);
  EXPECT_EQ(view.column, (std::vector<uint32_t>{0, 1}));
  EXPECT_EQ(view.row, (std::vector<uint32_t>{0, 0, 1}));
}

}  // namespace
}  // namespace pliant
