#include "app/demo/stage.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

using Eigen::Isometry3d;
constexpr double kHalfWidth = 0.66, kFront = -0.46, kWallAt = 0.34, kWallTop = 0.62;  // table and wall [m]

const Vec3d kBalls[] = {{0.75, 0.22, 0.20}, {0.20, 0.42, 0.72}, {0.82, 0.62, 0.18}};
const Vec3d kBoxes[] = {{0.30, 0.50, 0.56}, {0.55, 0.33, 0.50}, {0.62, 0.58, 0.36}};
const Vec3d kMugs[] = {{0.80, 0.78, 0.72}, {0.34, 0.56, 0.74}, {0.70, 0.42, 0.34}};
const Vec3d kWoods[] = {{0.66, 0.50, 0.34}, {0.58, 0.42, 0.30}, {0.72, 0.60, 0.44}};
const Vec3d kGlazes[] = {{0.60, 0.68, 0.70}, {0.70, 0.66, 0.56}, {0.62, 0.70, 0.60}};

struct Spot {
  double x, y, radius;
};

/// A free place on the table, seen from the front beside the stem and not before a leaf.
Spot free_spot(Random& random, const std::vector<Spot>& taken, const Spot& object, double radius) {
  for (int tries = 0; tries < 100000; ++tries) {
    const Spot spot{random.uniform(-0.36, 0.36), random.uniform(-0.22, kWallAt - radius - 0.03), radius};
    const double aside = std::abs(spot.x - object.x);
    const bool in_line =
        aside < 0.5 * object.radius + radius || (spot.y < object.y + 0.05 && aside < object.radius + radius);
    const bool overlaps = std::any_of(taken.begin(), taken.end(), [&](const Spot& other) {
      return std::hypot(spot.x - other.x, spot.y - other.y) < spot.radius + other.radius + 0.03;
    });
    if (!in_line && !overlaps) return spot;
  }
  CHECK_MSG(false, "no free place on the table");
  return {};
}

}  // namespace

Vec3d StagePart::colour(const Vec3d& x, const Vec3d& normal) const {
  return (albedo_at(paint, x, normal) * baked_shade(world_from_local.linear() * normal)).cwiseMin(1.0).cwiseMax(0.0);
}

Stage::Stage(DemoObject object, uint64_t seed) : object_(std::move(object)) {
  Random random(seed, 2);
  const Vec3d wood = pick_colour(random, kWoods), glaze = pick_colour(random, kGlazes);
  const double depth = kWallAt - kFront, thick = 0.025;
  add(make_cuboid({kHalfWidth, depth / 2, thick / 2}), standing(0, kFront + depth / 2, -thick / 2, 0),
      {Paint::Kind::kPlanks, wood, wood, 0.012, seed}, kTableId);
  add(make_cuboid({kHalfWidth, thick / 2, (kWallTop + thick) / 2}),
      standing(0, kWallAt + thick / 2, (kWallTop - thick) / 2, 0), {Paint::Kind::kTiles, glaze, glaze, 0.012, seed},
      kWallId);
  add_object(seed);
  add_rest(seed);
}

Stage Stage::without(uint32_t id) const {
  Stage rest = *this;
  rest.parts_.clear();
  rest.placed_.clear();
  for (size_t i = 0; i < parts_.size(); ++i)
    if (parts_[i].id != id) {
      rest.parts_.push_back(parts_[i]);
      rest.placed_.push_back(placed_[i]);
    }
  return rest;
}

void Stage::add(std::shared_ptr<const AnalyticShape> shape, const Isometry3d& pose, const Paint& paint, uint32_t id) {
  placed_.push_back({pose.inverse(), pose * shape->bound_centre(), shape->bound_radius()});
  parts_.push_back({std::move(shape), pose, paint, id});
}

void Stage::add_object(uint64_t seed) {
  Random random(seed, 3);
  world_from_object_ = place_object(random);
  for (const DemoPiece& piece : object_.pieces) {
    add(piece.shape, world_from_object_ * piece.object_from_local, piece.paint, kObjectId);
    parts_.back().material = piece.material;
    parts_.back().moves = object_.moves(piece);
  }
}

void Stage::add_rest(uint64_t seed) {
  Random random(seed, 4);
  const Vec3d at = world_from_object_.translation();
  const Spot object{at.x(), at.y(), object_.reach};
  std::vector<Spot> taken = {object};
  auto place = [&](double radius) {
    taken.push_back(free_spot(random, taken, object, radius));
    return taken.back();
  };

  const Vec3d half(random.uniform(0.045, 0.060), random.uniform(0.040, 0.055), random.uniform(0.045, 0.075));
  const Spot box = place(half.head<2>().norm());
  add(make_cuboid(half), standing(box.x, box.y, half.z(), random.uniform(0, 90) * kDegree),
      {Paint::Kind::kPlain, pick_colour(random, kBoxes), {}, 0.016, seed * 64 + 50}, kBoxId);

  const double mug_radius = random.uniform(0.036, 0.042), mug_height = random.uniform(0.085, 0.105), wall = 0.005;
  const double ring = 0.30 * mug_height;
  const Spot mug = place(mug_radius + ring + 0.008);
  const Isometry3d mug_pose = standing(mug.x, mug.y, 0, random.uniform(0, 360) * kDegree);
  const Vec3d mug_colour = pick_colour(random, kMugs);
  const Paint mug_paint{Paint::Kind::kBands, mug_colour, mug_colour * 0.72, 0.014, seed * 64 + 51};
  add(make_lathe({{mug_radius - 0.003, 0},
                  {mug_radius, 0.003},
                  {mug_radius, mug_height - 0.001},
                  {mug_radius - 0.001, mug_height},
                  {mug_radius - wall + 0.001, mug_height},
                  {mug_radius - wall, mug_height - 0.001},
                  {mug_radius - wall, 0.006},
                  {0, 0.006}}),
      mug_pose, mug_paint, kMugId);
  Paint handle_paint = mug_paint;
  handle_paint.kind = Paint::Kind::kPlain;
  add(make_handle(ring, 0.007), mug_pose * standing(mug_radius - 0.002, 0, 0.5 * mug_height, 0), handle_paint, kMugId);

  const double ball_radius = random.uniform(0.036, 0.050);
  const Spot ball = place(ball_radius);
  add(make_ellipsoid(Vec3d::Constant(ball_radius)),
      standing(ball.x, ball.y, ball_radius, random.uniform(0, 360) * kDegree),
      {Paint::Kind::kPlain, pick_colour(random, kBalls), {}, 0.016, seed * 64 + 52}, kBallId);
}

Region Stage::in_world(Region region) const {
  if (region.kind == Region::Kind::kBox) {
    region.point += world_from_object_.translation();
    region.vector += world_from_object_.translation();
  } else {
    region.point = world_from_object_ * region.point;
    region.vector = world_from_object_ * region.vector;
  }
  return region;
}

std::vector<Region> Stage::pins() const {
  std::vector<Region> pins;
  for (const Region& pin : object_.pins) pins.push_back(in_world(pin));
  return pins;
}

StageHit Stage::cast(const Ray& ray, bool with_moving, double t_min) const {
  StageHit best;
  for (size_t i = 0; i < parts_.size(); ++i) {
    if (!with_moving && parts_[i].moves) continue;
    const Placed& placed = placed_[i];
    const Vec3d to_centre = placed.centre - ray.origin;
    const double along = to_centre.dot(ray.direction);
    if (to_centre.squaredNorm() - along * along > placed.radius * placed.radius || along - placed.radius > best.t)
      continue;
    const Ray local{placed.local_from_world * ray.origin, placed.local_from_world.linear() * ray.direction};
    const SurfaceHit hit = parts_[i].shape->intersect(local, t_min, best.t);
    if (hit.t < best.t) best = {static_cast<int>(i), hit.t, hit.normal};
  }
  return best;
}

bool Stage::blocked(const Vec3d& from, const Vec3d& to, double margin) const {
  const double distance = (to - from).norm();
  return cast({from, (to - from) / distance}, true, margin).t < distance - margin;
}

Vec3d Stage::colour(const Ray& ray, const StageHit& hit) const {
  if (hit.part < 0) return Vec3d::Zero();
  return parts_[hit.part].colour(placed_[hit.part].local_from_world * (ray.origin + hit.t * ray.direction), hit.normal);
}

std::map<uint32_t, std::string> Stage::names() const {
  return {{kObjectId, object_.name}, {kBallId, "ball"},   {kBoxId, "box"},
          {kMugId, "mug"},           {kTableId, "table"}, {kWallId, "wall"}};
}

namespace {
std::string view_name(int i) {
  char name[32];
  std::snprintf(name, sizeof name, "view_%03d", i);
  return name;
}
int front_view(int count) { return std::max(0, (count - 1) / 2); }
}  // namespace

std::string front_view_name(int count) { return view_name(front_view(count)); }

std::vector<Camera> stage_cameras(const Stage& stage, int count, int width, int height) {
  constexpr double kElevation[] = {13, 29, 46}, kDistance[] = {0.88, 0.78, 0.66, 0.95};
  const Vec3d focus = stage.focus();
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    double azimuth = count > 1 ? -75.0 + 150.0 * i / (count - 1) : 0, elevation = kElevation[i % 3],
           distance = kDistance[i % 4];
    if (i == front_view(count)) {
      azimuth = 0;
      elevation = 10;
      distance = 0.80;
    }
    const double a = azimuth * kDegree, e = elevation * kDegree;
    distance *= stage.object().view;
    const Vec3d eye = focus + distance * Vec3d(std::sin(a) * std::cos(e), -std::cos(a) * std::cos(e), std::sin(e));
    Camera camera = look_at(eye, focus, Vec3d::UnitZ(), width, height, static_cast<double>(width));
    camera.name = view_name(i);
    cameras.push_back(camera);
  }
  return cameras;
}

}  // namespace pliant
