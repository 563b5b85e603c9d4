#include <fmt/format.h>

#include <map>

#include "app/fit/fit_scene.h"
#include "app/store/segmentation.h"
#include "fitting/fields/weighted_field.h"
#include "fitting/fit/parts.h"
#include "fitting/fit/settle_parts.h"
#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"

namespace pliant {
namespace {

/// Calls visit(driver, Gaussian, weight) for everything that drivers move, by its share and its opacity.
template <class Visit>
void visit_moved(const DrawnObject<float>& drawn, Visit&& visit) {
  for (size_t g = 0; g < drawn.object.size(); ++g)
    for (int k = 0; k < Binding::kCount; ++k) {
      const size_t slot = g * Binding::kCount + k;
      const int d = drawn.binding.driver[slot];
      if (d < 0) break;
      visit(d, g, drawn.binding.weight[slot] * sigmoid(drawn.object.opacity_logit[g]));
    }
}

constexpr float kLeastWeight = 0.05f;  // of all that a driver moves, below which it takes after its nearest neighbour

/// [drivers] index of the nearest driver that moves something: itself, mostly; -1 where none does.
std::vector<int> speakers(const DrawnObject<float>& drawn, const std::vector<float>& weight) {
  std::vector<Vec3f> position;
  std::vector<int> which, out(drawn.drivers.size(), -1);
  for (size_t d = 0; d < weight.size(); ++d)
    if (weight[d] > kLeastWeight) {
      position.push_back(drawn.drivers[d]);
      which.push_back(static_cast<int>(d));
    }
  if (position.empty()) return out;
  const std::vector<int> nearest = k_nearest(position, drawn.drivers, 1);
  for (size_t d = 0; d < out.size(); ++d) out[d] = which[nearest[d]];
  return out;
}

}  // namespace

std::vector<uint32_t> parts_of(const FitScene& fit, int count) {
  const DrawnObject<float>& drawn = *fit.drawn;
  const size_t drivers = drawn.drivers.size();
  std::vector<Vec3f> sum(drivers, Vec3f::Zero()), color(drivers, Vec3f::Zero());
  std::vector<float> weight(drivers, 0.0f);
  visit_moved(drawn, [&](int d, size_t g, float w) {
    const float* sh = drawn.object.sh_of(g);
    sum[d] += w * (Vec3f::Constant(0.5f) + kSh0 * Vec3f(sh[0], sh[1], sh[2])).cwiseMax(0).cwiseMin(1);
    weight[d] += w;
  });
  const std::vector<int> of = speakers(drawn, weight);
  for (size_t d = 0; d < drivers; ++d)
    if (of[d] >= 0) color[d] = sum[of[d]] / weight[of[d]];
  std::vector<uint8_t> held;
  for (const double free : free_particles(fit.body.particles, fit.pins)) held.push_back(free == 0);
  PartsOptions options;
  options.count = count;
  std::vector<uint8_t> thin(drivers, 0);
  for (size_t d = 0; d < drivers && !fit.body.file.driving_thickness.empty(); ++d)
    thin[d] = fit.body.file.driving_thickness[d] > 0;
  std::vector<uint32_t> patches = find_parts(options, drawn.drivers, color, held);
  const auto materials = join_alike(options, patches, color, thin, held);
  return materials ? settle_parts(SettleOptions(), *materials, drawn.drivers, color, thin, held) : patches;
}

std::vector<uint32_t> labelled_parts(const FitScene& fit, const Scene& scene, const std::string& file) {
  const LabelFile labels = read_labels(file);
  if (labels.label.size() != scene.cloud.size())
    throw input_error(file, "label",
                      fmt::format("has {} labels and the scene {} Gaussians", labels.label.size(), scene.cloud.size()),
                      "give labels of this scene's Gaussians, in their order");
  const DrawnObject<float>& drawn = *fit.drawn;
  // An object's Gaussians are copies of the scene's.
  const std::vector<int> original = k_nearest(scene.cloud.position, drawn.object.position, 1);
  std::vector<std::map<uint32_t, float>> votes(drawn.drivers.size());
  std::vector<float> weight(drawn.drivers.size(), 0.0f);
  visit_moved(drawn, [&](int d, size_t g, float w) {
    votes[d][labels.label[original[g]]] += w;
    weight[d] += w;
  });
  const std::vector<int> of = speakers(drawn, weight);
  std::map<uint32_t, uint32_t> number;  // of the parts, without gaps
  std::vector<uint32_t> part(drawn.drivers.size(), 0);
  for (size_t d = 0; d < part.size(); ++d) {
    if (of[d] < 0) continue;
    const auto& vote = votes[of[d]];
    const auto best =
        std::max_element(vote.begin(), vote.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    part[d] = number.emplace(best->first, static_cast<uint32_t>(number.size())).first->second;
  }
  if (number.size() < 2)
    throw input_error(file, "label", "is the same for all moving Gaussians",
                      "give labels that distinguish parts, or use --field uniform");
  return part;
}

}  // namespace pliant
