#include "fitting/distribution/train_distribution.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>

#include "fitting/distribution/calibrate.h"
#include "fitting/distribution/distribution_loss.h"
#include "fitting/distribution/safetensors.h"
#include "fitting/distribution/training_set.h"
#include "gaussians/base/adam.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace {

using nlohmann::json;
constexpr uint64_t kValidationSeeds = 1'000'000'000;  // beyond those of training

/// A digest of all that is learned from objects that are given besides.
std::string digest_of(std::span<const MaterialObject> objects) {
  std::string bytes;
  const auto add = [&](const auto& values) {
    bytes += std::to_string(values.size()) + ":";
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0]));
  };
  for (const MaterialObject& o : objects) {
    add(o.samples.position);
    add(o.samples.volume);
    add(o.samples.thickness);
    add(o.samples.rod);
    add(std::vector<float>{o.samples.spacing});
    add(o.colour);
    add(o.part);
    add(o.up);
    add(o.young);
    add(o.poisson);
    add(o.density);
  }
  return objects.empty() ? "none" : sha256_of_text(bytes);
}

json json_of(const TrainDistributionOptions& o, std::span<const MaterialObject> more) {
  return {{"objects", o.objects},
          {"validation_objects", o.validation_objects},
          {"epochs", o.epochs},
          {"members", o.members},
          {"rate", o.rate},
          {"decay", o.decay},
          {"hidden", o.hidden},
          {"batch_objects", o.batch_objects},
          {"seed", o.seed},
          {"batch_samples", o.batch_samples},
          {"threads", o.threads},
          {"hidden_parts", o.disturbance.hidden_parts},
          {"hidden_groups", o.disturbance.hidden_groups},
          {"offset", o.disturbance.offset},
          {"more_objects", digest_of(more)}};
}

void validate(const TrainDistributionOptions& o) {
  const auto require = [](bool good, const char* field, const std::string& remedy) {
    if (!good) throw usage_error("training", field, "is impossible", remedy);
  };
  require(o.objects >= 2, "objects", "give at least two");
  require(o.validation_objects >= 1, "validation_objects", "give at least one");
  require(o.members >= 1 && o.members <= kMostMembers, "members", "use 1 to " + std::to_string(kMostMembers));
  require(o.epochs >= 1, "epochs", "give at least one");
  require(o.rate > 0 && o.rate < 1, "rate", "about 1e-3 is usual");
  require(o.decay >= 0 && o.decay < 1 / o.rate, "decay", "about 1e-2 is usual, 0 is none");
  require(o.hidden >= 4 && o.hidden <= 512, "hidden", "use 4 to 512");
  require(o.batch_objects >= 1, "batch_objects", "give at least one");
  require(o.batch_samples >= 1 && o.batch_samples <= kContextSamples, "batch_samples", "use at most 256");
  const Disturbance& d = o.disturbance;
  require(d.hidden_parts >= 0 && d.hidden_parts <= 1, "hidden_parts", "give a share from 0 to 1");
  require(d.hidden_groups >= 0 && d.hidden_groups < 1, "hidden_groups", "give a share from 0 to less than 1");
  require(d.offset >= 0 && d.offset <= 2, "offset", "give 0 to 2");
  require(o.threads >= 1, "threads", "give at least one");
}

/// Everything that changes while it trains.  Members are trained one after the other.
struct TrainingRun {
  std::vector<std::vector<float>> trained;  ///< members that are done
  std::vector<float> parameters, first_moment, second_moment;
  std::vector<TrainingEpoch> curve;  ///< of all members
};

void save(const std::filesystem::path& file, const TrainingRun& run, const std::string& options) {
  json curve = json::array();
  for (const TrainingEpoch& e : run.curve) curve.push_back({e.member, e.train, e.validation});
  SafeTensors content;
  const auto add = [&](const std::string& name, const std::vector<float>& values) {
    content.arrays[name] = {{static_cast<int64_t>(values.size())}, values};
  };
  for (size_t m = 0; m < run.trained.size(); ++m) add("trained" + std::to_string(m), run.trained[m]);
  add("parameters", run.parameters);
  add("first_moment", run.first_moment);
  add("second_moment", run.second_moment);
  content.metadata = {{"kind", "pliant training checkpoint 1"}, {"options", options}, {"curve", curve.dump()}};
  write_safetensors(file, content);
}

TrainingRun load(const std::filesystem::path& path, const std::string& options, size_t parameters, int epochs) {
  const std::string file = path.string();
  const SafeTensors content = read_safetensors(path);
  if (content.text("options", file) != options)
    throw input_error(file, "options", "are those of another training: " + content.text("options", file),
                      "repeat that command, or remove the file");
  const auto values = [&](const std::string& name) {
    return content.values(name, {static_cast<int64_t>(parameters)}, file);
  };
  TrainingRun run{{}, values("parameters"), values("first_moment"), values("second_moment"), {}};
  try {
    for (const json& e : json::parse(content.text("curve", file)))
      run.curve.push_back({e.at(0), e.at(1), e.at(2), static_cast<int>(run.curve.size()) + 1});
  } catch (const json::exception& error) {
    throw input_error(file, "curve", error.what(), "remove the file; the training starts anew");
  }
  for (size_t m = 0; m < run.curve.size() / epochs; ++m) run.trained.push_back(values("trained" + std::to_string(m)));
  return run;
}

/// Shift and scale of the features and the wide Gaussian of z, from the training values.
void measure(const TrainingSet& set, DistributionNetwork& network) {
  const size_t rows = set.features.size() / kFeatures;
  std::vector<double> sum(kFeatures), square(kFeatures);
  double z = 0, zz = 0;
  for (size_t r = 0; r < rows; ++r) {
    for (int c = 0; c < kFeatures; ++c) {
      const double v = set.features[r * kFeatures + c];
      sum[c] += v / static_cast<double>(rows);
      square[c] += v * v / static_cast<double>(rows);
    }
    const double v = set.target[3 * r];
    z += v / static_cast<double>(rows);
    zz += v * v / static_cast<double>(rows);
  }
  network.shift.resize(kFeatures);
  network.scale.resize(kFeatures);
  for (int c = 0; c < kFeatures; ++c) {
    network.shift[c] = static_cast<float>(sum[c]);
    network.scale[c] = static_cast<float>(1 / std::sqrt(std::max(1e-6, square[c] - sum[c] * sum[c])));
  }
  network.wide_mean = static_cast<float>(z);
  network.wide_sigma = static_cast<float>(std::max(0.1, std::sqrt(std::max(0.0, zz - z * z))));
}

std::vector<int> numbers_below(size_t n) {
  std::vector<int> out(n);
  std::iota(out.begin(), out.end(), 0);
  return out;
}

}  // namespace

TrainDistributionResult train_distribution(const TrainDistributionOptions& o, std::span<const MaterialObject> more,
                                           const std::filesystem::path& checkpoint,
                                           const std::function<bool(const TrainingEpoch&)>& going_on) {
  validate(o);
  require_network_training();
  const uint64_t first = o.seed * 1'000'000;
  const TrainingSet train =
      make_training_set({o.objects, first, true, o.threads}, corpus_families(FamilyRole::kTrain), more);
  const TrainingSet held = make_training_set({o.validation_objects, first + kValidationSeeds, false, o.threads},
                                             corpus_families(FamilyRole::kValidate));
  DistributionNetwork network;
  network.size.hidden = o.hidden;
  measure(train, network);
  const auto loss = make_distribution_loss(network, o.threads);
  const std::vector<int> held_objects = numbers_below(held.objects());
  std::vector<TrainingBatch> held_batches;
  for (size_t k = 0; k < held_objects.size(); k += 32)
    held_batches.push_back(batch_of(network, held,
                                    std::span(held_objects).subspan(k, std::min<size_t>(32, held_objects.size() - k)),
                                    kContextSamples, {}, 0));

  const size_t count = network_parameters(network.size);
  const std::string key = json_of(o, more).dump();
  TrainingRun run;
  if (!checkpoint.empty() && std::filesystem::exists(checkpoint)) run = load(checkpoint, key, count, o.epochs);

  using Clock = std::chrono::steady_clock;
  auto saved = Clock::now();
  std::vector<float> gradient(count);
  const auto ended = [&] { return run.trained.size() == static_cast<size_t>(o.members); };
  bool go_on = true;
  while (go_on && !ended()) {
    TrainingEpoch row{static_cast<int>(run.trained.size())};
    const int epoch = static_cast<int>(run.curve.size()) % o.epochs;
    const uint64_t seed = Random(o.seed, row.member, 1).bits();
    if (epoch == 0) {
      run.parameters = initial_parameters(network.size, seed);
      run.first_moment.assign(count, 0.0f);
      run.second_moment.assign(count, 0.0f);
    }
    std::vector<int> order;
    for (const int object : numbers_below(train.objects()))
      if (!leaves_out(o.members, row.member, train.family[object])) order.push_back(object);
    Random shuffle(seed, epoch, 2);
    for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[shuffle.below(i)]);
    const int batches = static_cast<int>((order.size() + o.batch_objects - 1) / o.batch_objects);
    Adam<float> adam(run.first_moment, run.second_moment, static_cast<long>(epoch) * batches);
    for (int b = 0; b < batches; ++b) {
      const size_t begin = static_cast<size_t>(b) * o.batch_objects;
      const auto chosen = std::span(order).subspan(begin, std::min<size_t>(o.batch_objects, order.size() - begin));
      const TrainingBatch batch =
          batch_of(network, train, chosen, o.batch_samples, o.disturbance, Random(seed, epoch, 3).bits());
      const double value = loss->value(run.parameters, batch, gradient);
      if (!std::isfinite(value)) throw numerical_error("training", "the loss is not finite", "use a smaller rate");
      row.train += value / batches;
      const double progress = (epoch + static_cast<double>(b) / batches) / o.epochs;
      const float rate = static_cast<float>(o.rate * (0.05 + 0.95 * 0.5 * (1 + std::cos(3.14159265358979 * progress))));
      for (float& p : run.parameters) p *= 1 - rate * static_cast<float>(o.decay);
      adam.step(run.parameters, gradient, rate);
    }
    run.first_moment = adam.first_moment();
    run.second_moment = adam.second_moment();
    for (const TrainingBatch& batch : held_batches)
      row.validation += loss->value(run.parameters, batch, {}) * batch.objects / static_cast<double>(held.objects());
    row.done = static_cast<int>(run.curve.size()) + 1;
    run.curve.push_back(row);
    if (epoch + 1 == o.epochs) run.trained.push_back(run.parameters);
    go_on = !going_on || going_on(row);
    const double minutes = std::chrono::duration<double>(Clock::now() - saved).count() / 60;
    if (!checkpoint.empty() && (!go_on || ended() || minutes >= o.checkpoint_minutes)) {
      save(checkpoint, run, key);
      saved = Clock::now();
    }
  }

  network.members = run.trained;
  if (!ended()) network.members.push_back(run.parameters);
  calibrate(train, held, network);
  network.recipe =
      json{{"options", json_of(o, more)}, {"validation_loss", run.curve.back().validation}, {"version", PLIANT_VERSION}}
          .dump();
  return {network, run.curve, ended()};
}

void write_curve(const std::filesystem::path& file, std::span<const TrainingEpoch> curve) {
  std::string text = "member,train,validation\n";
  for (const TrainingEpoch& e : curve)
    text += std::to_string(e.member) + "," + std::to_string(e.train) + "," + std::to_string(e.validation) + "\n";
  write_text(file, text);
}

}  // namespace pliant
