#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/evaluate/evaluate.h"
#include "app/evaluate/metrics.h"
#include "app/store/material.h"
#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

MaterialFile read_placed(const fs::path& path) {
  std::error_code ignored;
  const fs::path file = fs::is_directory(path, ignored) ? path / "material.h5" : path;
  MaterialFile m = read_material(file);
  if (m.young.empty()) throw input_error(file.string(), "/solid/young", "is empty", "give the material of an object");
  if (m.position.empty()) {
    throw input_error(file.string(), "/solid/position",
                      "is missing, and next to the file is no particles.h5 of as many samples",
                      "keep material.h5 beside the particles.h5 that it was made for");
  }
  return m;
}

}  // namespace

json evaluate_material(const fs::path& prediction, const fs::path& truth_path) {
  const MaterialFile ours = read_placed(prediction), truth = read_placed(truth_path);
  const std::vector<int> partner = k_nearest(ours.position, truth.position, 1);
  const size_t n = truth.young.size();
  std::vector<double> error(n);
  double bias = 0, weighted = 0, volume = 0, largest = 0, poisson = 0, density = 0;
  for (size_t i = 0; i < n; ++i) {
    const auto k = static_cast<size_t>(partner[i]);
    const double signed_error = std::log10(static_cast<double>(ours.young[k]) / truth.young[i]);
    error[i] = std::abs(signed_error);
    largest = std::max(largest, error[i]);
    bias += signed_error / static_cast<double>(n);
    weighted += truth.volume[i] * error[i];
    volume += truth.volume[i];
    poisson += std::abs(static_cast<double>(ours.poisson[k]) - truth.poisson[i]) / static_cast<double>(n);
    density += std::abs(static_cast<double>(ours.density[k]) / truth.density[i] - 1) / static_cast<double>(n);
  }
  json out = {{"kind", "material"}, {"samples", ours.young.size()}, {"samples_in_truth", n}, {"source", ours.source}};
  add_statistics(out, "log10_young_error", error);
  out["log10_young_error_volume_weighted"] = volume > 0 ? json(weighted / volume) : json(nullptr);
  out["log10_young_error_max"] = largest;
  out["log10_young_bias"] = bias;
  out["poisson_error"] = poisson;
  out["density_relative_error"] = density;
  return out;
}

}  // namespace pliant
