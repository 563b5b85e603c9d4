#include "segmentation/select/selection.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/render/render.h"

namespace pliant {
namespace {

std::string text_of(const std::vector<double>& values) {
  std::ostringstream out;
  for (size_t i = 0; i < values.size(); ++i) out << (i ? "," : "") << values[i];
  return out.str();
}

std::string text_of(const Vec3f& x) { return text_of(std::vector<double>{x.x(), x.y(), x.z()}); }

void check_numbers(const std::vector<double>& values, size_t count, const char* option, const char* form) {
  bool finite = true;
  for (double value : values) finite = finite && std::isfinite(value);
  if (values.size() != count || !finite)
    throw usage_error(option, "", "has the value " + text_of(values), std::string("give ") + form + " in scene units");
}

}  // namespace

SelectionShape SelectionShape::from_aabb(const std::vector<double>& v) {
  check_numbers(v, 6, "--aabb", "six numbers x0,y0,z0,x1,y1,z1");
  SelectionShape shape;
  shape.box.add(Vec3f(v[0], v[1], v[2]));
  shape.box.add(Vec3f(v[3], v[4], v[5]));
  if (!(shape.box.size().minCoeff() > 0))
    throw usage_error("--aabb", "", "encloses no volume: " + text_of(v), "give two opposite corners of a box");
  return shape;
}

SelectionShape SelectionShape::from_sphere(const std::vector<double>& v) {
  check_numbers(v, 4, "--sphere", "four numbers x,y,z,r");
  if (!(v[3] > 0)) throw usage_error("--sphere", "r", "is " + text_of({v[3]}), "give a radius above 0");
  SelectionShape shape;
  shape.sphere = true;
  shape.centre = Vec3f(v[0], v[1], v[2]);
  shape.radius = static_cast<float>(v[3]);
  return shape;
}

bool SelectionShape::contains(const Vec3f& x, float margin) const {
  if (sphere) return (x - centre).norm() <= radius + margin;
  return (x.array() >= box.low.array() - margin).all() && (x.array() <= box.high.array() + margin).all();
}

MaskSet member_masks(const std::string& option, std::span<const uint8_t> members, const GaussianCloud& cloud,
                     const std::vector<Camera>& cameras) {
  CHECK(members.size() == cloud.size());
  std::vector<float> member(cloud.size() * 2);
  size_t inside = 0;
  for (size_t p = 0; p < cloud.size(); ++p) {
    const bool in = members[p] != 0;
    inside += in;
    member[2 * p] = in;
    member[2 * p + 1] = !in;
  }
  MaskSet masks;
  masks.names = {{SelectionShape::kObject, "object"}, {SelectionShape::kRest, "rest"}};
  if (inside == cloud.size())
    masks.warnings.push_back(option + " contains all " + std::to_string(inside) +
                             " Gaussians: the whole scene is the object and nothing is left as background");
  for (size_t c = 0; c < cameras.size(); ++c) {
    const RenderResult picture = render(cloud, cameras[c], {}, member, 2);
    IdImage ids(cameras[c].width, cameras[c].height, 1);
    for (int y = 0; y < ids.height; ++y)
      for (int x = 0; x < ids.width; ++x)
        if (picture.alpha(x, y) >= 0.5f)
          ids(x, y) =
              picture.features(x, y, 0) > picture.features(x, y, 1) ? SelectionShape::kObject : SelectionShape::kRest;
    masks.views.push_back({static_cast<int>(c), std::move(ids)});
  }
  const std::vector<uint32_t> ids = masks.ids();
  if (ids.empty() || ids.front() != SelectionShape::kObject)
    throw usage_error(option, "", "selects " + std::to_string(inside) + " Gaussians that no camera sees",
                      "choose a region that the cameras see");
  return masks;
}

MaskSet selection_masks(const SelectionShape& shape, const GaussianCloud& cloud, const std::vector<Camera>& cameras) {
  std::vector<uint8_t> member(cloud.size());
  for (size_t p = 0; p < cloud.size(); ++p) member[p] = shape.contains(cloud.position[p]);
  const char* option = shape.sphere ? "--sphere" : "--aabb";
  if (std::count(member.begin(), member.end(), 1) == 0) {
    const Box bounds = cloud.bounds();
    throw usage_error(
        option, "", "contains no Gaussians",
        "the scene spans " + text_of(bounds.low) + " to " + text_of(bounds.high) + ": `pliant info` prints it");
  }
  return member_masks(option, member, cloud, cameras);
}

size_t restrict_to_selection(const SelectionShape& shape, const GaussianCloud& cloud, Segmentation& segmentation,
                             float margin) {
  CHECK(segmentation.label.size() == cloud.size());
  std::vector<uint8_t> keep(cloud.size());
  for (size_t p = 0; p < cloud.size(); ++p) keep[p] = shape.contains(cloud.position[p], margin * shape.extent());
  return restrict_to_members(keep, segmentation);
}

size_t restrict_to_members(std::span<const uint8_t> keep, Segmentation& segmentation) {
  constexpr int kY = kSemanticChannels;
  using Attribute = Eigen::Matrix<double, kY, 1>;
  CHECK(segmentation.label.size() == keep.size());
  // The mean attribute of what is labelled rest is itself decoded as rest, because the classifier is linear.
  Attribute mean = Attribute::Zero();
  size_t rest = 0;
  for (size_t p = 0; p < keep.size(); ++p) {
    if (segmentation.label[p] != SelectionShape::kRest) continue;
    mean += Eigen::Map<const Eigen::Matrix<float, kY, 1>>(segmentation.attribute.data() + p * kY).cast<double>();
    ++rest;
  }
  if (rest == 0) return 0;
  const Eigen::Matrix<float, kY, 1> attribute = (mean / static_cast<double>(rest)).cast<float>();
  size_t removed = 0;
  for (size_t p = 0; p < keep.size(); ++p) {
    if (segmentation.label[p] != SelectionShape::kObject || keep[p]) continue;
    Eigen::Map<Eigen::Matrix<float, kY, 1>>(segmentation.attribute.data() + p * kY) = attribute;
    ++removed;
  }
  update_labels(segmentation);
  return removed;
}

}  // namespace pliant
