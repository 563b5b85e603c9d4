#include <sstream>

#include "fitting/distribution/distribution_network.h"
#include "fitting/distribution/safetensors.h"
#include "gaussians/base/embed.h"
#include "gaussians/base/error.h"

PLIANT_EMBED(pliant_distribution_weights, PLIANT_DISTRIBUTION_WEIGHTS);

namespace pliant {
namespace {

constexpr const char* kKind = "pliant distribution network 1";

DistributionNetwork network_of(const SafeTensors& content, const std::string& file) {
  const auto wrong = [&](const std::string& field, const std::string& problem) {
    return input_error(file, field, problem, "train again with train-predictor, or use the bundled weights");
  };
  if (content.text("kind", file) != kKind)
    throw wrong("kind", "is '" + content.text("kind", file) + "', not '" + kKind + "'");
  if (content.text("features", file) != feature_names())
    throw wrong("features", "differ from those that this version computes");
  DistributionNetwork n;
  std::istringstream hidden(content.text("hidden", file));
  if (!(hidden >> n.size.hidden) || n.size.hidden < 1 || n.size.hidden > 1024) throw wrong("hidden", "is no width");
  n.shift = content.values("shift", {kFeatures}, file);
  n.scale = content.values("scale", {kFeatures}, file);
  do {
    const std::string member = "member" + std::to_string(n.members.size());
    std::vector<float>& parameters = n.members.emplace_back();
    int layer = 0;
    for (const auto [in, out] : network_layers(n.size)) {
      const std::string name = member + ".layer" + std::to_string(layer++);
      for (const auto& part :
           {content.values(name + ".weight", {out, in}, file), content.values(name + ".bias", {out}, file)})
        parameters.insert(parameters.end(), part.begin(), part.end());
    }
  } while (content.arrays.count("member" + std::to_string(n.members.size()) + ".layer0.weight"));
  const auto& calibration = content.values("calibration", {5}, file);
  n.wide_mean = calibration[0];
  n.wide_sigma = calibration[1];
  n.wide_weight = calibration[2];
  n.temperature = calibration[3];
  n.tail = calibration[4];
  for (const auto& [name, array] : content.arrays)
    for (const float v : array.values)
      if (!std::isfinite(v)) throw wrong(name, "contains values that are not finite");
  if (!(n.wide_sigma > 0 && n.temperature > 0 && n.wide_weight >= 0 && n.wide_weight < 1 && n.tail > 0 &&
        n.tail < 0.5f))
    throw wrong("calibration", "is outside of its range");
  n.recipe = content.text("recipe", file);
  return n;
}

}  // namespace

DistributionNetwork read_network(const std::filesystem::path& file) {
  return network_of(read_safetensors(file), file.string());
}

void write_network(const std::filesystem::path& file, const DistributionNetwork& n) {
  SafeTensors content;
  content.metadata = {{"kind", kKind},
                      {"features", std::string(feature_names())},
                      {"hidden", std::to_string(n.size.hidden)},
                      {"recipe", n.recipe}};
  content.arrays["shift"] = {{kFeatures}, n.shift};
  content.arrays["scale"] = {{kFeatures}, n.scale};
  content.arrays["calibration"] = {{5}, {n.wide_mean, n.wide_sigma, n.wide_weight, n.temperature, n.tail}};
  for (size_t m = 0; m < n.members.size(); ++m) {
    auto at = n.members[m].begin();
    int layer = 0;
    for (const auto [in, out] : network_layers(n.size)) {
      const std::string name = "member" + std::to_string(m) + ".layer" + std::to_string(layer++);
      content.arrays[name + ".weight"] = {{out, in}, {at, at + in * out}};
      content.arrays[name + ".bias"] = {{out}, {at + in * out, at + in * out + out}};
      at += (in + 1) * out;
    }
  }
  write_safetensors(file, content);
}

DistributionNetwork shipped_network() {
  const std::string_view bytes(
      pliant_distribution_weights_begin,
      static_cast<size_t>(pliant_distribution_weights_end - pliant_distribution_weights_begin));
  return network_of(parse_safetensors(bytes, "distribution.safetensors"), "distribution.safetensors");
}

}  // namespace pliant
