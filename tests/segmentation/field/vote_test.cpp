// Votes of pixels for classes, and the codes that stand for classes.

#include "segmentation/field/vote.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gaussians/base/random.h"
#include "segmentation/field/semantic_loss.h"

namespace pliant {
namespace {

TEST(Vote, DecodedClassIsTheOneWithTheMostVotesForAnyNumberOfClasses) {
  for (int classes : {2, 16, 40, 300}) {
    ClassVotes votes(500);
    BlendWeights weights;
    std::vector<int> target;
    weights.row_start = {0};
    for (int p = 0; p < 500; ++p)
      for (int k = 0; k < 7; ++k) {
        Random random(classes, p, k);
        target.push_back(static_cast<int>(random.below(classes)));
        weights.gaussian.push_back(p);
        weights.weight.push_back(static_cast<float>(random.uniform(0.1, 1)));
        weights.row_start.push_back(static_cast<uint32_t>(weights.gaussian.size()));
      }
    weights.width = static_cast<int>(target.size());
    weights.height = 1;
    votes.add(weights, target);
    SemanticModel<float> model;
    start_from_votes(votes, classes, 1, model);
    for (int p = 0; p < 500; ++p) {
      const auto share = votes.of(p);
      const int winner =
          std::max_element(share.begin(), share.end(), [](auto& a, auto& b) { return a.weight < b.weight; })->cls;
      std::vector<float> probability(classes);
      class_softmax(model, model.attribute.data() + p * kSemanticChannels, probability.data());
      EXPECT_EQ(std::max_element(probability.begin(), probability.end()) - probability.begin(), winner) << classes;
    }
  }
}

TEST(Vote, TheCodeOfAClassIsSureOfItHoweverManyThereAre) {
  for (const int classes : {1, 2, 16, 17, 40, 600}) {
    const std::vector<float> codes = class_codes(classes, 5);
    const double sharpness = code_sharpness(codes);
    if (classes <= 16) {
      EXPECT_EQ(sharpness, 8) << classes;
      continue;
    }
    const auto most_of_others = [&](double s) {
      double most = 0;
      for (int k = 0; k < classes; ++k) {
        double sum = 0;
        for (int c = 0; c < classes; ++c) {
          double dot = 0;
          for (int i = 0; i < kSemanticChannels; ++i)
            dot += static_cast<double>(codes[k * kSemanticChannels + i]) * codes[c * kSemanticChannels + i];
          if (c != k) sum += std::exp(-s * (1 - dot));
        }
        most = std::max(most, sum);
      }
      return most;
    };
    EXPECT_LT(most_of_others(sharpness), 0.0501) << classes;
    if (sharpness > 8) {
      EXPECT_GT(most_of_others(0.99 * sharpness), 0.05) << classes;
    }
  }
}

}  // namespace
}  // namespace pliant
