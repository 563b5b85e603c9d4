#pragma once

#include <map>
#include <string>
#include <vector>

#include "app/demo/kinds/object.h"
#include "app/demo/kinds/paint.h"
#include "gaussians/base/camera.h"

namespace pliant {

/// Ids of the demo's masks.
enum StageId : uint32_t { kObjectId = 1, kBallId = 2, kBoxId = 3, kMugId = 4, kTableId = 5, kWallId = 6 };

/// A painted shape in the world.
struct StagePart {
  std::shared_ptr<const AnalyticShape> shape;
  Eigen::Isometry3d world_from_local = Eigen::Isometry3d::Identity();
  Paint paint;
  uint32_t id = 0;
  int material = -1;  ///< of the object, -1 elsewhere
  bool moves = false;

  /// Painted colour of a point of the surface in [0, 1]; x and normal in the local frame.
  Vec3d colour(const Vec3d& x, const Vec3d& normal) const;
};

/// What a ray meets first; part = -1: nothing.
struct StageHit {
  int part = -1;
  double t = kNoHit;
  Vec3d normal = Vec3d::Zero();  ///< local frame of the part
};

/// An object, a ball, a box and a mug on a table (top at z = 0) before a wall; z is up, metres.  The seed moves, turns,
/// resizes and recolours them.
class Stage {
 public:
  Stage(DemoObject object, uint64_t seed);

  const std::vector<StagePart>& parts() const { return parts_; }
  /// The same stage with the parts of one id taken away.
  Stage without(uint32_t id) const;
  const DemoObject& object() const { return object_; }
  const Eigen::Isometry3d& world_from_object() const { return world_from_object_; }
  /// Where cameras look: on the axis of the object, at half its height.
  Vec3d focus() const { return world_from_object_ * Vec3d(0, 0, 0.5 * object_.height); }
  Vec3d tip() const { return world_from_object_ * object_.tip; }
  /// A region of the object's frame in the world; boxes are moved but not turned.
  Region in_world(Region region) const;
  /// Where the object is held, in the world.
  std::vector<Region> pins() const;
  /// Names of the ids.
  std::map<uint32_t, std::string> names() const;

  /// First surface along a ray given in the world; parts that move can be left out.
  StageHit cast(const Ray& ray, bool with_moving = true, double t_min = 1e-9) const;
  /// Whether something lies between two points; `margin` is left free at both ends.
  bool blocked(const Vec3d& from, const Vec3d& to, double margin) const;
  /// Painted colour of what the ray meets, black where it meets nothing.
  Vec3d colour(const Ray& ray, const StageHit& hit) const;

 private:
  void add(std::shared_ptr<const AnalyticShape> shape, const Eigen::Isometry3d& pose, const Paint& paint, uint32_t id);
  void add_object(uint64_t seed);
  void add_rest(uint64_t seed);

  struct Placed {
    Eigen::Isometry3d local_from_world;
    Vec3d centre;
    double radius;
  };
  std::vector<StagePart> parts_;
  std::vector<Placed> placed_;
  DemoObject object_;
  Eigen::Isometry3d world_from_object_ = Eigen::Isometry3d::Identity();
};

/// `count` views on an arc of +-75 degrees in front of the wall in three heights and distances, all towards the object.
/// The view named `front_view_name(count)` looks straight along +y.
std::vector<Camera> stage_cameras(const Stage& stage, int count, int width, int height);
std::string front_view_name(int count);

}  // namespace pliant
