// Configurations of PhysGaussian: every documented key is read, mistakes are named, boundary conditions become what
// they say, and configurations with the values of the six released ones run on stand-in objects.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/import/physgaussian_output.h"
#include "app/import/physgaussian_world.h"
#include "app/store/hdf5_file.h"
#include "gaussians/base/error.h"
#include "gaussians/base/random.h"
#include "gaussians/io/files/files.h"
#include "tests/app/import/physgaussian_fixture.h"

namespace pliant {
namespace {

using namespace fixture;
using nlohmann::json;

// Values of the released configurations (physical keys); places of boundary conditions are those of stand-ins.
const char* kFicus = R"({"opacity_threshold": 0.02, "rotation_degree": [90.0], "rotation_axis": [0], "substep_dt": 1e-4,
  "frame_dt": 4e-2, "frame_num": 125, "E": 2e6, "nu": 0.4, "density": 200, "material": "jelly", "g": [0, 0, 0], "grid_lim": 2,
  "n_grid": 50, "grid_v_damping_scale": 0.9999, "rpic_damping": 0.0,
  "additional_material_params": [{"point": [1, 1, 1.3], "size": [1, 1, 0.25], "density": 70, "E": 2e6, "nu": 0.4}],
  "boundary_conditions": [{"type": "bounding_box"}, {"type": "cuboid", "point": [1, 1, 0.55], "size": [0.3, 0.3, 0.12],
    "velocity": [0, 0, 0], "start_time": 0, "end_time": 1e3, "reset": 1},
    {"type": "particle_impulse", "force": [-0.18, 0, 0], "num_dt": 1, "start_time": 0, "point": [1, 1, 1.3], "size": [1, 1, 0.25]}],
  "mpm_space_viewpoint_center": [1, 1, 1], "mpm_space_vertical_upward_axis": [0, 0, 1], "default_camera_index": -1,
  "show_hint": false, "init_azimuthm": 30, "init_elevation": 5, "init_radius": 2.5, "move_camera": true, "delta_a": 0.5})";
const char* kVasedeck = R"({"substep_dt": 1e-4, "frame_dt": 2e-2, "frame_num": 100, "E": 1e4, "nu": 0.4, "density": 200,
  "material": "jelly", "g": [0, 0, 0], "n_grid": 120, "sim_area": [-1, 1, -1, 1, -1, 1], "scale": 1.0,
  "boundary_conditions": [{"type": "enforce_particle_velocity_rotation", "point": [1, 1, 1.4], "normal": [0, 0, 1],
    "half_height_and_radius": [0.15, 0.5], "rotation_scale": 3, "translation_scale": 0, "start_time": 0, "end_time": 1},
    {"type": "cuboid", "point": [1, 1, 0.55], "size": [0.6, 0.6, 0.1], "velocity": [0, 0, 0]}]})";
const char* kPillow = R"({"substep_dt": 1e-4, "frame_dt": 2e-2, "frame_num": 100, "E": 1e4, "nu": 0.3, "density": 200,
  "material": "jelly", "g": [0, 0, -5], "n_grid": 100, "scale": 0.8, "particle_filling": {"n_grid": 128, "density_threshold": 5,
    "search_threshold": 3, "max_partciels_per_cell": 2, "search_exclude_direction": 5, "ray_cast_direction": 4, "boundary": null,
    "smooth": false, "visualize": false},
  "boundary_conditions": [{"type": "surface_collider", "point": [0, 0, 0.5], "normal": [0, 0, 1], "surface": "slip", "friction": 0.2}]})";
const char* kPlane = R"({"substep_dt": 1e-4, "frame_dt": 4e-2, "frame_num": 100, "E": 1e5, "nu": 0.3, "density": 200,
  "material": "metal", "yield_stress": 1e2, "hardening": 1, "xi": 0.1, "g": [0, 0, -9.8], "n_grid": 120,
  "boundary_conditions": [{"type": "surface_collider", "point": [0, 0, 0.6], "normal": [0, 0, 1], "surface": "sticky"},
    {"type": "bounding_box"}]})";
const char* kBread = R"({"substep_dt": 1e-4, "frame_dt": 4e-2, "frame_num": 100, "E": 2e3, "nu": 0.3, "density": 200,
  "material": "jelly", "g": [0, 0, 0], "n_grid": 150, "scale": 0.6, "rpic_damping": 0.5,
  "boundary_conditions": [{"type": "enforce_particle_translation", "point": [0.75, 1, 1], "size": [0.08, 1, 1], "velocity": [-0.2, 0, 0], "start_time": 0, "end_time": 2},
    {"type": "enforce_particle_translation", "point": [1.25, 1, 1], "size": [0.08, 1, 1], "velocity": [0.2, 0, 0], "start_time": 0, "end_time": 2}]})";
const char* kWolf =
    R"({"substep_dt": 2e-5, "frame_dt": 2e-2, "frame_num": 100, "E": 5e7, "nu": 0.3, "density": 200, "material": "sand",
  "friction_angle": 30, "g": [0, 0, -9.8], "n_grid": 200,
  "boundary_conditions": [{"type": "surface_collider", "point": [0, 0, 0.55], "normal": [0, 0, 1], "surface": "other", "friction": 0.4},
    {"type": "release_particles_sequentially", "normal": [0, 0, 1], "start_position": 0.5, "end_position": 1.5, "num_layers": 10, "start_time": 0, "end_time": 0.1}]})";

TEST(PhysGaussianConfig, DefaultsAreThoseOfTheReleasedCode) {
  const PhysGaussianConfig c = parse("{}");
  EXPECT_EQ(c.material, "jelly");
  EXPECT_EQ(c.n_grid, 50);
  EXPECT_EQ(c.grid_lim, 2);
  EXPECT_EQ(c.young, 1e5);
  EXPECT_EQ(c.poisson, 0.4);
  EXPECT_EQ(c.density, 200);
  EXPECT_EQ(c.friction_angle, 25);
  EXPECT_EQ(c.grid_v_damping_scale, 1.1);
  EXPECT_EQ(c.opacity_threshold, 0.02);
  EXPECT_FALSE(c.filling);
  ASSERT_EQ(c.notes.size(), 1u);
  EXPECT_NE(c.notes[0].find("g is missing"), std::string::npos);
}

TEST(PhysGaussianConfig, EveryDocumentedKeyIsRead) {
  const PhysGaussianConfig c = parse(kFicus);
  EXPECT_EQ(c.young, 2e6);
  EXPECT_EQ(c.frame_num, 125);
  EXPECT_EQ(c.rotation_degree, std::vector<double>{90});
  ASSERT_EQ(c.additional_material.size(), 1u);
  EXPECT_EQ(c.additional_material[0].density, 70);
  ASSERT_EQ(c.boundaries.size(), 3u);
  EXPECT_EQ(c.boundaries[1].half, Vec3d(0.3, 0.3, 0.12));
  EXPECT_TRUE(c.boundaries[1].reset);
  EXPECT_EQ(c.boundaries[2].force.x(), -0.18);
  EXPECT_EQ(c.view.azimuth, 30);
  EXPECT_TRUE(c.view.move_camera);
  const PhysGaussianConfig pillow = parse(kPillow);
  ASSERT_TRUE(pillow.filling);
  EXPECT_EQ(pillow.filling->n_grid, 128);
  EXPECT_EQ(pillow.filling->max_particles_per_cell, 2);
  // The spelling of the README, which the released code ignores, counts and is reported.
  const PhysGaussianConfig spelt = parse(R"({"g": [0,0,0], "particle_filling": {"max_particles_per_cell": 4}})");
  EXPECT_EQ(spelt.filling->max_particles_per_cell, 4);
  EXPECT_EQ(spelt.filling->n_grid, 200);
  EXPECT_EQ(spelt.notes.size(), 1u);
  const PhysGaussianConfig wolf = parse(kWolf);
  EXPECT_EQ(wolf.boundaries[0].surface, "separate");
  EXPECT_EQ(wolf.boundaries[1].num_layers, 10);
}

TEST(PhysGaussianConfig, MistakesNameFileKeyAndRemedy) {
  expect_refused("[]", {"config.json"});
  expect_refused("{", {"config.json"});
  expect_refused(R"({"densty": 3})", {"densty", "density"});
  expect_refused(R"({"nu": 0.5})", {"nu", "0.5"});
  expect_refused(R"({"material": "jely"})", {"jelly"});
  expect_refused(R"({"material": "metal"})", {"yield_stress"});
  expect_refused(R"({"E": -1})", {"E"});
  expect_refused(R"({"n_grid": 50.5})", {"n_grid", "integer"});
  expect_refused(R"({"rotation_degree": [90]})", {"rotation_axis"});
  expect_refused(R"({"rotation_degree": [90], "rotation_axis": [3]})", {"rotation_axis"});
  expect_refused(R"({"sim_area": [1, 0, 0, 1, 0, 1]})", {"sim_area"});
  expect_refused(R"({"boundary_conditions": [{"type": "cubiod"}]})", {"boundary_conditions[0]", "cuboid"});
  expect_refused(R"({"boundary_conditions": [{"type": "cuboid", "point": [1,1,1]}]})",
                 {"boundary_conditions[0]", "size"});
  expect_refused(R"({"boundary_conditions": [{"type": "bounding_box", "velocity": [0,0,0]}]})", {"velocity"});
  expect_refused(R"({"additional_material_params": [{"point": [1,1,1]}]})", {"additional_material_params[0]", "size"});
}

TEST(PhysGaussianSpace, TurnsThenScalesThenCentres) {
  PhysGaussianConfig config = parse(
      R"({"g": [0,0,0], "rotation_degree": [90, 90], "rotation_axis": [0, 2], "scale": 0.6, "opacity_threshold": 0.5,
                                        "sim_area": [-9, 9, -9, 9, -1, 9]})");
  GaussianCloud cloud;
  cloud.resize(5);
  cloud.position = {{0, 0, 0}, {0, 4, 0}, {1, 0, 2}, {0, -2, 0}, {0, 1, 0}};
  cloud.opacity_logit = {2, 2, 2, 2, -2};
  const std::vector<uint8_t> members = physgaussian_members(config, cloud);
  // A quarter turn about x takes y to z: the fourth falls out of the area, the last is too faint.
  EXPECT_EQ(members, (std::vector<uint8_t>{1, 1, 1, 0, 0}));
  const SimulationSpace space = simulation_space(config, cloud, members);
  EXPECT_NEAR(space.scale, 0.6 / 4, 1e-12);
  Vec3d low = Vec3d::Constant(9), high = -low;
  for (int i = 0; i < 3; ++i) {
    const Vec3d x = space.from_scene(cloud.position[i].cast<double>());
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
    EXPECT_LT((space.to_scene(x) - cloud.position[i].cast<double>()).norm(), 1e-12);
  }
  EXPECT_LT((0.5 * (low + high) - Vec3d::Ones()).norm(), 1e-12);
  EXPECT_NEAR((high - low).z(), 0.6, 1e-12);
  EXPECT_THROW(simulation_space(config, cloud, {0, 0, 0, 0, 0}), Error);
}

TEST(PhysGaussianMaterial, BoxesOverrideAndLawsTakeOurConstants) {
  PhysGaussianConfig config =
      parse(R"({"material": "metal", "yield_stress": 100, "hardening": 1, "xi": 2, "E": 1e4, "nu": 0.25, "g": [0,0,0],
    "additional_material_params": [{"point": [1, 1, 1.5], "size": [1, 1, 0.5], "E": 2e4, "density": 50}]})");
  std::vector<Vec3d> gaussians;
  Particles p = stand_in(config, gaussians);
  set_physgaussian_material(config, Compatibility::kCorrected, p);
  ASSERT_EQ(p.materials.size(), 2u);
  for (size_t i = 0; i < p.size(); ++i) {
    const bool box = p.position[i].z() > 1.0f;
    EXPECT_EQ(p.young[i], box ? 2e4f : 1e4f);
    EXPECT_NEAR(p.mass[i] / p.volume[i], box ? 50 : 200, 1e-3);
    const Material& m = p.material(i);
    EXPECT_EQ(m.law, Law::kMetal);
    EXPECT_NEAR(m.yield_stress, std::sqrt(1.5) * 100, 1e-9);
    EXPECT_NEAR(m.hardening, 3 * 2 * (box ? 2e4 : 1e4) / 2.5, 1e-6);
  }
}

TEST(PhysGaussianWorld, AnImpulseKeepsTheChangeOfVelocityOfTheReleasedCode) {
  const PhysGaussianConfig config = parse(R"({"g": [0,0,0], "density": 200, "n_grid": 20, "substep_dt": 1e-3,
    "boundary_conditions": [{"type": "particle_impulse", "force": [0.5, 0, 0], "num_dt": 4, "start_time": 0, "point": [1,1,1], "size": [1,1,1]}]})");
  std::vector<Vec3d> gaussians;
  Particles p = stand_in(config, gaussians);
  // The released code: each Gaussian is a particle with an equal part of its cell's volume; v += force / mass * dt.
  std::map<std::array<int, 3>, int> count;
  const auto cell = [&](const Vec3d& x) {
    return std::array<int, 3>{int(x[0] / 0.1), int(x[1] / 0.1), int(x[2] / 0.1)};
  };
  for (const Vec3d& x : gaussians) ++count[cell(x)];
  double momentum = 0, mass = 0;
  for (const Vec3d& x : gaussians) {
    momentum += 0.5 * 1e-3 * 4;
    mass += 200 * 1e-3 / count[cell(x)];
  }
  const PhysGaussianWorld world = physgaussian_world(config, Compatibility::kCorrected, p, gaussians);
  ASSERT_EQ(world.interactions.size(), 1u);
  const Interaction& it = world.interactions[0];
  EXPECT_NEAR(it.vector.x() * it.duration / p.total_mass(), momentum / mass, 1e-5 * momentum / mass);
  EXPECT_NEAR(it.duration, 4e-3, 1e-12);
}

TEST(PhysGaussianWorld, CompatibilityRepeatsWhatTheDefaultPutsRight) {
  const PhysGaussianConfig config = parse(kPillow);
  std::vector<Vec3d> gaussians;
  Particles p = stand_in(config, gaussians);
  const PhysGaussianWorld right = physgaussian_world(config, Compatibility::kCorrected, p, gaussians);
  const PhysGaussianWorld compat = physgaussian_world(config, Compatibility::kPhysGaussian, p, gaussians);
  EXPECT_EQ(right.interactions[0].contact, ContactKind::kSlip);
  EXPECT_EQ(compat.interactions[0].contact, ContactKind::kSticky);
  EXPECT_EQ(right.options.substeps, 0);
  EXPECT_EQ(compat.options.substeps, 200);
  EXPECT_GE(right.notes.size(), 2u);
  const PhysGaussianConfig wolf = parse(kWolf);
  const auto layers = [&](Compatibility c) {
    return physgaussian_world(wolf, c, p, gaussians).interactions.size() - 1;
  };
  EXPECT_EQ(layers(Compatibility::kCorrected), 10u);
  EXPECT_EQ(layers(Compatibility::kPhysGaussian), 50u);
}

TEST(PhysGaussianWorld, RotationTurnsAsThatOfTheReleasedCode) {
  Random random(7);
  const auto vector = [&] { return Vec3d(random.normal(), random.normal(), random.normal()); };
  for (int i = 0; i < 20; ++i) {
    PhysGaussianConfig config = parse(kVasedeck);
    PhysGaussianConfig::Boundary& turn = config.boundaries[0];
    const Vec3d n = turn.normal = vector().normalized();
    turn.translation = random.normal();
    std::vector<Vec3d> gaussians;
    const Particles p = stand_in(config, gaussians);
    const Interaction it = physgaussian_world(config, Compatibility::kCorrected, p, gaussians).interactions[0];
    Collider collider;
    collider.velocity = it.vector;
    collider.angular_velocity = it.angular_velocity;
    collider.pivot = it.pivot;
    // With axes h1 and h2 = h1 x n and the angle between h1 and the part d of the offset across n, the released code
    // sets w d (-sin h1 + cos h2) + translation n.
    const Vec3d offset = vector(), across = offset - offset.dot(n) * n;
    const Vec3d h1 = (Vec3d::Ones() - n.sum() * n).normalized(), h2 = h1.cross(n);
    const double angle = std::atan2(offset.dot(h2), offset.dot(h1));
    const Vec3d expected =
        turn.rotation * across.norm() * (-std::sin(angle) * h1 + std::cos(angle) * h2) + turn.translation * n;
    EXPECT_LT((collider.velocity_at(turn.point + offset) - expected).norm(), 1e-9) << n.transpose();
  }
}

TEST(PhysGaussianWorld, LayersAreReleasedWhenTheReleasedCodeDoes) {
  for (const int layers : {1, 5}) {
    PhysGaussianConfig config = parse(kWolf);
    PhysGaussianConfig::Boundary& release = config.boundaries[1];
    release.num_layers = layers;
    release.start = 0.03;
    release.end = 0.1;
    std::vector<Vec3d> gaussians;
    const Particles p = stand_in(config, gaussians);
    const PhysGaussianWorld world = physgaussian_world(config, Compatibility::kCorrected, p, gaussians);
    // Layer i, |z - end_position| < |start_position - end_position| (n - i) / n, stands still from start_time until
    // end_time (i + 1) / n.
    size_t next = 0;  // before the surface, which acts on nodes
    for (int i = 0; i < layers; ++i) {
      const double end = 0.1 * (i + 1) / layers, half = 1.0 * (layers - i) / layers;
      if (end <= release.start) continue;
      ASSERT_LT(next, world.interactions.size());
      const Interaction& it = world.interactions[next++];
      EXPECT_EQ(it.contact, ContactKind::kSticky);
      EXPECT_EQ(it.vector, Vec3d(Vec3d::Zero()));
      EXPECT_NEAR(it.start, release.start, 1e-12);
      EXPECT_NEAR(it.start + it.duration, end, 1e-12);
      for (const double side : {-1, 1}) {
        EXPECT_TRUE(it.region.contains({0, 2, 1.5 + side * (half - 1e-9)})) << layers << " " << i;
        EXPECT_FALSE(it.region.contains({0, 2, 1.5 + side * (half + 1e-9)})) << layers << " " << i;
      }
    }
    EXPECT_EQ(next + 1, world.interactions.size());
  }
}

TEST(PhysGaussianWorld, KeysThatDecideNothingHereAreSaid) {
  const auto notes_of = [&](const char* text) {
    const PhysGaussianConfig config = parse(text);
    std::vector<Vec3d> gaussians;
    const Particles p = stand_in(config, gaussians);
    std::string all;
    for (const std::string& note : physgaussian_world(config, Compatibility::kCorrected, p, gaussians).notes)
      all += note + "\n";
    return all;
  };
  const std::string of_pillow = notes_of(kPillow);
  EXPECT_NE(of_pillow.find("particle_filling is not used"), std::string::npos);
  const std::string of_view = notes_of(R"({"g": [0,0,0], "init_azimuthm": 30, "move_camera": true})");
  EXPECT_NE(of_view.find("move_camera, init_azimuthm: not used"), std::string::npos) << of_view;
  const std::string of_none = notes_of(R"({"g": [0,0,0]})");
  EXPECT_EQ(of_none.find("not used"), std::string::npos) << of_none;
}

const std::map<std::string, const char*> kReleased = {{"ficus", kFicus},        {"vasedeck", kVasedeck},
                                                      {"pillow2sofa", kPillow}, {"plane", kPlane},
                                                      {"tear_bread", kBread},   {"wolf", kWolf}};

class ReleasedConfiguration : public testing::TestWithParam<std::string> {};

TEST_P(ReleasedConfiguration, RunsOnAStandIn) {
  const std::string name = GetParam();
  const PhysGaussianConfig config = parse(kReleased.at(name));
  std::vector<Vec3d> gaussians;
  Particles p = stand_in(config, gaussians, name == "plane" || name == "tear_bread" ? 1.0 : 0.5);
  set_physgaussian_material(config, Compatibility::kCorrected, p);
  PhysGaussianWorld world = physgaussian_world(config, Compatibility::kCorrected, p, gaussians);
  world.options.duration = 4 / world.options.fps;
  const SimulateResult result = simulate<float>(world.options, p, world.interactions, initial_state(p));
  EXPECT_EQ(result.state.frame, 4);
  EXPECT_GT(result.summary.max_displacement, 1e-5) << name << " does not move";
  EXPECT_LT(result.summary.max_displacement, 1) << name << " flies away";
  for (const Vec3f& x : result.state.x) ASSERT_TRUE(x.allFinite());
}

INSTANTIATE_TEST_SUITE_P(All, ReleasedConfiguration,
                         testing::Values("ficus", "vasedeck", "pillow2sofa", "plane", "tear_bread", "wolf"),
                         [](const auto& info) { return info.param; });

TEST(PhysGaussianOutput, HasTheShapesOfTheReleasedCodeInSimulationSpace) {
  const TemporaryFolder folder;
  SimulationSpace space;
  space.R = Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized()).toRotationMatrix();
  space.scale = 0.5;
  space.offset = Vec3d(1, 0.5, 2);
  // A body that is stretched at a steady rate: dF/dt F^-1 is known.
  TrajectoryFile t;
  Mat3d L = Mat3d::Zero();
  L(0, 1) = 0.3;
  L(2, 2) = -0.2;
  for (int f = 0; f < 3; ++f) {
    TrajectoryFile::Frame frame;
    frame.time = 1e-3 * f;
    const Mat3d F = Mat3d::Identity() + frame.time * L;
    frame.position = {Vec3f(1, 2, 3), Vec3f(-1, 0, 1)};
    frame.velocity = {Vec3f(0, 1, 0), Vec3f(1, 0, 0)};
    frame.F = {F.cast<float>(), F.cast<float>()};
    t.frames.push_back(frame);
  }
  write_physgaussian_output(folder / "out", {}, t, space);
  const Hdf5Reader in(folder / "out/simulation_ply/sim_0000000001.h5");
  const std::vector<float> x = in.dataset<float>("x", {3, 2}), C = in.dataset<float>("C", {9, 2});
  EXPECT_EQ(in.dataset<float>("time", {1, 1})[0], 1e-3f);
  EXPECT_EQ(in.shape("f_tensor"), (Shape{9, 2}));
  EXPECT_EQ(in.shape("v"), (Shape{3, 2}));
  const Vec3d expected = space.from_scene(Vec3d(-1, 0, 1));
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(x[2 * a + 1], expected[a], 1e-6);
  const Mat3d gradient = space.R * L * space.R.transpose();
  for (int k = 0; k < 9; ++k) EXPECT_NEAR(C[2 * k], gradient(k / 3, k % 3), 1e-3);
  const std::string ply = read_text(folder / "out/simulation_ply/sim_0000000002.ply");
  EXPECT_NE(ply.find("element vertex 2"), std::string::npos);
  EXPECT_EQ(ply.size(), ply.find("end_header\n") + 11 + 2 * 12);
}

TEST(PhysGaussianOutput, FramesBehindTheLastAreRemovedAndNothingElse) {
  const TemporaryFolder folder;
  const std::vector<std::string> kept = {"sim_0000000002.h5", "sim_0000000002.ply", "sim_0000000003.npz",
                                         "sim_3.ply",         "sim_00000000003.h5", "sim_0000000009.ply.txt",
                                         "mine.ply"},
                                 gone = {"sim_0000000003.h5", "sim_0000000003.ply", "sim_0000009999.h5"};
  for (const auto& names : {kept, gone})
    for (const std::string& name : names) folder.file("simulation_ply/" + name, "");
  remove_physgaussian_frames(folder.path(), 3);
  for (const std::string& name : kept)
    EXPECT_TRUE(std::filesystem::exists(folder / ("simulation_ply/" + name))) << name;
  for (const std::string& name : gone)
    EXPECT_FALSE(std::filesystem::exists(folder / ("simulation_ply/" + name))) << name;
  remove_physgaussian_frames(folder / "none", 0);
}

}  // namespace
}  // namespace pliant
