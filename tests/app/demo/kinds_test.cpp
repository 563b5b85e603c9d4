// All kinds of demo objects: each hangs together, is made of what it says, and repeats for its seed.

#include "app/demo/kinds/kinds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/demo/make_demo.h"
#include "app/demo/motion_cache.h"
#include "app/demo/raycast.h"
#include "app/demo/reference.h"
#include "app/demo/splats.h"
#include "app/import/interactions.h"
#include "app/simulate/simulate_stage.h"
#include "app/store/material.h"
#include "app/store/trajectory.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/scene/scene.h"
#include "physics/body/pieces.h"
#include "tests/app/demo/folder_sums.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The kinds that say where their materials come from: all but the flower.
std::vector<DemoKind> described_kinds() {
  std::vector<DemoKind> kinds = demo_kinds();
  std::erase_if(kinds, [](const DemoKind& kind) { return kind.name == kPottedFlower; });
  return kinds;
}

TEST(DemoKinds, AreAtLeastEightBesidesTheFlowerAndUnknownOnesAreRefusedWithTheList) {
  EXPECT_GE(described_kinds().size(), 8u);
  EXPECT_EQ(demo_kinds().front().name, kPottedFlower);
  for (const DemoKind& kind : demo_kinds()) {
    EXPECT_EQ(demo_kind(kind.name).shows, kind.shows);
    expect_error(Failure::kUsage, {"--kind", "roze", kind.name}, [] { demo_kind("roze"); });
  }
}

TEST(DemoKinds, TruthLiesInItsArguedBandsForSeveralSeeds) {
  for (const DemoKind& kind : described_kinds())
    for (uint64_t seed = 1; seed <= 2; ++seed) {
      const DemoObject object = kind.make(seed);
      EXPECT_EQ(object.name, kind.name);
      for (const DemoMaterial& m : object.materials) {
        if (m.fixed) continue;
        for (const auto field : {&ElasticSolid::young, &ElasticSolid::poisson, &ElasticSolid::density}) {
          EXPECT_GT(m.low.*field, 0) << kind.name << " " << m.name;
          EXPECT_LT(m.low.*field, m.high.*field) << kind.name << " " << m.name;
          EXPECT_GE(m.solid.*field, m.low.*field) << kind.name << " " << m.name;
          EXPECT_LE(m.solid.*field, m.high.*field) << kind.name << " " << m.name;
        }
        EXPECT_GT(m.reason.size(), 30u) << kind.name << " " << m.name;
      }
    }
}

TEST(DemoKinds, EachIsOnePieceThatItsPinsHoldAndEveryPartHasVolume) {
  for (const DemoKind& kind : demo_kinds()) {
    const DemoObject object = kind.make(1);
    const ObjectSolid solid = sample_object(object, 8000, 1);
    EXPECT_NEAR(solid.position.size() / 8000.0, 1, 0.1) << kind.name;
    std::vector<Vec3f> points;
    std::vector<size_t> of_material(object.materials.size());
    size_t pinned = 0, at_tip = 0;
    for (size_t i = 0; i < solid.position.size(); ++i) {
      const Vec3d& x = solid.position[i];
      points.push_back(x.cast<float>());
      ++of_material[solid.material[i]];
      pinned += std::any_of(object.pins.begin(), object.pins.end(), [&](const Region& r) { return r.contains(x); });
      at_tip += (x - object.tip).norm() < object.tip_radius;
    }
    const std::vector<float> weight(points.size(), 1.0f);
    const Pieces pieces = find_pieces(points, weight, static_cast<float>(2 * solid.cell));
    EXPECT_GE(pieces.weight[0] / points.size(), 0.999) << kind.name;
    for (size_t m = 0; m < of_material.size(); ++m)
      EXPECT_EQ(of_material[m] > 0, !object.materials[m].fixed) << kind.name << " " << object.materials[m].name;
    EXPECT_GT(pinned, 20u) << kind.name;
    EXPECT_LT(pinned, points.size() / 2) << kind.name;
    EXPECT_GT(at_tip, 10u) << kind.name;
  }
}

TEST(DemoKinds, AJoltPushesWhatMovesAndAtTheHatNothingThatStandsStill) {
  for (const DemoKind& kind : described_kinds()) {
    const Stage stage(kind.make(1), 1);
    const ReferenceBody body = reference_body(stage, sample_object(stage.object(), 8000, 1));
    const Region region = jolted_region(stage, body);
    const std::vector<Region> pins = stage.pins();
    double moving = 0, pinned = 0, all = 0;
    for (size_t i = 0; i < body.particles.size(); ++i) {
      const Vec3d x = body.particles.position[i].cast<double>();
      const double mass = body.particles.mass[i];
      all += mass;
      if (!region.contains(x)) continue;
      (std::any_of(pins.begin(), pins.end(), [&](const Region& r) { return r.contains(x); }) ? pinned : moving) += mass;
    }
    // A little of the ends of a cord, of about a twentieth of its mass.
    EXPECT_LT(pinned, 0.08 * moving) << kind.name;
    EXPECT_GT(moving, 0.1 * all) << kind.name;
    EXPECT_TRUE(region.contains(stage.tip())) << kind.name;
    if (!stage.object().jolted) continue;
    EXPECT_EQ(pinned, 0) << kind.name;
    for (const StagePart& part : stage.parts()) {
      if (part.id != kObjectId || part.moves) continue;
      for (const SurfacePoint& p : part.shape->cover(0.006, 1))
        ASSERT_FALSE(region.contains(part.world_from_local * p.position)) << kind.name;
    }
  }
}

TEST(DemoKinds, StandOnTheTableWithinTheViewAndApartFromOtherThings) {
  for (const DemoKind& kind : demo_kinds())
    for (uint64_t seed = 1; seed <= 3; ++seed) {
      const Stage stage(kind.make(seed), seed);
      EXPECT_GT(stage.object().height, 0.09) << kind.name;
      EXPECT_LT(stage.object().height, 0.37) << kind.name;
      EXPECT_LT(stage.object().reach, 0.19) << kind.name;
      for (const StagePart& part : stage.parts()) {
        if (part.id != kObjectId) continue;
        for (const SurfacePoint& p : part.shape->cover(0.012, seed)) {
          const Vec3d x = part.world_from_local * p.position;
          ASSERT_GT(x.z(), -1e-9) << kind.name << " seed " << seed;
          for (const StagePart& other : stage.parts())
            ASSERT_FALSE(other.id != kObjectId && other.id != kTableId &&
                         other.shape->inside(other.world_from_local.inverse() * x))
                << kind.name << " seed " << seed << " touches id " << other.id;
        }
      }
    }
}

TEST(DemoKinds, MasksShowTheObjectWhereItsGaussiansProject) {
  for (const DemoKind& kind : demo_kinds()) {
    const Stage stage(kind.make(1), 1);
    const std::vector<Camera> cameras = stage_cameras(stage, 4, 100, 75);
    const StageSplats splats = make_splats(stage, cameras, 3000, 1);
    EXPECT_GT(std::count(splats.label.begin(), splats.label.end(), kObjectId), 400) << kind.name;
    for (const Camera& camera : cameras) {
      const IdImage ids = take_photo(stage, camera).ids;
      size_t seen = 0, covered = 0;
      for (size_t i = 0; i < splats.label.size(); ++i) {
        const Vec3d x = splats.surface[i].cast<double>(), at = camera.cam_from_world * x;
        if (splats.label[i] != kObjectId || at.z() <= 0 || stage.blocked(x, camera.centre(), 1e-4)) continue;
        const int u = static_cast<int>(std::floor(camera.fx * at.x() / at.z() + camera.cx)),
                  v = static_cast<int>(std::floor(camera.fy * at.y() / at.z() + camera.cy));
        if (u < 1 || v < 1 || u + 1 >= camera.width || v + 1 >= camera.height) continue;
        ++seen;
        // The mask is what the middle of a pixel shows, so an edge may lie in the next one.
        bool here = false;
        for (int dv = -1; dv <= 1; ++dv)
          for (int du = -1; du <= 1; ++du) here = here || ids(u + du, v + dv) == kObjectId;
        covered += here;
      }
      EXPECT_GT(seen, 50u) << kind.name;
      EXPECT_GE(covered, 0.995 * seen) << kind.name << " " << camera.name;
    }
  }
}

TEST(DemoKinds, EachPhotoHasTextureAndSeedsChangeShapeAndMaterial) {
  for (const DemoKind& kind : described_kinds()) {
    const DemoObject one = kind.make(1), again = kind.make(1), other = kind.make(2);
    EXPECT_EQ(one.height, again.height) << kind.name;
    EXPECT_EQ(one.tip, again.tip) << kind.name;
    EXPECT_NE(one.height, other.height) << kind.name;
    const int main = one.main_material();
    EXPECT_EQ(one.materials[main].solid.young, again.materials[main].solid.young) << kind.name;
    EXPECT_NE(one.materials[main].solid.young, other.materials[main].solid.young) << kind.name;
    // Colours of the object vary in a photo.
    const Stage stage(one, 1);
    const Camera camera = stage_cameras(stage, 1, 80, 60)[0];
    const DemoPhoto photo = take_photo(stage, camera);
    std::vector<float> green;
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 80; ++x)
        if (photo.ids(x, y) == kObjectId) green.push_back(photo.color(x, y, 1));
    ASSERT_GT(green.size(), 150u) << kind.name;
    const auto [low, high] = std::minmax_element(green.begin(), green.end());
    EXPECT_GT(*high - *low, 0.2f) << kind.name;
  }
}

DemoOptions tiny(const fs::path& out, const std::string& kind, uint64_t seed) {
  DemoOptions options;
  options.kind = kind;
  options.out = out;
  options.seed = seed;
  options.width = 48;
  options.height = 36;
  options.photos = 2;
  options.gaussians = 1500;
  options.training = 0;
  options.video_particles = 1000;
  options.video_seconds = 0.25;
  return options;
}

TEST(DemoKinds, FilesRepeatForASeedAlsoOutOfTheCacheAndDifferForAnother) {
  TemporaryFolder folder;
  DemoOptions options = tiny(folder / "a", "jelly", 1);
  make_demo(options);
  options.out = folder / "b";
  options.cache = folder / "cache";
  make_demo(options);
  // The second time the motions are read.
  size_t kept = 0;
  for (const auto& entry : fs::directory_iterator(folder / "cache")) kept += entry.path().extension() == ".h5";
  EXPECT_EQ(kept, 4u);
  options.out = folder / "c";
  make_demo(options);
  make_demo(tiny(folder / "d", "jelly", 2));
  const auto a = folder_sums(folder / "a"), b = folder_sums(folder / "b"), c = folder_sums(folder / "c"),
             d = folder_sums(folder / "d");
  EXPECT_EQ(a, b);
  EXPECT_EQ(a, c);
  for (const char* file : {"splats.ply", "photos/view_000.png", "truth/object.json", "truth/poke/trajectory.h5"})
    EXPECT_NE(a.at(file), d.at(file)) << file;
}

TEST(DemoKinds, WithADamagedCacheOrOneThatCannotBeMadeMotionsAreComputedAnew) {
  TemporaryFolder folder;
  const Stage stage(demo_kind("jelly").make(1), 1);
  ReferenceOptions options;
  options.particles = 1000;
  options.seconds = 0.2;
  const ReferenceBody body = reference_body(stage, options);
  Interaction push;
  push.type = InteractionType::kPointForce;
  push.region = Region::sphere(stage.tip(), 0.03);
  push.vector = Vec3d(0.05, 0, 0);
  const auto run = [&](const char* cache = "cache") {
    return cached_reference(folder / cache, body, {push}, options, 300);
  };
  const ReferenceMotion first = run();
  for (const auto& entry : fs::directory_iterator(folder / "cache"))
    if (entry.path().extension() == ".json") write_text(entry.path(), "{\"time_step\":");
  const ReferenceMotion second = run(), third = run();
  ASSERT_EQ(first.frames.size(), second.frames.size());
  EXPECT_EQ(first.frames.back().x, second.frames.back().x);
  EXPECT_EQ(first.frames.back().x, third.frames.back().x);
  for (const auto& entry : fs::directory_iterator(folder / "cache"))
    if (entry.path().extension() == ".h5") write_text(entry.path(), "cut");
  folder.file("file", "");
  EXPECT_EQ(first.frames.back().x, run().frames.back().x);
  EXPECT_EQ(first.frames.back().x, run("file/cache").frames.back().x);
  EXPECT_EQ(first.time_step, third.time_step);
  EXPECT_EQ(first.samples.position, third.samples.position);
  EXPECT_NE(first.frames.back().x, first.frames.front().x);
}

TEST(DemoKinds, TouchingPartsRubAsInSimulate) {
  EXPECT_EQ(ReferenceOptions().contact_friction, SimulateStage().contact_friction);
}

TEST(DemoKinds, TheCacheKnowsTheSolverByAMotionInWhichPartsMeet) {
  const ReferenceMotion motion = solver_sample();
  ASSERT_EQ(motion.frames.size(), 28u);
  constexpr size_t kFoot = 240, kPlate = 112;
  constexpr double kCell = 0.01;
  std::vector<double> gaps;
  for (const SimulationState& state : motion.frames) {
    ASSERT_EQ(state.x.size(), kFoot + 3 * kPlate);
    double left = -INFINITY, right = INFINITY;
    for (size_t i = kFoot; i < kFoot + kPlate; ++i) {
      left = std::max<double>(left, state.x[i].x());
      right = std::min<double>(right, state.x[i + kPlate].x());
    }
    gaps.push_back(right - left);
  }
  // They begin beyond what can hang together, come within the reach of contact, 0.8 cells, and do not pass each other.
  EXPECT_NEAR(gaps.front(), 6.5 * kCell, 0.2 * kCell);
  EXPECT_LT(*std::min_element(gaps.begin(), gaps.end()), 1.2 * kCell);
  EXPECT_GT(*std::min_element(gaps.begin(), gaps.end()), 0);
  // A difference in one bit is another solver's.
  EXPECT_EQ(digest_of(motion), digest_of(solver_sample()));
  ReferenceMotion other = motion;
  float& last = other.frames.back().v.back().x();
  last = std::nextafter(last, 1.0f);
  EXPECT_NE(digest_of(motion), digest_of(other));
}

TEST(DemoKinds, FilesOfASceneSayWhatItIsMadeOf) {
  TemporaryFolder folder;
  const DemoOptions options = tiny(folder / "scene", "composite", 3);
  make_demo(options);
  const SceneFile scene = read_scene_file(folder / "scene/scene.json");
  EXPECT_EQ(scene.object, "composite");
  ASSERT_TRUE(scene.video.has_value());
  EXPECT_TRUE(fs::exists(scene.video->file));
  EXPECT_FALSE(scene.pinned.empty());
  const json object = json::parse(read_text(folder / "scene/truth/object.json"));
  const MaterialFile truth = read_material(folder / "scene/truth/material.h5");
  double mass = 0, parts_mass = 0;
  for (size_t i = 0; i < truth.young.size(); ++i) mass += truth.volume[i] * truth.density[i];
  for (const json& part : object["parts"])
    if (!part["fixed"]) {
      EXPECT_GT(part["volume"].get<double>(), 0);
      parts_mass += part["mass"].get<double>();
    }
  EXPECT_NEAR(parts_mass / mass, 1, 1e-4);
  for (const char* name : {"poke", "pull", "wind", "jolt"}) {
    EXPECT_TRUE(fs::exists(folder / "scene/videos" / (std::string(name) + ".mp4"))) << name;
    const fs::path motion = folder / "scene/truth" / name;
    EXPECT_EQ(read_trajectory(motion / "trajectory.h5").frames.size(), 6u) << name;
    const std::vector<Interaction> script =
        parse_interactions(read_text(motion / "interactions.json"), {}, "interactions.json");
    EXPECT_EQ(script.front().type, InteractionType::kPin) << name;
    EXPECT_GT(script.size(), 1u) << name;
    EXPECT_GT(json::parse(read_text(motion / "video_motion.json"))["peak_metres"].get<double>(), 0) << name;
  }
}

}  // namespace
}  // namespace pliant
