#include "fitting/distribution/distribution_network.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fitting/distribution/distribution_figures.h"
#include "fitting/distribution/object_corpus.h"
#include "fitting/distribution/training_set.h"
#include "gaussians/base/random.h"
#include "gaussians/io/files/files.h"
#include "tests/fitting/distribution/made_network.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

std::vector<float> drawn(size_t count, uint64_t seed) {
  std::vector<float> out;
  for (Random random(seed); out.size() < count;) out.push_back(static_cast<float>(random.normal()));
  return out;
}

TEST(DistributionNetwork, KeepsTheMeans) {
  const DistributionNetwork network = made_network(1);
  const size_t m = 500;
  const auto features = drawn(m * kFeatures, 2);
  std::vector<float> volume;
  for (Random random(3); volume.size() < m;) volume.push_back(static_cast<float>(random.uniform(0.1, 3)));
  const MaterialMeans means{3e7, 0.25, 640};
  const auto found = predict_distribution(network, features, volume, means);
  double total = 0, young = 0, density = 0, poisson = 0, spread = 0;
  for (size_t i = 0; i < m; ++i) {
    total += volume[i];
    young += volume[i] * found.young[i];
    density += volume[i] * found.density[i];
    poisson += volume[i] * found.poisson[i];
    spread = std::max(spread, std::abs(std::log10(found.young[i] / means.young)));
    ASSERT_LT(found.young_low[i], found.young_high[i]);
    ASSERT_GT(found.sigma[i], 0);
  }
  EXPECT_GT(spread, 0.1) << "the network says something";
  EXPECT_NEAR(young / total, means.young, 1e-5 * means.young);
  EXPECT_NEAR(density / total, means.density, 1e-5 * means.density);
  EXPECT_NEAR(poisson / total, means.poisson, 1e-5);
}

// Samples that nothing tells apart have the mean, whatever the network has learned.
TEST(DistributionNetwork, AHomogeneousObjectHasTheMeanEverywhere) {
  const DistributionNetwork network = made_network(4);
  const auto one = drawn(kFeatures, 5);
  std::vector<float> features;
  for (int i = 0; i < 300; ++i) features.insert(features.end(), one.begin(), one.end());
  const auto found = predict_distribution(network, features, std::vector<float>(300, 1e-6f), {2e5, 0.4, 90});
  for (int i = 0; i < 300; ++i) {
    EXPECT_NEAR(found.young[i], 2e5, 1);
    EXPECT_NEAR(found.density[i], 90, 1e-3);
    EXPECT_NEAR(found.poisson[i], 0.4, 1e-6);
    EXPECT_EQ(found.sigma[i], found.sigma[0]);
  }
}

TEST(DistributionNetwork, ScalesWithTheMeanAndDoesNotDependOnTheOrderOfFewSamples) {
  const DistributionNetwork network = made_network(6);
  const size_t m = kContextSamples;
  const auto features = drawn(m * kFeatures, 7);
  const std::vector<float> volume(m, 1.0f);
  const auto soft = predict_distribution(network, features, volume, {1e5, 0.3, 1000});
  const auto stiff = predict_distribution(network, features, volume, {1e8, 0.3, 1000});
  std::vector<float> backward;
  for (size_t i = m; i-- > 0;)
    backward.insert(backward.end(), features.begin() + static_cast<std::ptrdiff_t>(i * kFeatures),
                    features.begin() + static_cast<std::ptrdiff_t>((i + 1) * kFeatures));
  const auto turned = predict_distribution(network, backward, volume, {1e5, 0.3, 1000});
  for (size_t i = 0; i < m; ++i) {
    EXPECT_NEAR(stiff.young[i] / soft.young[i], 1e3, 0.01);
    EXPECT_NEAR(turned.young[m - 1 - i] / soft.young[i], 1, 1e-3);
  }
}

TEST(DistributionNetwork, IsReadAsItWasWritten) {
  TemporaryFolder folder;
  DistributionNetwork n = made_network(8);
  n.members.push_back(made_network(9).members[0]);
  n.temperature = 1.25f;
  n.wide_weight = 0.1f;
  n.tail = 0.15f;
  n.recipe = R"({"seed":8})";
  write_network(folder / "n.safetensors", n);
  const DistributionNetwork read = read_network(folder / "n.safetensors");
  EXPECT_EQ(read.members, n.members);
  EXPECT_EQ(read.shift, n.shift);
  EXPECT_EQ(read.scale, n.scale);
  EXPECT_EQ(read.size.hidden, n.size.hidden);
  EXPECT_EQ(read.temperature, n.temperature);
  EXPECT_EQ(read.wide_weight, n.wide_weight);
  EXPECT_EQ(read.tail, n.tail);
  EXPECT_EQ(read.wide_mean, n.wide_mean);
  EXPECT_EQ(read.wide_sigma, n.wide_sigma);
  EXPECT_EQ(read.recipe, n.recipe);
}

TEST(DistributionNetwork, RefusesWeightsThatAreNotItsOwn) {
  TemporaryFolder folder;
  const auto file = folder / "n.safetensors";
  const auto refused = [&](const std::vector<std::string>& words, const auto& change) {
    SCOPED_TRACE(words[0]);
    DistributionNetwork n = made_network(9);
    change(n);
    write_network(file, n);
    expect_error(Failure::kInput, words, [&] { read_network(file); });
  };
  refused({"n.safetensors", "member0.layer0.weight", "not finite"}, [](auto& n) { n.members[0][3] = NAN; });
  refused({"calibration"}, [](auto& n) { n.temperature = -1; });
  refused({"calibration"}, [](auto& n) { n.wide_sigma = 0; });
  refused({"calibration"}, [](auto& n) { n.wide_weight = 1; });
  refused({"calibration"}, [](auto& n) { n.tail = 0.5f; });
  write_network(file, made_network(9));
  std::string bytes = read_text(file);
  bytes.replace(bytes.find("\"height "), 8, "\"Height ");
  write_text(file, bytes);
  expect_error(Failure::kInput, {"n.safetensors", "features"}, [&] { read_network(file); });
  write_text(file, "not weights at all");
  expect_error(Failure::kInput, {"n.safetensors"}, [&] { read_network(file); });
  expect_error(Failure::kInput, {"none.safetensors"}, [&] { read_network(folder / "none.safetensors"); });
}

// What ships is a trained network.  These families chose when its training ended well; fitting/distribution/README.md
// has the figures of families that nothing was chosen by.
TEST(DistributionNetwork, TheShippedOneKnowsMoreThanTheMeanOfTheValidationFamilies) {
  const DistributionNetwork network = shipped_network();
  EXPECT_NE(network.recipe.find("seed"), std::string::npos);
  std::vector<MaterialObject> objects;
  for (const std::string& family : corpus_families(FamilyRole::kValidate))
    for (uint64_t seed = 0; seed < 2; ++seed) objects.push_back(make_object(family, 77'000 + seed));
  const auto figures = distribution_figures(network, objects);
  ASSERT_EQ(figures.size(), corpus_families(FamilyRole::kValidate).size() + 1);
  const DistributionFigures& all = figures.back();
  EXPECT_EQ(all.family, "all");
  EXPECT_EQ(all.objects, objects.size());
  EXPECT_LT(all.error, 0.9 * all.error_of_mean);
  EXPECT_GT(all.log_density, all.log_density_of_one);
  EXPECT_GT(all.coverage, 0.65);
  EXPECT_LT(all.coverage, 0.92);
}

}  // namespace
}  // namespace pliant
