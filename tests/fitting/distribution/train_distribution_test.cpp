#include "fitting/distribution/train_distribution.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fitting/distribution/distribution_loss.h"
#include "fitting/distribution/object_corpus.h"
#include "fitting/distribution/training_set.h"
#include "gaussians/io/files/files.h"
#include "tests/fitting/distribution/made_network.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

class TrainDistribution : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!can_train_networks()) GTEST_SKIP() << "built without libtorch";
  }
};

TrainingBatch drawn_batch(int objects, int samples, uint64_t seed) {
  TrainingBatch batch{objects, samples, {}, {}};
  Random random(seed);
  for (int i = 0; i < objects * samples * kFeatures; ++i) batch.features.push_back(static_cast<float>(random.normal()));
  for (int i = 0; i < objects * samples; ++i) {
    batch.target.push_back(static_cast<float>(-1 + 1.2 * random.normal()));
    batch.target.push_back(static_cast<float>(0.2 * random.normal()));
    batch.target.push_back(static_cast<float>(0.05 * random.normal()));
  }
  return batch;
}

TrainDistributionOptions small_options() {
  TrainDistributionOptions o;
  o.objects = 18;
  o.validation_objects = 5;
  o.members = 2;
  o.epochs = 3;
  o.hidden = 16;
  o.batch_objects = 6;
  o.batch_samples = 32;
  o.rate = 3e-3;
  o.seed = 5;
  return o;
}

TEST_F(TrainDistribution, ForwardsOfTorchAndOfTheProgramAgree) {
  const DistributionNetwork network = made_network(1);
  const auto loss = make_distribution_loss(network, 1);
  const TrainingBatch batch = drawn_batch(3, 40, 2);
  const auto all = loss->outputs(network.members[0], batch);
  const size_t each = 40 * kOutputs, features = 40 * kFeatures;
  ASSERT_EQ(all.size(), 3 * each);
  for (size_t k = 0; k < 3; ++k) {
    const auto own =
        network_outputs(network.size, network.members[0], std::span(batch.features).subspan(k * features, features));
    for (size_t i = 0; i < each; ++i) EXPECT_NEAR(own[i], all[k * each + i], 2e-5 * (1 + std::abs(own[i])));
  }
}

// The loss is the likelihood that the mixtures of the program have.
TEST_F(TrainDistribution, LossIsTheLikelihoodOfTheMixtures) {
  const DistributionNetwork network = made_network(3);
  const auto loss = make_distribution_loss(network, 1, true);
  const TrainingBatch batch = drawn_batch(1, 64, 4);
  const auto outputs = network_outputs(network.size, network.members[0], batch.features);
  const auto mixtures = young_mixtures(network, std::vector<std::vector<float>>{outputs});
  double sum = 0;
  for (size_t i = 0; i < 64; ++i) {
    sum -= mixtures[i].log_density(batch.target[3 * i]) / 64;
    const float* y = outputs.data() + i * kOutputs + 3 * kComponents;
    for (const int other : {0, 1}) {
      const double log_sigma = std::clamp<double>(y[2 * other + 1], -3.5, 1.0);
      const double u =
          (batch.target[3 * i + 1 + other] / (other ? kPoissonUnit : 1.0) - y[2 * other]) / std::exp(log_sigma);
      sum += 0.1 * (0.5 * u * u + log_sigma + 0.5 * std::log(2 * M_PI)) / 64;
    }
  }
  EXPECT_NEAR(loss->value(network.members[0], batch, {}), sum, 1e-5);
}

TEST_F(TrainDistribution, GradientAgreesWithCentralDifferences) {
  const DistributionNetwork network = made_network(5);
  const auto loss = make_distribution_loss(network, 1, true);
  const TrainingBatch batch = drawn_batch(2, 12, 6);
  std::vector<float> p = network.members[0], gradient(p.size());
  loss->value(p, batch, gradient);
  double largest = 0;
  for (const float g : gradient) largest = std::max(largest, std::abs(double{g}));
  int kinks = 0, checked = 0;
  for (size_t i = 0; i < p.size(); i += 17) {
    const float before = p[i], h = 1e-4f;
    p[i] = before + h;
    const double up = p[i], above = loss->value(p, batch, {});
    p[i] = before - h;
    const double down = p[i], below = loss->value(p, batch, {});
    p[i] = before;
    ++checked;
    kinks += std::abs((above - below) / (up - down) - gradient[i]) > 1e-5 * largest;
  }
  EXPECT_GT(checked, 150);
  EXPECT_LE(kinks, checked / 50) << "a step may cross a kink of a ReLU or a maximum, hardly ever";
}

TEST_F(TrainDistribution, LowersTheLoss) {
  TrainDistributionOptions o = small_options();
  o.members = 1;
  o.epochs = 16;
  const auto result = train_distribution(o);
  ASSERT_TRUE(result.finished);
  ASSERT_EQ(result.curve.size(), 16u);
  EXPECT_LT(result.curve.back().train, result.curve.front().train - 0.3);
  EXPECT_NE(result.network.recipe.find("\"seed\":5"), std::string::npos) << result.network.recipe;
  TemporaryFolder folder;
  write_curve(folder / "curve.csv", result.curve);
  const std::string text = read_text(folder / "curve.csv");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 17);
  EXPECT_EQ(text.substr(0, 24), "member,train,validation\n");
}

TEST_F(TrainDistribution, AStoppedOneContinuesToTheSameBits) {
  TemporaryFolder folder;
  const auto checkpoint = folder / "state";
  const TrainDistributionOptions o = small_options();
  const auto whole = train_distribution(o);
  int epochs = 0;
  const auto stop_after_four = [&](const TrainingEpoch&) { return ++epochs < 4; };  // within the second member
  const auto first = train_distribution(o, {}, checkpoint, stop_after_four);
  EXPECT_FALSE(first.finished);
  EXPECT_EQ(first.curve.size(), 4u);
  // What is told of the rest counts on.
  std::vector<int> done;
  const auto rest = train_distribution(o, {}, checkpoint, [&](const TrainingEpoch& epoch) {
    done.push_back(epoch.done);
    return true;
  });
  EXPECT_TRUE(rest.finished);
  EXPECT_EQ(done, (std::vector<int>{5, 6}));
  EXPECT_EQ(rest.network.members, whole.network.members);
  EXPECT_EQ(rest.network.temperature, whole.network.temperature);
  ASSERT_EQ(rest.curve.size(), whole.curve.size());
  for (size_t i = 0; i < rest.curve.size(); ++i) {
    EXPECT_EQ(rest.curve[i].train, whole.curve[i].train);
    EXPECT_EQ(rest.curve[i].validation, whole.curve[i].validation);
  }

  TrainDistributionOptions other = o;
  other.rate = 1e-3;
  expect_error(Failure::kInput, {"state", "options"}, [&] { train_distribution(other, {}, checkpoint); });
  const std::vector<MaterialObject> more = {make_object("flower", 1)};
  expect_error(Failure::kInput, {"state", "options"}, [&] { train_distribution(o, more, checkpoint); });
  const std::string bytes = read_text(checkpoint);
  write_text(checkpoint, bytes.substr(0, bytes.size() - 100));
  expect_error(Failure::kInput, {"state", "truncated"}, [&] { train_distribution(o, {}, checkpoint); });
}

TEST_F(TrainDistribution, AnotherMaterialOrColourOfAnObjectThatIsAddedIsAnotherTraining) {
  TemporaryFolder folder;
  TrainDistributionOptions o = small_options();
  o.objects = 3;
  o.validation_objects = 2;
  o.members = o.epochs = 1;
  const std::vector<MaterialObject> more = {make_object("flower", 1)};
  const auto resume = [&](const auto& change) {
    std::vector<MaterialObject> changed = more;
    change(changed[0]);
    return train_distribution(o, changed, folder / "state").finished;
  };
  ASSERT_TRUE(resume([](MaterialObject&) {}));
  const auto refuses = [&](const auto& change) {
    expect_error(Failure::kInput, {"state", "options", "another training"}, [&] { resume(change); });
  };
  refuses([](MaterialObject& object) { object.density[0] *= 1.5f; });
  refuses([](MaterialObject& object) { object.poisson[0] *= 0.5f; });
  refuses([](MaterialObject& object) { object.young[0] *= 1.5f; });
  refuses([](MaterialObject& object) { object.colour[0] *= 0.5f; });
  refuses([](MaterialObject& object) { object.samples.volume[0] *= 1.5f; });
  refuses([](MaterialObject& object) { object.samples.thickness[0] += 0.01f; });
  refuses([](MaterialObject& object) { object.up = Vec3f::UnitX(); });
  EXPECT_TRUE(resume([](MaterialObject&) {}));
}

TEST(TrainDistributionOptions, WithoutLibtorchTheyAreRefusedBeforeObjectsAreMade) {
  if (can_train_networks()) GTEST_SKIP() << "built with libtorch";
  TrainDistributionOptions o;
  o.objects = 1'000'000;  // which would take hours
  expect_error(Failure::kInput, {"pliant_distribution.so", "libtorch"}, [&] { train_distribution(o); });
}

TEST(TrainDistributionOptions, ImpossibleOnesAreRefused) {
  const auto refused = [](const char* field, const auto& change) {
    TrainDistributionOptions o;
    change(o);
    expect_error(Failure::kUsage, {"training", field}, [&] { train_distribution(o); });
  };
  refused("objects", [](auto& o) { o.objects = 1; });
  refused("validation_objects", [](auto& o) { o.validation_objects = 0; });
  refused("members", [](auto& o) { o.members = 0; });
  refused("epochs", [](auto& o) { o.epochs = 0; });
  refused("rate", [](auto& o) { o.rate = NAN; });
  refused("decay", [](auto& o) { o.decay = -1; });
  refused("hidden", [](auto& o) { o.hidden = 100000; });
  refused("batch_objects", [](auto& o) { o.batch_objects = 0; });
  refused("batch_samples", [](auto& o) { o.batch_samples = kContextSamples + 1; });
  refused("hidden_parts", [](auto& o) { o.disturbance.hidden_parts = 1.5; });
  refused("hidden_groups", [](auto& o) { o.disturbance.hidden_groups = 1; });
  refused("offset", [](auto& o) { o.disturbance.offset = -1; });
  refused("threads", [](auto& o) { o.threads = 0; });
}

TEST(TrainingSet, HasTargetsAroundTheMeanAndHidesParts) {
  const MaterialObject o = make_object("flower", 3);
  const MaterialMeans means = means_of(o);
  const auto target = targets_of(o, means);
  double young = 0, density = 0, poisson = 0;
  for (size_t i = 0; i < o.samples.size(); ++i) {
    young += o.samples.volume[i] * std::pow(10.0, target[3 * i]);
    density += o.samples.volume[i] * std::pow(10.0, target[3 * i + 1]);
    poisson += o.samples.volume[i] * target[3 * i + 2];
  }
  EXPECT_NEAR(young, o.samples.total_volume(), 1e-4 * o.samples.total_volume());
  EXPECT_NEAR(density, o.samples.total_volume(), 1e-4 * o.samples.total_volume());
  EXPECT_NEAR(poisson, 0, 1e-4 * o.samples.total_volume());

  const TrainingSet set = make_training_set({4, 9, true, 1}, std::vector<std::string>{"flower", "cup"});
  const TrainingSet again = make_training_set({4, 9, true, 2}, std::vector<std::string>{"flower", "cup"});
  ASSERT_EQ(set.objects(), 4u);
  EXPECT_EQ(set.features, again.features);
  EXPECT_EQ(set.target, again.target);
  DistributionNetwork plain;
  plain.shift.assign(kFeatures, 0.0f);
  plain.scale.assign(kFeatures, 1e-3f);
  const std::vector<int> chosen = {2, 0};
  const TrainingBatch shown = batch_of(plain, set, chosen, 50, {}, 1),
                      hidden = batch_of(plain, set, chosen, 50, {1, 0, 0}, 1);
  EXPECT_EQ(shown.target, hidden.target);
  for (size_t i = 0; i < hidden.features.size(); ++i) {
    const int c = static_cast<int>(i % kFeatures);
    const bool part = c >= kFirstPartFeature && c < kFirstPartFeature + kPartFeatures;
    ASSERT_EQ(hidden.features[i], part ? 0 : shown.features[i]) << c;
  }
}

TEST(TrainingSet, DisturbsFeaturesAlikeForAllSamplesOfAnObject) {
  const TrainingSet set = make_training_set({1, 9, true, 1}, std::vector<std::string>{"flower"});
  DistributionNetwork plain;
  plain.shift.assign(kFeatures, 0.0f);
  plain.scale.assign(kFeatures, 1e-3f);
  const std::vector<int> chosen = {0};
  const auto shown = batch_of(plain, set, chosen, 50, {}, 1), moved = batch_of(plain, set, chosen, 50, {0, 0, 0.5}, 1),
             part = batch_of(plain, set, chosen, 50, {0, 0.5, 0.5}, 1);
  double square = 0;
  int hidden = 0;
  for (int c = 0; c < kFeatures; ++c) {
    const float offset = moved.features[c] - shown.features[c];
    square += offset * offset / kFeatures;
    hidden += part.features[c] == 0;
    for (int i = 1; i < 50; ++i) {
      ASSERT_NEAR(moved.features[i * kFeatures + c] - shown.features[i * kFeatures + c], offset, 1e-5) << c;
      ASSERT_EQ(part.features[i * kFeatures + c] == 0, part.features[c] == 0) << c;
    }
  }
  EXPECT_NEAR(std::sqrt(square), 0.5, 0.2);
  EXPECT_GT(hidden, 5);
  EXPECT_LT(hidden, kFeatures - 5);
  EXPECT_EQ(kFeatureGroups[std::size(kFeatureGroups) - 1], kFeatures);
}

}  // namespace
}  // namespace pliant
