#include "app/demo/splats.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/portable.h"

namespace pliant {
namespace {

constexpr double kInPlane = 0.56, kThickness = 0.12;  // standard deviations over the spacing
constexpr float kOpacity = 0.95f;
// The rasteriser widens every splat by a low-pass of 0.55 pixels; trained Gaussians draw back from silhouettes by
// about this much, so that the picture agrees with the photos.
constexpr double kInset = 0.8;

/// What shares one spacing: each group takes its share of the Gaussians.
struct Group {
  double share, area;  ///< area: rough guess of what is visible [m^2], only a start
  double inset;        ///< how far inside the surface its Gaussians lie [pixels of the photos]
  bool (*holds)(const StagePart&);
};
const Group kGroups[] = {
    {0.26, 0.13, kInset, [](const StagePart& part) { return part.id == kObjectId; }},
    {0.12, 0.12, kInset,
     [](const StagePart& part) { return part.id == kBallId || part.id == kBoxId || part.id == kMugId; }},
    {0.62, 1.80, 0, [](const StagePart& part) { return part.id == kTableId || part.id == kWallId; }},
};

struct Disc {
  int part;
  SurfacePoint local;
};

std::vector<Disc> visible_discs(const Stage& stage, const std::vector<Camera>& cameras, const Group& group,
                                double spacing, uint64_t seed) {
  std::vector<Disc> candidates;
  for (size_t i = 0; i < stage.parts().size(); ++i) {
    if (!group.holds(stage.parts()[i])) continue;
    for (const SurfacePoint& p : stage.parts()[i].shape->cover(spacing, seed * 1024 + i))
      candidates.push_back({static_cast<int>(i), p});
  }
  std::vector<uint8_t> keep(candidates.size());
  parallel_for(
      static_cast<std::ptrdiff_t>(candidates.size()),
      [&](std::ptrdiff_t i) {
        const Disc& disc = candidates[i];
        const Eigen::Isometry3d& pose = stage.parts()[disc.part].world_from_local;
        const Vec3d x = pose * disc.local.position, n = pose.linear() * disc.local.normal;
        keep[i] = std::any_of(cameras.begin(), cameras.end(), [&](const Camera& c) { return sees(stage, c, x, n); });
      },
      256);
  std::vector<Disc> discs;
  for (size_t i = 0; i < candidates.size(); ++i)
    if (keep[i]) discs.push_back(candidates[i]);
  return discs;
}

/// Mean colour over the disc, with the weights of its Gaussian.
Vec3d footprint_colour(const StagePart& part, const SurfacePoint& p, double sigma) {
  const Vec3d u = p.normal.unitOrthogonal(), v = p.normal.cross(u);
  Vec3d sum = Vec3d::Zero();
  double total = 0;
  for (int i = -2; i <= 2; ++i)
    for (int j = -2; j <= 2; ++j) {
      const double weight = std::exp(-0.5 * 0.49 * (i * i + j * j));
      sum += weight * part.colour(p.position + 0.7 * sigma * (i * u + j * v), p.normal);
      total += weight;
    }
  return sum / total;
}

/// Size of a photo's pixel at x, mean over cameras.
double pixel_size(const std::vector<Camera>& cameras, const Vec3d& x) {
  double sum = 0;
  for (const Camera& camera : cameras) sum += (camera.centre() - x).norm() / camera.fx;
  return sum / static_cast<double>(cameras.size());
}

void append(const Stage& stage, const std::vector<Camera>& cameras, const std::vector<Disc>& discs, double spacing,
            double inset, StageSplats& out) {
  const size_t begin = out.cloud.size();
  out.cloud.resize(begin + discs.size());
  out.surface.resize(begin + discs.size());
  out.label.resize(begin + discs.size());
  out.material.resize(begin + discs.size());
  const double sigma = kInPlane * spacing;
  parallel_for(
      static_cast<std::ptrdiff_t>(discs.size()),
      [&](std::ptrdiff_t k) {
        const StagePart& part = stage.parts()[discs[k].part];
        const SurfacePoint& p = discs[k].local;
        const size_t i = begin + static_cast<size_t>(k);
        Mat3d axes;
        axes.col(2) = part.world_from_local.linear() * p.normal;
        axes.col(0) = axes.col(2).unitOrthogonal();
        axes.col(1) = axes.col(2).cross(axes.col(0));
        const Vec3d surface = part.world_from_local * p.position;
        out.surface[i] = surface.cast<float>();
        out.cloud.position[i] = (surface - inset * pixel_size(cameras, surface) * axes.col(2)).cast<float>();
        out.cloud.rotation[i] = quaternion_wxyz(Mat3f(axes.cast<float>()));
        const float in_plane = static_cast<float>(std::log(sigma));
        out.cloud.log_scale[i] = Vec3f(in_plane, in_plane, static_cast<float>(std::log(kThickness * spacing)));
        out.cloud.opacity_logit[i] = logit(kOpacity);
        const Vec3f colour = footprint_colour(part, p, sigma).cast<float>();
        for (int c = 0; c < 3; ++c) out.cloud.sh_of(i)[c] = sh_of_color(colour[c]);
        out.label[i] = part.id;
        out.material[i] = part.material;
      },
      256);
}

}  // namespace

bool sees(const Stage& stage, const Camera& camera, const Vec3d& x, const Vec3d& normal) {
  const Vec3d eye = camera.centre(), in_camera = camera.cam_from_world * x;
  if (in_camera.z() <= 0 || normal.dot(eye - x) <= 0) return false;
  const double u = camera.fx * in_camera.x() / in_camera.z() + camera.cx,
               v = camera.fy * in_camera.y() / in_camera.z() + camera.cy;
  if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) return false;
  return !stage.blocked(x, eye, 1e-5);
}

StageSplats make_splats(const Stage& stage, const std::vector<Camera>& cameras, int count, uint64_t seed) {
  StageSplats splats;
  for (const Group& group : kGroups) {
    const double target = std::max(1.0, group.share * count);
    double spacing = std::sqrt(group.area / target);
    std::vector<Disc> discs = visible_discs(stage, cameras, group, spacing, seed);
    // The number of discs goes with the inverse square of the spacing; two corrections come within a per cent.
    for (int i = 0; i < 2; ++i) {
      spacing *= std::sqrt(std::max<size_t>(1, discs.size()) / target);
      discs = visible_discs(stage, cameras, group, spacing, seed);
    }
    append(stage, cameras, discs, spacing, group.inset, splats);
  }
  return splats;
}

}  // namespace pliant
