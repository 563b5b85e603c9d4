#pragma once

#include <span>
#include <vector>

#include "segmentation/discover/automatic_surface.h"

namespace pliant {

struct SupportOptions {
  float tolerance = 0.01f;     ///< half thickness of a plane while it is sought / diagonal of the scene;
  float roughest = 4;          ///< up to so many times that for the ground, which may be a lawn
  float tilt = 0.6f;           ///< rad, of the ground's normal against up
  float ground_share = 0.10f;  ///< least share of what the views show that lies on the ground,
  float below = 0.10f;         ///< most of the rest below it, or failing such a plane most below it / on it,
  float ground_area = 0.7f;    ///< least area / area of what is above it,
  float ground_open = 0.4f;    ///< and least share of its area with nothing above it but a ceiling
  float wall_share = 0.05f;    ///< the same for walls,
  float behind = 0.03f;        ///< most of the rest behind it,
  float wall_width = 0.5f;     ///< and least width / width of the ground in that direction
  int most_walls = 4;
  float clear = 2;      ///< tolerances that a thing lies before the plane behind it;
  float wide = 0.15f;   ///< least share of what the views show that such a plane holds;
  float around = 1.5f;  ///< within so many times its height above the plane
  float beyond = 0.2f;  ///< at most so much lies beyond it / on it
  int nearer = 5;       ///< halvings of the surroundings in which smaller planes are sought: tables, shelves
  uint64_t seed = 1;
};

/// A plane that things stand on or before (scene units).
struct Support {
  bool wall = false;
  Vec3f point = Vec3f::Zero(), normal = Vec3f::UnitZ();  ///< unit, towards the things
  float tolerance = 0;                                   ///< height up to which its own Gaussians reach
  double share = 0;                                      ///< of what the views show

  float height(const Vec3f& x) const { return normal.dot(x - point); }
};

/// Points drawn from `position` in proportion to `mass`, the same for the same seed; none when there is no mass.
std::vector<Vec3f> draw_points(std::span<const Vec3f> position, std::span<const float> mass, uint64_t seed);

/// Planes on which a thing stands or before which it hangs: wide planes through `samples` that pass well clear of a
/// point of the thing, with next to nothing beyond them there.  `diagonal` is that of the scene, `spacing` that between
/// its Gaussians.
std::vector<Support> planes_behind(const SupportOptions& options, const std::vector<Vec3f>& samples, const Vec3f& thing,
                                   float diagonal, float spacing);

/// Gaussians as a search for planes sees them.
struct ShownGaussians {
  std::span<const Vec3f> position;
  std::span<const float> shown;  ///< what the views show of each
  std::span<const float> apart;  ///< distance of each to its neighbours (scene units)
};

/// The same in nearer and nearer surroundings of the thing, whatever lies beyond them, without those like one of
/// `known`: tabletops and shelves, but also sides of the thing itself; the nearest first.
std::vector<Support> planes_nearby(const SupportOptions& options, const ShownGaussians& gaussians, const Vec3f& thing,
                                   float diagonal, std::vector<Support> known);

/// Share of the directions from the middle of a thing (label 1) in which the plane's other points go on beyond all of
/// it: 1 on a table, about half on a seat before its back, 0 where the plane cuts through the thing.
float share_beyond(const Support& plane, std::span<const Vec3f> position, std::span<const uint8_t> label);

/// The ground, the lowest wide plane across `up` with next to nothing below, comes first; then walls: wide upright
/// planes with everything on one side.  Empty when there is no ground.  Planes by random sample consensus over
/// Gaussians drawn in proportion to what the views show of them.
std::vector<Support> find_supports(const SupportOptions& options, const SolidScene& scene, const Vec3f& up);

}  // namespace pliant
