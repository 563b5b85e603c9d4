#include "segmentation/select/selection.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "gaussians/base/error.h"
#include "segmentation/field/known_labels.h"

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

bool SelectionShape::contains(const Vec3f& x) const {
  if (sphere) return (x - centre).norm() <= radius;
  return (x.array() >= box.low.array()).all() && (x.array() <= box.high.array()).all();
}

std::vector<uint8_t> shape_members(const SelectionShape& shape, const GaussianCloud& cloud) {
  std::vector<uint8_t> member(cloud.size());
  for (size_t p = 0; p < cloud.size(); ++p) member[p] = shape.contains(cloud.position[p]);
  if (std::count(member.begin(), member.end(), 1) > 0) return member;
  const Box bounds = cloud.bounds();
  throw usage_error(
      shape.sphere ? "--sphere" : "--aabb", "", "contains no Gaussians",
      "the scene spans " + text_of(bounds.low) + " to " + text_of(bounds.high) + ": `pliant info` prints it");
}

Segmentation segmentation_of_members(const std::string& option, std::span<const uint8_t> member,
                                     const GaussianCloud& cloud, const std::vector<Camera>& cameras, bool antialiased) {
  std::vector<uint32_t> label;
  for (const uint8_t m : member) label.push_back(m ? SelectionShape::kObject : SelectionShape::kRest);
  Segmentation out = segmentation_of_labels(
      label, {{SelectionShape::kObject, "object"}, {SelectionShape::kRest, "rest"}}, cloud, cameras, 0, antialiased);
  const int object = class_of_id(out, SelectionShape::kObject);
  // A small object shows only in pictures of full size.
  if (object >= 0 && out.class_cameras[object].empty()) find_class_cameras(cloud, cameras, out);
  if (object < 0 || out.class_cameras[object].empty())
    throw usage_error(option, "",
                      "selects " + std::to_string(std::count(label.begin(), label.end(), SelectionShape::kObject)) +
                          " Gaussians that no camera sees",
                      "choose a region that the cameras see");
  return out;
}

}  // namespace pliant
