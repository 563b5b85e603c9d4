// The graph of a scene's Gaussians, its cuts and the colour models that weigh them.

#include "segmentation/graph/gaussian_graph.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gaussians/base/random.h"
#include "segmentation/graph/color_model.h"
#include "segmentation/graph/min_cut.h"

using namespace pliant;

TEST(ColorModel, RecoversAKnownMixture) {
  const Vec3f mean[2] = {{0.2f, 0.1f, -0.3f}, {0.7f, -0.2f, 0.4f}};
  const Vec3f sigma[2] = {{0.05f, 0.02f, 0.08f}, {0.03f, 0.06f, 0.02f}};
  Random random(5);
  std::vector<Vec3f> colors;
  for (int i = 0; i < 6000; ++i) {
    const int k = random.uniform() < 0.3 ? 0 : 1;
    Vec3f x;
    for (int c = 0; c < 3; ++c) x[c] = mean[k][c] + sigma[k][c] * static_cast<float>(random.normal());
    colors.push_back(x);
  }
  ColorModelOptions options;
  options.components = 2;
  options.ridge = 0;
  options.rounds = 30;
  const ColorModel model = ColorModel::fit(options, colors);
  ASSERT_EQ(model.components().size(), 2u);
  const int first = model.components()[0].weight < 0.5f ? 0 : 1;
  for (int k = 0; k < 2; ++k) {
    const ColorModel::Component& c = model.components()[k == 0 ? first : 1 - first];
    EXPECT_NEAR(c.weight, k == 0 ? 0.3 : 0.7, 0.02);
    EXPECT_LT((c.mean - mean[k]).norm(), 0.01);
    for (int a = 0; a < 3; ++a) {
      EXPECT_NEAR(std::sqrt(c.covariance(a, a)), sigma[k][a], 0.08 * sigma[k][a]);
      for (int b = 0; b < a; ++b) EXPECT_NEAR(c.covariance(a, b), 0, 0.1 * sigma[k][a] * sigma[k][b]);
    }
  }
}

TEST(ColorModel, DensityIntegratesToOne) {
  std::vector<Vec3f> colors;
  Random random(2);
  for (int i = 0; i < 500; ++i) colors.push_back(Vec3f(random.normal(), random.normal(), random.normal()) * 0.1f);
  ColorModelOptions options;
  options.components = 3;
  const ColorModel model = ColorModel::fit(options, colors);
  double sum = 0;
  const float h = 0.04f;
  for (float x = -0.8f; x < 0.8f; x += h)
    for (float y = -0.8f; y < 0.8f; y += h)
      for (float z = -0.8f; z < 0.8f; z += h) sum += std::exp(model.log_density(Vec3f(x, y, z))) * h * h * h;
  EXPECT_NEAR(sum, 1, 0.01);
}

TEST(ColorModel, LabOfWhiteGreyAndRed) {
  EXPECT_LT((lab_of_rgb(Vec3f(1, 1, 1)) - Vec3f(1, 0, 0)).norm(), 2e-3);
  EXPECT_LT((lab_of_rgb(Vec3f(0, 0, 0))).norm(), 2e-3);
  EXPECT_LT((lab_of_rgb(Vec3f(1, 0, 0)) - Vec3f(0.5324f, 0.8009f, 0.6720f)).norm(), 5e-3);
}

TEST(MinCut, EqualsTheBruteForceMinimumOnTinyGraphs) {
  for (uint64_t trial = 0; trial < 60; ++trial) {
    Random random(7, trial);
    const int n = 3 + static_cast<int>(random.below(8));
    std::vector<float> gain(n);
    for (float& g : gain) g = static_cast<float>(random.uniform(-2, 2));
    std::vector<CutEdge> edges;
    for (int a = 0; a < n; ++a)
      for (int b = a + 1; b < n; ++b)
        if (random.uniform() < 0.4) edges.push_back({a, b, static_cast<float>(random.uniform(0, 1.5))});
    auto energy = [&](const std::vector<uint8_t>& x) {
      double e = 0;
      for (int i = 0; i < n; ++i) e -= x[i] ? gain[i] : 0;
      for (const CutEdge& edge : edges) e += x[edge.a] != x[edge.b] ? edge.weight : 0;
      return e;
    };
    double least = INFINITY;
    for (int bits = 0; bits < 1 << n; ++bits) {
      std::vector<uint8_t> x(n);
      for (int i = 0; i < n; ++i) x[i] = bits >> i & 1;
      least = std::min(least, energy(x));
    }
    EXPECT_NEAR(energy(min_cut(gain, edges)), least, 2e-2) << "trial " << trial;
  }
}

TEST(GaussianGraph, WhatTouchesNothingButTheObjectIsEnclosed) {
  // Nodes 0..2 are the object; 3 and 4 hang on it and on each other, unlike it in colour.
  GaussianGraph graph;
  graph.nodes = {0, 1, 2, 3, 4};
  graph.opacity.assign(5, 0.8f);
  graph.edges = {{0, 1, 0.9f}, {1, 2, 0.9f}, {2, 3, 0.0f}, {3, 4, 0.0f}};
  graph.edge_nearness = {0.9f, 0.9f, 0.9f, 0.9f};
  const std::vector<uint8_t> label = {1, 1, 1, 0, 0};
  const std::vector<float> nothing(5, 0);
  const auto enclosed = [&](const std::vector<float>& outside, float least, float touch = 0.02f) {
    return enclosed_nodes(graph, label, outside, 0.02f, least, touch);
  };
  EXPECT_EQ(enclosed(nothing, 0.01f), (std::vector<int>{3, 4}));
  EXPECT_TRUE(enclosed(nothing, 0.9f).empty()) << "too light";
  EXPECT_TRUE(enclosed({0, 0, 0, 0, 1}, 0.01f).empty()) << "one of the pair is known to be outside";
  EXPECT_EQ(enclosed({0, 0, 0, 0, 1}, 0.01f, 0.9f), (std::vector<int>{3, 4})) << "but that is little";
  EXPECT_TRUE(enclosed({0, 0, 0, 0, INFINITY}, 0.01f, 0.9f).empty()) << "one of the pair is marked";
  graph.border = {{4, 17, 0.0f}};
  graph.border_nearness = {0.5f};
  EXPECT_TRUE(enclosed(nothing, 0.01f).empty()) << "tied to what lies outside the box";
  graph.edge_nearness[3] = 0;
  EXPECT_EQ(enclosed(nothing, 0.01f), (std::vector<int>{3})) << "4 is tied to the outside, but 3 no longer to 4";
}

TEST(GaussianGraph, PartsBelongToTheObjectWhenTheyLieAgainstItMoreThanAgainstTheRest) {
  // A row of nodes: object 0 1 | nose 2 | tip 3, beside it leak 4 | rest 5 6; colours part all bars.
  GaussianGraph graph;
  graph.nodes = {0, 1, 2, 3, 4, 5, 6};
  graph.edges = {{0, 1, 0.9f}, {1, 2, 0.01f}, {2, 3, 0.01f}, {1, 4, 0.01f}, {4, 5, 0.01f}, {5, 6, 0.9f}};
  graph.edge_nearness = {0.9f, 0.8f, 0.7f, 0.5f, 0.9f, 0.9f};
  graph.opacity.assign(7, 1.0f);
  graph.opacity[0] = 5;
  const std::vector<uint8_t> label = {1, 1, 1, 1, 1, 0, 0};
  const std::vector<int> part = connected_parts(graph, label, 0.02f);
  std::vector<uint8_t> wanted(8, 0);
  wanted[0] = 1;
  const std::vector<uint8_t> attached = attached_parts(graph, part, wanted);
  EXPECT_EQ(part[0], 0);
  EXPECT_TRUE(attached[part[2]]);
  EXPECT_TRUE(attached[part[3]]) << "through the nose";
  EXPECT_FALSE(attached[part[4]]) << "the leak lies against the rest";
}

TEST(GaussianGraph, WhatLiesClearlyNearerToARivalIsNotInOrder) {
  // A chain of equal edges: node 6 is 3 from the rival and 6 from the source, node 5 is 4 and 5.
  std::vector<CutEdge> edges;
  for (int i = 0; i < 9; ++i) edges.push_back({i, i + 1, 0.5f});
  const Adjacency adjacency(10, edges);
  EXPECT_EQ(order_apart(adjacency, edges, {0}, {9}, 0.6f), (std::vector<int>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(order_apart(adjacency, edges, {0}, {}, 0.6f).size(), 10u);
  EXPECT_EQ(order_apart(adjacency, edges, {0}, {0}, 0.6f).size(), 10u) << "marks of both kinds leave all";
}

TEST(GaussianGraph, ATiedShareIsWhatCrossesTheBorder) {
  GaussianGraph graph;
  graph.edges = {{0, 1, 0.0f}, {1, 2, 0.0f}, {2, 3, 0.0f}};
  graph.edge_nearness = {0.6f, 0.2f, 0.5f};
  EXPECT_FLOAT_EQ(tied_share(graph, {1, 1, 0, 0}), 0.25f);
  EXPECT_FLOAT_EQ(tied_share(graph, {1, 1, 1, 1}), 0);
  EXPECT_FLOAT_EQ(tied_share(graph, {0, 0, 0, 0}), 1) << "nothing";
}
