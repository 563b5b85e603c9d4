// The procedural scene: its shapes obey their own equations, its files agree with each other, and its proportions keep
// what they promise to a simulation.

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <atomic>
#include <nlohmann/json.hpp>
#include <set>

#include "app/demo/make_demo.h"
#include "app/demo/raycast.h"
#include "app/demo/reference.h"
#include "app/demo/splats.h"
#include "app/demo/stage.h"
#include "app/demo/train_splats.h"
#include "app/evaluate/evaluate.h"
#include "app/store/material.h"
#include "app/store/segmentation.h"
#include "app/store/trajectory.h"
#include "gaussians/base/nearest.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/scene/scene.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/reconstruct/trainer.h"
#include "tests/app/demo/folder_sums.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;

Stage flower_stage(uint64_t seed) { return Stage(make_flower(seed).object, seed); }

DemoOptions small(const fs::path& out, uint64_t seed = 1) {
  DemoOptions options;
  options.out = out;
  options.seed = seed;
  options.width = 80;
  options.height = 60;
  options.photos = 8;
  options.gaussians = 4000;
  options.video = false;
  return options;
}

struct NamedShape {
  const char* name;
  std::unique_ptr<AnalyticShape> shape;
  double area;
};
std::vector<NamedShape> shapes() {
  constexpr double kPi = 3.14159265358979323846;
  std::vector<NamedShape> all;
  all.push_back({"sphere", make_ellipsoid(Vec3d::Constant(0.05)), 4 * kPi * 0.05 * 0.05});
  // Prolate spheroid: 2 pi b^2 (1 + a / (b e) asin e), e^2 = 1 - b^2 / a^2.
  const double e = std::sqrt(1 - 0.02 * 0.02 / (0.05 * 0.05));
  all.push_back(
      {"spheroid", make_ellipsoid({0.05, 0.02, 0.02}), 2 * kPi * 4e-4 * (1 + 0.05 / (0.02 * e) * std::asin(e))});
  all.push_back({"cuboid", make_cuboid({0.05, 0.04, 0.06}), 8 * (0.05 * 0.04 + 0.05 * 0.06 + 0.04 * 0.06)});
  all.push_back({"frustum", make_lathe({{0.03, 0.0}, {0.05, 0.08}, {0.01, 0.08}}),
                 kPi * (0.08 * std::hypot(0.02, 0.08) + 0.05 * 0.05 - 0.01 * 0.01)});
  all.push_back({"handle", make_handle(0.03, 0.006), 2 * kPi * kPi * 0.03 * 0.006});
  return all;
}

TEST(DemoShapes, RayAgainstTheNormalMeetsEachCoveringPointWithItsNormal) {
  for (const NamedShape& s : shapes())
    for (const SurfacePoint& p : s.shape->cover(0.006, 3)) {
      const SurfaceHit from_inside = s.shape->intersect({p.position - 1e-3 * p.normal, p.normal}, 0, 1);
      ASSERT_NEAR(from_inside.t, 1e-3, 2e-7) << s.name << " from inside";
      const double away = 1e-3;
      const SurfaceHit hit = s.shape->intersect({p.position + away * p.normal, -p.normal}, 0, 1);
      ASSERT_NEAR(hit.t, away, 2e-7) << s.name << " at " << p.position.transpose();
      ASSERT_GT(hit.normal.dot(p.normal), 1 - 1e-6) << s.name;
      ASSERT_NEAR(p.normal.norm(), 1, 1e-12) << s.name;
    }
}

TEST(DemoShapes, CoverHasOnePointPerSquareOfTheSpacingAndKeepsDistance) {
  for (const NamedShape& s : shapes()) {
    const double spacing = 0.002;
    std::vector<Vec3f> points;
    for (const SurfacePoint& p : s.shape->cover(spacing, 1)) points.push_back(p.position.cast<float>());
    EXPECT_NEAR(points.size() * spacing * spacing / s.area, 1, 0.06) << s.name;
    const std::vector<int> nearest = k_nearest(points, points, 2);
    size_t crowded = 0;
    for (size_t i = 0; i < points.size(); ++i)
      crowded += (points[i] - points[nearest[2 * i + 1]]).norm() < 0.4f * spacing;
    EXPECT_LT(crowded, 0.02 * points.size()) << s.name;
  }
}

TEST(DemoShapes, MeshVerticesLieOnTheSurfaceAndTrianglesFaceOutwards) {
  const std::unique_ptr<AnalyticShape> shape = make_ellipsoid({0.05, 0.03, 0.02});
  const TriangleMesh mesh = shape->mesh(0.004);
  for (const Vec3d& x : mesh.vertex) EXPECT_NEAR(x.cwiseQuotient(Vec3d(0.05, 0.03, 0.02)).norm(), 1, 1e-12);
  double volume = 0;
  for (const Eigen::Vector3i& t : mesh.triangle)
    volume += mesh.vertex[t[0]].dot(mesh.vertex[t[1]].cross(mesh.vertex[t[2]])) / 6;
  EXPECT_NEAR(std::abs(volume) / (4.0 / 3 * 3.14159265 * 0.05 * 0.03 * 0.02), 1, 0.02);
}

TEST(DemoPaint, PlanksAndTilesArePeriodic) {
  const Vec3d tone(0.6, 0.5, 0.4);
  for (int i = 0; i < 500; ++i) {
    const double u = 0.0131 * i - 2, v = 0.0077 * i - 1;
    for (const auto& [m, n] : {std::pair(1, 0), std::pair(0, 1), std::pair(-2, 3)}) {
      EXPECT_LT((planks(u, v, tone) - planks(u + m * kPlankPeriodU, v + n * kPlankPeriodV, tone)).norm(), 1e-9);
      EXPECT_LT((tiles(u, v, tone) - tiles(u + m * kTilePeriod, v + n * kTilePeriod, tone)).norm(), 1e-9);
    }
  }
  EXPECT_GT((planks(0.03, 0.04, tone) - planks(0.03, 0.04 + kPlankPeriodV / 2, tone)).norm(), 0.01);
}

TEST(DemoStage, PhotoShowsThePaintedColourOfTheShapeItMeets) {
  const Stage stage = flower_stage(1);
  const Camera camera = stage_cameras(stage, 8, 80, 60)[3];
  const DemoPhoto photo = take_photo(stage, camera);
  int compared = 0;
  for (const StagePart& part : stage.parts()) {
    if (part.id != kBallId && part.material != kStem) continue;
    const Vec3d middle = part.world_from_local * part.shape->bound_centre(), at = camera.cam_from_world * middle;
    const int x = static_cast<int>(camera.fx * at.x() / at.z() + camera.cx),
              y = static_cast<int>(camera.fy * at.y() / at.z() + camera.cy);
    const Ray ray{camera.centre(), camera.ray(x + 0.5, y + 0.5)};
    const StageHit hit = stage.cast(ray);
    if (stage.parts()[hit.part].shape != part.shape) continue;
    EXPECT_EQ(photo.ids(x, y), part.id);
    // The colour varies inside a pixel by a few per cent of mottling.
    const Vec3d expected = stage.colour(ray, hit);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(photo.color(x, y, c), expected[c], 0.03);
    ++compared;
  }
  EXPECT_GE(compared, 2);
}

TEST(DemoStage, ThingsStandOnTheTableWithoutTouchingForSeveralSeeds) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const Stage stage = flower_stage(seed);
    for (const StagePart& a : stage.parts()) {
      if (a.id == kTableId || a.id == kWallId) continue;
      for (const SurfacePoint& p : a.shape->cover(0.01, seed)) {
        const Vec3d x = a.world_from_local * p.position;
        EXPECT_GT(x.z(), -1e-9) << "seed " << seed << " id " << a.id;
        for (const StagePart& b : stage.parts())
          EXPECT_FALSE(b.id != a.id && b.id != kTableId && b.shape->inside(b.world_from_local.inverse() * x))
              << "seed " << seed;
      }
    }
  }
}

TEST(DemoSplats, EveryGaussianIsTheFirstThingThatSomePhotoMeets) {
  const Stage stage = flower_stage(2);
  const std::vector<Camera> cameras = stage_cameras(stage, 8, 80, 60);
  const StageSplats splats = make_splats(stage, cameras, 4000, 2);
  EXPECT_NEAR(splats.cloud.size(), 4000, 400);
  for (size_t i = 0; i < splats.cloud.size(); ++i) {
    const Vec3d x = splats.surface[i].cast<double>();
    bool met = false;
    for (const Camera& camera : cameras) {
      const Vec3d eye = camera.centre();
      const StageHit hit = stage.cast({eye, (x - eye).normalized()});
      met = met || (hit.part >= 0 && std::abs(hit.t - (x - eye).norm()) < 1e-4);
    }
    ASSERT_TRUE(met) << "Gaussian " << i << " at " << x.transpose() << " id " << splats.label[i];
  }
}

TEST(DemoSplats, NoneUnderObjectsAndNoneInsideThePotBelowTheSoil) {
  const Stage stage = flower_stage(1);
  const StageSplats splats = make_splats(stage, stage_cameras(stage, 12, 80, 60), 20000, 1);
  const Flower flower = make_flower(1);
  size_t table_near_pot = 0, in_pot = 0, below_floor = 0, under_box = 0;
  for (size_t i = 0; i < splats.cloud.size(); ++i) {
    const Vec3d x = stage.world_from_object().inverse() * splats.surface[i].cast<double>();
    const double r = x.head<2>().norm();
    table_near_pot += splats.label[i] == kTableId && r < 0.7 * flower.pot_radius;
    in_pot += r < 0.7 * flower.pot_radius && x.z() < flower.soil_height - 0.001;
    below_floor += x.z() < -0.03;
    const Vec3d above = splats.surface[i].cast<double>() + Vec3d(0, 0, 0.01);
    for (const StagePart& part : stage.parts()) {
      const bool box_on_table = part.id == kBoxId && splats.label[i] == kTableId;
      under_box += box_on_table && part.shape->inside(part.world_from_local.inverse() * above);
    }
  }
  EXPECT_EQ(table_near_pot, 0u);
  EXPECT_EQ(in_pot, 0u);
  EXPECT_EQ(below_floor, 0u);
  EXPECT_EQ(under_box, 0u);
}

TEST(DemoFlower, ProportionsKeepTheirPromisesForSeveralSeeds) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const Flower flower = make_flower(seed);
    const FlowerMechanics m = flower_mechanics(flower);
    EXPECT_GE(m.stem_cells, 5) << "seed " << seed;
    EXPECT_GE(m.leaf_cells, 3) << "seed " << seed;
    EXPECT_GE(m.contrast, 8) << "seed " << seed;
    EXPECT_NEAR(m.frequency, 2.2, 1e-6) << "seed " << seed;
    EXPECT_LE(m.substeps_4k, 90) << "seed " << seed;
    EXPECT_NEAR(m.cell_8k, std::cbrt(8 * m.volume / 8000), 1e-9);
    EXPECT_NEAR(flower.object.height, 0.33, 0.03) << "seed " << seed;
    // Only stem, leaves and blossom are above the pinned plane.
    EXPECT_GT(flower.pin_height, flower.soil_height + 3 * m.cell_4k * 0.9);
  }
}

TEST(DemoFlower, SampledVolumeConvergesToTheSolid) {
  const Flower flower = make_flower(3);
  const double coarse = sample_flower(flower, flower.tip_diameter / 12, flower.pin_height, 0).volume();
  const double fine = sample_flower(flower, flower.tip_diameter / 30, flower.pin_height, 1).volume();
  EXPECT_NEAR(coarse / fine, 1, 0.01);
}

/// The flower of seed 1 in its stage, pushed.
ReferenceMotion flower_motion(const Stage& stage, const ReferenceOptions& options) {
  const Flower flower = make_flower(1);
  return simulate_reference(flower_body(stage, flower, options), flower_script(stage, flower, options).interactions,
                            options);
}

/// A reference motion that is quick to compute.
ReferenceOptions quick_motion(double seconds) {
  ReferenceOptions options;
  options.particles = 1500;
  options.seconds = seconds;
  return options;
}

TEST(DemoReference, FreeSwingHasAFrequencyBetweenOneAndAHalfAndTwoAndAHalfHertz) {
  const Stage stage = flower_stage(1);
  ReferenceOptions options = quick_motion(1.6);
  options.fps = 60;
  options.damping_time = 0;
  const ReferenceMotion motion = flower_motion(stage, options);
  const Vec3f blossom = (stage.world_from_object() * stage.object().tip).cast<float>();
  std::vector<double> crossings;
  double before = 0;
  for (const SimulationState& state : motion.frames) {
    double sway = 0;
    for (size_t i = 0; i < state.size(); ++i)
      if ((motion.samples.position[i] - blossom).norm() < 0.02f)
        sway += state.x[i].x() - motion.samples.position[i].x();
    if (state.time > 0.4 && sway * before < 0) crossings.push_back(state.time - sway / (sway - before) / options.fps);
    before = sway;
  }
  ASSERT_GE(crossings.size(), 3u);
  const double frequency = 0.5 * (crossings.size() - 1) / (crossings.back() - crossings.front());
  EXPECT_GT(frequency, 1.5);
  EXPECT_LT(frequency, 2.5);
}

TEST(DemoReference, FilmBeginsWithThePhotoAndMovesOnlyTheFlower) {
  const Stage stage = flower_stage(1);
  const ReferenceMotion motion = flower_motion(stage, quick_motion(0.5));
  std::vector<Camera> cameras = stage_cameras(stage, 8, 120, 90);
  const Camera& camera =
      *std::find_if(cameras.begin(), cameras.end(), [](const Camera& c) { return c.name == front_view_name(8); });
  const ReferenceFilm film = film_reference(stage, motion, camera);
  ASSERT_EQ(film.frames.size(), 12u);
  const DemoPhoto photo = take_photo(stage, camera);
  double squared = 0;
  for (size_t i = 0; i < photo.color.data.size(); ++i)
    squared += std::pow(photo.color.data[i] - film.frames[0].data[i], 2);
  EXPECT_LT(std::sqrt(squared / photo.color.data.size()), 0.01);
  // Twelve pixels at the default width of 400.
  EXPECT_GT(film.peak_pixels() * 400 / 120, 12);
  EXPECT_GT(film.peak_metres() / stage.object().height, 0.05);
  EXPECT_LT(film.peak_metres() / stage.object().height, 0.40);
  int still = 0;
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 120; ++x)
      if (photo.ids(x, y) == kBallId || photo.ids(x, y) == kMugId) {
        ++still;
        for (int c = 0; c < 3; ++c) EXPECT_EQ(film.frames[0](x, y, c), film.frames[10](x, y, c));
      }
  EXPECT_GT(still, 50) << "pixels of the ball and the mug";
}

TEST(DemoReference, MaterialOfTheSamplesDiffersEightfoldAndSceneFileIsFarOff) {
  TemporaryFolder folder;
  DemoOptions options = small(folder / "scene");
  options.video = true;
  options.video_particles = 1000;
  options.video_seconds = 0.25;
  make_demo(options);
  const MaterialFile truth = read_material(folder / "scene/truth/material.h5");
  const auto [softest, stiffest] = std::minmax_element(truth.young.begin(), truth.young.end());
  EXPECT_GE(*stiffest / *softest, 8);
  const SceneFile scene = read_scene_file(folder / "scene/scene.json");
  EXPECT_GE(*stiffest / *scene.material.young, 3);
  EXPECT_EQ(scene.support, "table");
  EXPECT_EQ(scene.object, "flower");
  ASSERT_TRUE(scene.video.has_value());
  EXPECT_TRUE(fs::exists(scene.video->file));
  const TrajectoryFile trajectory = read_trajectory(folder / "scene/truth/trajectory.h5");
  EXPECT_EQ(trajectory.frames.size(), 6u);
  EXPECT_EQ(trajectory.up, Vec3d::UnitZ());
  // Errors are relative to the vertical extent of the particles.
  const auto [lowest, highest] =
      std::minmax_element(trajectory.frames[0].position.begin(), trajectory.frames[0].position.end(),
                          [](const Vec3f& a, const Vec3f& b) { return a.z() < b.z(); });
  const nlohmann::json score = evaluate_trajectory(folder / "scene/truth", folder / "scene/truth");
  EXPECT_NEAR(score["height"].get<double>(), highest->z() - lowest->z(), 1e-6);
  const LabelFile labels = read_labels(folder / "scene/truth/labels.h5");
  EXPECT_EQ(labels.label.size(), read_ply(scene.splats).size());
  // Everything that the pins name is the pot: the lowest free solid lies above the soil.
  ASSERT_EQ(scene.pinned.size(), 1u);
  EXPECT_NEAR(scene.pinned[0].high.z(), make_flower(1).pin_height, 1e-4);
}

TEST(Demo, FilesAreEqualForOneSeedAndAnyThreadCountAndDifferForAnother) {
  TemporaryFolder folder;
  const int threads = omp_get_max_threads();
  auto make = [&](const char* name, uint64_t seed, int thread_count) {
    DemoOptions options = small(folder / name, seed);
    options.video = true;
    options.video_particles = 1000;
    options.video_seconds = 0.25;
    omp_set_num_threads(thread_count);
    make_demo(options);
  };
  make("a", 1, 1);
  make("b", 1, 4);
  make("c", 2, 2);
  omp_set_num_threads(threads);
  const auto a = folder_sums(folder / "a"), b = folder_sums(folder / "b"), c = folder_sums(folder / "c");
  EXPECT_EQ(a, b);
  ASSERT_EQ(a.size(), c.size());
  for (const char* file : {"splats.ply", "transforms.json", "scene.json", "photos/view_003.png", "masks/view_003.png",
                           "truth/trajectory.h5"})
    EXPECT_NE(a.at(file), c.at(file)) << file;
}

TEST(DemoSplats, TrainingBringsHeldOutPhotosNearerAndMovesNoGaussianFar) {
  const Stage stage = flower_stage(1);
  const std::vector<Camera> cameras = stage_cameras(stage, 12, 120, 90);
  const StageSplats laid = make_splats(stage, cameras, 6000, 1);
  TrainingPhotos photos;
  std::vector<ImageU8> pixels;
  for (size_t i = 0; i < cameras.size(); ++i) {
    pixels.push_back(to_8_bit(take_photo(stage, cameras[i]).color));
    photos.photos.emplace_back();
    photos.photos.back().camera = cameras[i];
    photos.photos.back().pixels = pixels.back();
    photos.photos.back().held_out = i % 8 == 0;
  }
  const GaussianCloud trained = train_splats(laid.cloud, cameras, pixels, 100, 1);
  ASSERT_EQ(trained.size(), laid.cloud.size());
  const auto psnr = [&](const GaussianCloud& cloud) {
    double sum = 0;
    for (const PhotoQuality& q : held_out_quality(cloud, photos, {})) sum += q.psnr / 2;
    return sum;
  };
  EXPECT_GT(psnr(trained), psnr(laid.cloud) + 4);
  // What is known of each Gaussian holds as long as it stays on its thing: millimetres where neighbours are a
  // centimetre or two apart.
  std::vector<float> moved;
  for (size_t i = 0; i < trained.size(); ++i) moved.push_back((trained.position[i] - laid.cloud.position[i]).norm());
  std::nth_element(moved.begin(), moved.begin() + moved.size() * 99 / 100, moved.end());
  EXPECT_LT(moved[moved.size() * 99 / 100], 0.005);
  // Held-out photos teach nothing.
  const GaussianCloud before = train_splats(laid.cloud, cameras, pixels, 10, 1);
  pixels[0] = pixels[8] = ImageU8(120, 90, 3);
  EXPECT_EQ(train_splats(laid.cloud, cameras, pixels, 10, 1).position, before.position);
}

TEST(Demo, FilesReadBackAsWhatTheSceneIs) {
  TemporaryFolder folder;
  const DemoSummary summary = make_demo(small(folder / "scene"));
  EXPECT_EQ(read_ply(folder / "scene/splats.ply").size(), summary.gaussians);

  const Stage stage = flower_stage(1);
  const std::vector<Camera> expected = stage_cameras(stage, 8, 80, 60);
  const std::vector<Camera> cameras = read_transforms(folder / "scene/transforms.json").cameras;
  ASSERT_EQ(cameras.size(), expected.size());
  std::set<uint32_t> ids;
  for (size_t i = 0; i < cameras.size(); ++i) {
    EXPECT_EQ(cameras[i].name, expected[i].name);
    EXPECT_LT((cameras[i].cam_from_world.matrix() - expected[i].cam_from_world.matrix()).norm(), 1e-9);
    EXPECT_DOUBLE_EQ(cameras[i].fx, expected[i].fx);
    EXPECT_EQ(cameras[i].width, 80);
    const IdImage mask = read_ids(folder / "scene/masks" / (cameras[i].name + ".png"));
    EXPECT_EQ(mask.width, 80);
    ids.insert(mask.data.begin(), mask.data.end());
    EXPECT_EQ(read_image(cameras[i].photo).height, 60);
  }
  ids.erase(0);
  EXPECT_EQ(ids, (std::set<uint32_t>{1, 2, 3, 4, 5, 6}));
}

// Ctrl-C is noticed in each of its steps: photos, training, simulation and film.
TEST(Demo, StopsWhenItIsInterrupted) {
  constexpr int kPhotos = 4, kIterations = 3, kFrames = 6;
  TemporaryFolder folder;
  DemoOptions options = small(folder / "scene");
  options.photos = kPhotos;
  options.training = kIterations;
  options.video = true;
  options.video_particles = 1000;
  options.video_seconds = 0.25;
  std::atomic<int> asked = 0;
  for (const int steps : {0, kPhotos, kPhotos + kIterations, kPhotos + kIterations + kFrames}) {
    asked = 0;
    options.interrupted = [&, steps] { return asked++ >= steps; };
    expect_error(Failure::kInterrupted, {"demo"}, [&] { make_demo(options); });
    EXPECT_GT(asked, steps);
    EXPECT_FALSE(fs::exists(folder / "scene/scene.json")) << steps;
  }
  asked = 0;
  options.interrupted = [&] { return asked++ < 0; };
  make_demo(options);
  EXPECT_EQ(asked, kPhotos + kIterations + 2 * kFrames);
}

TEST(Demo, ImpossibleSizesAreUsageErrors) {
  TemporaryFolder folder;
  DemoOptions options = small(folder / "x");
  options.width = 0;
  expect_error(Failure::kUsage, {"width", "0"}, [&] { make_demo(options); });
}

}  // namespace
}  // namespace pliant
