#pragma once

#include <map>
#include <string>
#include <vector>

#include "app/demo/flower.h"
#include "app/demo/paint.h"
#include "gaussians/base/camera.h"

namespace pliant {

/// Ids of the demo's masks.
enum StageId : uint32_t { kFlowerId = 1, kBallId = 2, kBoxId = 3, kMugId = 4, kTableId = 5, kWallId = 6 };

/// A painted shape in the world.
struct StagePart {
  std::shared_ptr<const AnalyticShape> shape;
  Eigen::Isometry3d world_from_local = Eigen::Isometry3d::Identity();
  Paint paint;
  uint32_t id = 0;
  FlowerPart flower_part = FlowerPart::kNone;

  bool moves() const { return flower_part > FlowerPart::kPot; }
  /// Painted colour of a point of the surface in [0, 1]; x and normal in the local frame.
  Vec3d colour(const Vec3d& x, const Vec3d& normal) const;
};

/// What a ray meets first; part = -1: nothing.
struct StageHit {
  int part = -1;
  double t = kNoHit;
  Vec3d normal = Vec3d::Zero();  ///< local frame of the part
};

/// A potted flower, a ball, a box and a mug on a table (top at z = 0) before a wall; z is up, metres.  Every shape is
/// analytic; the seed moves, turns, resizes and recolours them.
class Stage {
 public:
  explicit Stage(uint64_t seed);

  const std::vector<StagePart>& parts() const { return parts_; }
  /// The same stage with the parts of one id taken away.
  Stage without(uint32_t id) const;
  const Flower& flower() const { return flower_; }
  const Eigen::Isometry3d& world_from_flower() const { return world_from_flower_; }
  /// Where cameras look: on the axis of the flower, at half its height.
  Vec3d focus() const { return world_from_flower_ * Vec3d(0, 0, 0.5 * flower_.height); }
  /// Box around the pot up to the plane where the stem becomes free.
  std::pair<Vec3d, Vec3d> pinned_box() const;

  /// First surface along a ray given in the world; parts that move can be left out.
  StageHit cast(const Ray& ray, bool with_moving = true, double t_min = 1e-9) const;
  /// Whether something lies between two points; `margin` is left free at both ends.
  bool blocked(const Vec3d& from, const Vec3d& to, double margin) const;
  /// Painted colour of what the ray meets, black where it meets nothing.
  Vec3d colour(const Ray& ray, const StageHit& hit) const;

 private:
  void add(std::unique_ptr<AnalyticShape> shape, const Eigen::Isometry3d& pose, const Paint& paint, uint32_t id);
  void add_flower(uint64_t seed);
  void add_objects(uint64_t seed);

  struct Placed {
    Eigen::Isometry3d local_from_world;
    Vec3d centre;
    double radius;
  };
  std::vector<StagePart> parts_;
  std::vector<Placed> placed_;
  Flower flower_;
  Eigen::Isometry3d world_from_flower_ = Eigen::Isometry3d::Identity();
};

/// Names of the ids.
const std::map<uint32_t, std::string>& stage_names();

/// `count` views on an arc of +-75 degrees in front of the wall in three heights and distances, all towards the flower.
/// The view named `front_view_name(count)` looks straight along +y.
std::vector<Camera> stage_cameras(const Stage& stage, int count, int width, int height);
std::string front_view_name(int count);

}  // namespace pliant
