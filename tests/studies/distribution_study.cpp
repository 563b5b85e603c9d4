// How well does the distribution network know families that it has never seen?
//   distribution_study train WEIGHTS.safetensors CURVE.csv [SEED=0] [EPOCHS] [OBJECTS] [THREADS=1]
//   distribution_study figures OUT.json WEIGHTS.safetensors [MORE.safetensors ...] [-validate]
// `train` repeats the recipe of the bundled weights.  `figures` judges each file on the same objects: 40 of every
// test family and 40 of each family of held_out_families.h, which was written apart from the training corpus; with
// -validate on the validation families instead.  Spread: lowest and highest over the files, which are retrainings by
// other seeds.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "fitting/distribution/distribution_figures.h"
#include "fitting/distribution/object_corpus.h"
#include "fitting/distribution/train_distribution.h"
#include "gaussians/io/files/json_file.h"
#include "tests/studies/held_out_families.h"

using namespace pliant;
using nlohmann::json;

namespace {

constexpr int kObjects = 40;
constexpr uint64_t kSeeds = 2'000'000'000;  // beyond those of training and validation

int train(int argc, char** argv) {
  TrainDistributionOptions options;
  if (argc > 4) options.seed = std::strtoull(argv[4], nullptr, 10);
  if (argc > 5) options.epochs = std::atoi(argv[5]);
  if (argc > 6) options.objects = std::atoi(argv[6]);
  if (argc > 7) options.threads = std::atoi(argv[7]);
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  const std::filesystem::path checkpoint = std::string(argv[2]) + ".checkpoint";
  const auto result = train_distribution(options, {}, checkpoint, [&](const TrainingEpoch& e) {
    std::printf("member %d: train %.4f, validation %.4f (%.0f s)\n", e.member, e.train, e.validation, seconds());
    std::fflush(stdout);
    return true;
  });
  write_network(argv[2], result.network);
  write_curve(argv[3], result.curve);
  std::filesystem::remove(checkpoint);
  std::printf("temperature %.2f, wide weight %.2f, tail %.3f, z %.2f +- %.2f, %.0f s\n", result.network.temperature,
              result.network.wide_weight, result.network.tail, result.network.wide_mean, result.network.wide_sigma,
              seconds());
  return 0;
}

json row_of(const DistributionFigures& f) {
  return {{"family", f.family},
          {"objects", f.objects},
          {"samples", f.samples},
          {"error", f.error},
          {"error_of_mean", f.error_of_mean},
          {"ratio", f.error / f.error_of_mean},
          {"log_density", f.log_density},
          {"log_density_of_one_gaussian", f.log_density_of_one},
          {"coverage_80", f.coverage},
          {"density_error", f.density_error},
          {"density_error_of_mean", f.density_error_of_mean},
          {"poisson_error", f.poisson_error},
          {"poisson_error_of_mean", f.poisson_error_of_mean}};
}

int figures(int argc, char** argv) {
  std::vector<MaterialObject> objects;
  const bool validate = std::string(argv[argc - 1]) == "-validate";
  for (const std::string& family : corpus_families(validate ? FamilyRole::kValidate : FamilyRole::kTest))
    for (int k = 0; k < kObjects; ++k) objects.push_back(make_object(family, kSeeds + k));
  for (const std::string& family : study::held_out_families())
    for (int k = 0; k < kObjects && !validate; ++k) objects.push_back(study::make_held_out(family, kSeeds + k));
  json files = json::array();
  std::map<std::string, std::array<double, 2>> ratio, coverage;
  for (int a = 3; a < argc - validate; ++a) {
    const DistributionNetwork network = read_network(argv[a]);
    json rows = json::array();
    std::printf("%s\n%-16s %8s %8s %6s %8s %8s %6s  %6s/%6s  %6s/%6s\n", argv[a], "family", "error", "of mean", "ratio",
                "log p", "one", "80 %", "rho", "mean", "nu", "mean");
    for (const DistributionFigures& f : distribution_figures(network, objects)) {
      std::printf("%-16s %8.3f %8.3f %6.2f %8.3f %8.3f %6.1f  %6.3f/%6.3f  %6.3f/%6.3f\n", f.family.c_str(), f.error,
                  f.error_of_mean, f.error / f.error_of_mean, f.log_density, f.log_density_of_one, 100 * f.coverage,
                  f.density_error, f.density_error_of_mean, f.poisson_error, f.poisson_error_of_mean);
      rows.push_back(row_of(f));
      const auto widen = [](std::array<double, 2>& range, double value, bool fresh) {
        range = fresh ? std::array{value, value} : std::array{std::min(range[0], value), std::max(range[1], value)};
      };
      widen(ratio[f.family], f.error / f.error_of_mean, a == 3);
      widen(coverage[f.family], f.coverage, a == 3);
    }
    files.push_back({{"weights", std::filesystem::path(argv[a]).filename().string()},
                     {"recipe", json::parse(network.recipe)},
                     {"rows", rows}});
  }
  write_json(
      argv[2],
      {{"objects_per_family", kObjects}, {"files", files}, {"ratio_spread", ratio}, {"coverage_spread", coverage}});
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string mode = argc > 3 ? argv[1] : "";
  if (mode == "train") return train(argc, argv);
  if (mode == "figures") return figures(argc, argv);
  std::fprintf(stderr, "usage: %s train WEIGHTS CURVE.csv [SEED] ... | figures OUT.json WEIGHTS...\n", argv[0]);
  return 2;
}
