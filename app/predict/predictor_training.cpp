#include "app/predict/predictor_training.h"

#include <fmt/format.h>
#include <omp.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/predict/object_samples.h"
#include "app/run/attach_scene.h"
#include "fitting/distribution/distribution_figures.h"
#include "fitting/distribution/distribution_loss.h"
#include "fitting/distribution/object_corpus.h"
#include "fitting/distribution/train_distribution.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/json_file.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kTrainedPerJudged = 270;            // objects of the training for one of each test family
constexpr uint64_t kJudgedSeeds = 2'000'000'000;  // beyond those of training and validation

json figures_of(const DistributionNetwork& network, int each) {
  std::vector<MaterialObject> objects;
  for (const std::string& family : corpus_families(FamilyRole::kTest))
    for (int k = 0; k < each; ++k) objects.push_back(make_object(family, kJudgedSeeds + k));
  json rows = json::array();
  for (const DistributionFigures& f : distribution_figures(network, objects))
    rows.push_back({{"family", f.family},
                    {"objects", f.objects},
                    {"error_log10_young", f.error},
                    {"error_of_mean_alone", f.error_of_mean},
                    {"log_density", f.log_density},
                    {"log_density_of_one_gaussian", f.log_density_of_one},
                    {"coverage_of_80_percent", f.coverage},
                    {"error_log10_density", f.density_error},
                    {"error_log10_density_of_mean_alone", f.density_error_of_mean},
                    {"error_poisson", f.poisson_error},
                    {"error_poisson_of_mean_alone", f.poisson_error_of_mean}});
  return rows;
}

}  // namespace

TrainPredictor::TrainPredictor() {
  const TrainDistributionOptions recipe;
  count = recipe.objects;
  members = recipe.members;
  epochs = recipe.epochs;
}

json run_training(const Context& context, const TrainPredictor& training, const std::string& out) {
  require_network_training();
  std::vector<MaterialObject> more;
  for (const std::string& folder : training.runs) {
    const RunDirectory run = RunDirectory::open(folder);
    more.push_back(fitted_object(run, load_run_scene(run)));
  }
  for (const std::string& folder : training.objects)
    for (MaterialObject& object : splat_objects(folder, context.seed)) more.push_back(std::move(object));
  const fs::path directory = out, weights = directory / "predictor.safetensors";
  if (fs::exists(weights) && !context.overwrite)
    throw usage_error("--out", weights.string(), "exists", "give another folder, or --overwrite");
  fs::create_directories(directory);
  TrainDistributionOptions options;
  options.objects = training.count;
  options.validation_objects =
      std::max(5, training.count * options.validation_objects / TrainDistributionOptions().objects);
  options.members = training.members;
  options.epochs = training.epochs;
  options.seed = context.seed;
  options.threads = omp_get_max_threads();
  const fs::path checkpoint = directory / "checkpoint.safetensors";
  const int total = options.members * options.epochs;
  context.progress.begin("train-predictor", total);
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  int here = 0;  // epochs since the begin, by which the remaining time goes
  const TrainDistributionResult result = train_distribution(options, more, checkpoint, [&](const TrainingEpoch& epoch) {
    const double each = std::chrono::duration<double>(Clock::now() - begin).count() / ++here;
    context.progress.done(std::min(epoch.done, total), "", each * (total - epoch.done));
    return !context.interrupted();
  });
  context.progress.end();
  write_curve(directory / "curve.csv", result.curve);
  if (!result.finished)
    throw Error(Failure::kInterrupted, "train-predictor", "", "interrupted", "run the same command to continue");
  const json figures = figures_of(result.network, std::max(2, training.count / kTrainedPerJudged));
  write_json(directory / "figures.json", figures);
  write_network(weights, result.network);
  fs::remove(checkpoint);
  const json& all = figures.back();
  context.progress.say(
      fmt::format("train-predictor: families that it never saw: log10 E is off by {:.2f} (median; {:.2f} by the mean "
                  "alone), {:.0f} "
                  "% lie in their 80 % interval\nweights: {}",
                  all["error_log10_young"].get<double>(), all["error_of_mean_alone"].get<double>(),
                  100 * all["coverage_of_80_percent"].get<double>(), weights.string()));
  return {{"weights", weights.string()}, {"figures", figures}};
}

OptionTable options_of(TrainPredictor& training) {
  return {"train-predictor",
          {{.name = "count",
            .field = &training.count,
            .help = "Number of procedural training objects",
            .low = 18,
            .high = 1e6},
           {.name = "members",
            .field = &training.members,
            .help = "Number of networks in the ensemble",
            .low = 1,
            .high = kMostMembers},
           {.name = "epochs", .field = &training.epochs, .help = "Epochs of each network", .low = 1, .high = 10000},
           {.name = "add-run",
            .field = &training.runs,
            .help = "Run directory whose fitted object is added to the training set; repeatable",
            .value = "DIR",
            .exists = true},
           {.name = "objects",
            .field = &training.objects,
            .help = "Folder of splat files to add, each with a material field of the same name; repeatable",
            .value = "DIR",
            .exists = true}}};
}

}  // namespace pliant
