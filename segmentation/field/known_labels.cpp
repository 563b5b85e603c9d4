#include "segmentation/field/known_labels.h"

#include <algorithm>
#include <set>

#include "gaussians/base/error.h"
#include "segmentation/field/vote.h"

namespace pliant {
namespace {

constexpr double kLongestSide = 200;  // px, of the id pictures

}  // namespace

Segmentation segmentation_of_labels(std::span<const uint32_t> label, const std::map<uint32_t, std::string>& names,
                                    const GaussianCloud& cloud, const std::vector<Camera>& cameras, uint64_t seed,
                                    bool antialiased) {
  CHECK(label.size() == cloud.size());
  Segmentation out;
  out.antialiased = antialiased;
  const std::set<uint32_t> ids(label.begin(), label.end());
  out.class_id.assign(ids.begin(), ids.end());
  for (const uint32_t id : ids) {
    const auto name = names.find(id);
    out.class_name.push_back(name == names.end() ? std::to_string(id) : name->second);
  }
  const std::vector<float> codes = class_codes(static_cast<int>(ids.size()), seed);
  const float sharpness = code_sharpness(codes);
  for (const float c : codes) out.classifier.push_back(sharpness * c);
  out.classifier_bias.assign(ids.size(), 0.0f);
  out.attribute.resize(cloud.size() * kSemanticChannels);
  for (size_t p = 0; p < cloud.size(); ++p) {
    const auto c = std::lower_bound(out.class_id.begin(), out.class_id.end(), label[p]) - out.class_id.begin();
    std::copy_n(codes.begin() + c * kSemanticChannels, kSemanticChannels,
                out.attribute.begin() + static_cast<std::ptrdiff_t>(p) * kSemanticChannels);
  }
  out.seen.assign(cloud.size(), 1);
  update_labels(out);
  std::vector<Camera> small;
  for (const Camera& camera : cameras)
    small.push_back(camera.scaled(std::min(1.0, kLongestSide / std::max(camera.width, camera.height))));
  find_class_cameras(cloud, small, out);
  return out;
}

}  // namespace pliant
