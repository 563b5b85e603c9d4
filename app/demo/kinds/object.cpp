#include "app/demo/kinds/object.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"

namespace pliant {

bool DemoPiece::contains(const Vec3d& x) const {
  const double radius = shape->bound_radius();
  return (x - object_from_local * shape->bound_centre()).squaredNorm() <= radius * radius &&
         shape->inside(object_from_local.inverse() * x);
}

int DemoObject::main_material() const {
  const auto first =
      std::find_if(materials.begin(), materials.end(), [](const DemoMaterial& material) { return !material.fixed; });
  CHECK_MSG(first != materials.end(), "nothing of the object moves");
  return static_cast<int>(first - materials.begin());
}

int DemoObject::material_at(const Vec3d& x) const {
  for (const DemoPiece& piece : pieces)
    if (moves(piece) && piece.contains(x)) return piece.material;
  return -1;
}

void DemoObject::measure() {
  height = reach = 0;
  for (const DemoPiece& piece : pieces)
    for (const SurfacePoint& p : piece.shape->cover(0.004, 0)) {
      const Vec3d x = piece.object_from_local * p.position;
      height = std::max(height, x.z());
      reach = std::max(reach, x.head<2>().norm());
    }
}

Eigen::Isometry3d standing(double x, double y, double z, double turn) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Vec3d(x, y, z);
  pose.linear() = Eigen::AngleAxisd(turn, Vec3d::UnitZ()).toRotationMatrix();
  return pose;
}

Eigen::Isometry3d place_object(Random& random) {
  return standing(random.uniform(-0.05, 0.05), random.uniform(-0.08, 0.0), 0, random.uniform(-15, 15) * kDegree);
}

Eigen::Isometry3d frame(const Vec3d& origin, const Vec3d& x, const Vec3d& y) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear().col(0) = x;
  pose.linear().col(1) = y;
  pose.linear().col(2) = x.cross(y);
  pose.translation() = origin;
  return pose;
}

ObjectSolid sample_solid(double reach, double height, double cell, double lowest, uint64_t seed,
                         const std::function<int(const Vec3d&)>& material_at) {
  const Eigen::Vector3i low(static_cast<int>(std::floor(-reach / cell)), static_cast<int>(std::floor(-reach / cell)),
                            0);
  const int across = -2 * low.x(), layers = static_cast<int>(std::ceil((height - lowest) / cell));
  std::vector<ObjectSolid> layer(std::max(0, layers));
  parallel_for(layers, [&](std::ptrdiff_t k) {
    for (int j = 0; j < across; ++j)
      for (int i = 0; i < across; ++i) {
        Random random(seed, static_cast<uint64_t>((k * across + j) * across + i));
        const Vec3d in_cell(random.uniform(), random.uniform(), random.uniform());
        const Vec3d x =
            Vec3d(0, 0, lowest) + cell * (Vec3d(low.x() + i, low.y() + j, static_cast<double>(k)) + in_cell);
        const int material = material_at(x);
        if (material < 0) continue;
        layer[k].position.push_back(x);
        layer[k].material.push_back(material);
      }
  });
  ObjectSolid samples;
  samples.cell = cell;
  for (const ObjectSolid& l : layer) {
    samples.position.insert(samples.position.end(), l.position.begin(), l.position.end());
    samples.material.insert(samples.material.end(), l.material.begin(), l.material.end());
  }
  return samples;
}

ObjectSolid sample_object(const DemoObject& object, int count, uint64_t seed) {
  // A first cell that is surely not too fine; the number of points goes with its inverse cube.
  double cell = object.height / 40;
  ObjectSolid solid;
  for (int i = 0; i < 3; ++i) {
    if (i > 0) cell = std::cbrt(solid.volume() / count);
    solid =
        sample_solid(object.reach, object.height, cell, 0, seed, [&](const Vec3d& x) { return object.material_at(x); });
    CHECK_MSG(!solid.position.empty(), "nothing of the object moves");
  }
  return solid;
}

}  // namespace pliant
