#include "app/segment/choose_object.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string_view>

#include "fitting/predict/label_words.h"
#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"

namespace pliant {
namespace {

/// How much of the pictures each object takes, near their middle above all: the sum over cameras and Gaussians of the
/// share of the picture, times the opacity, times exp(-(r / .35)^2) at a distance of r half diagonals from the middle.
std::map<uint32_t, double> prominence(const Scene& scene, const std::vector<uint32_t>& label) {
  constexpr double kWidth = 0.35;
  std::vector<double> share(label.size(), 0.0);
  parallel_for(
      static_cast<std::ptrdiff_t>(label.size()),
      [&](std::ptrdiff_t i) {
        const Vec3d position = scene.cloud.position[i].cast<double>();
        const double scale = std::exp(scene.cloud.log_scale[i].mean());
        for (const Camera& camera : scene.cameras) {
          const Vec3d x = camera.cam_from_world * position;
          if (x.z() <= 0) continue;
          const double half2 = 0.25 * (1.0 * camera.width * camera.width + 1.0 * camera.height * camera.height);
          const Eigen::Vector2d off(camera.fx * x.x() / x.z() + camera.cx - 0.5 * camera.width,
                                    camera.fy * x.y() / x.z() + camera.cy - 0.5 * camera.height);
          const double size = camera.fx * scale / x.z();
          share[i] += std::min(size * size / half2, 1.0) * std::exp(-off.squaredNorm() / half2 / (kWidth * kWidth));
        }
        share[i] *= sigmoid(scene.cloud.opacity_logit[i]);
      },
      1024);
  std::map<uint32_t, double> sum;
  for (size_t i = 0; i < label.size(); ++i) sum[label[i]] += share[i];
  return sum;
}

/// Whether one of two names has all words of the other: "palm" and "potted palm".
bool name_alike(std::string_view a, std::string_view b) {
  const auto words = [](std::string_view text) {
    std::set<std::string> set;
    for (const LabelWord& word : label_words(text)) set.insert(word.word);
    return set;
  };
  std::set<std::string> few = words(a), many = words(b);
  if (few.size() > many.size()) few.swap(many);
  return !few.empty() && std::includes(many.begin(), many.end(), few.begin(), few.end());
}

}  // namespace

std::vector<size_t> classes_called(const Segmentation& segmentation, const std::string& name) {
  std::vector<size_t> named;
  for (size_t c = 0; c < segmentation.class_id.size() && !name.empty(); ++c) {
    if (name == std::to_string(segmentation.class_id[c])) return {c};
    if (name == segmentation.class_name[c]) named.push_back(c);
  }
  return named;
}

ChosenClass choose_object(const Scene& scene, const Segmentation& segmentation, const ObjectHints& hints) {
  const std::vector<std::string>& names = segmentation.class_name;
  std::vector<size_t> all, candidates, called;
  for (size_t c = 0; c < names.size(); ++c)
    if (segmentation.class_id[c] != 0 || names[c] != "unlabelled") all.push_back(c);
  for (size_t c : all)
    if (names[c] != "rest" && names[c] != "background" &&
        std::find(hints.supports.begin(), hints.supports.end(), segmentation.class_id[c]) == hints.supports.end())
      candidates.push_back(c);
  if (candidates.size() == 1) return {candidates[0], "", false};
  const bool none = candidates.empty();
  if (none) candidates = all;
  if (candidates.empty())
    throw usage_error("--object", "", "cannot be chosen: the scene has no objects",
                      "point at one with --box, --click or --aabb");
  for (size_t c : candidates)
    if (name_alike(names[c], hints.label)) called.push_back(c);
  std::map<uint32_t, double> value = prominence(scene, segmentation.label);
  const std::vector<size_t>& among = called.empty() ? candidates : called;
  const size_t best = *std::max_element(among.begin(), among.end(), [&](size_t a, size_t b) {
    return value[segmentation.class_id[a]] < value[segmentation.class_id[b]];
  });
  if (!called.empty()) return {best, fmt::format("whose name matches --label '{}'", hints.label), false};
  if (none) return {best, "no free-standing object was found", false};
  return {best, fmt::format("the most prominent of {} objects near the middle of the views", candidates.size()),
          !hints.label.empty()};
}

}  // namespace pliant
