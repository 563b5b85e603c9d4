// Everything that is stored in HDF5: there and back, equal bytes for equal contents, hostile files.

#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/resource.h>

#include <bit>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <map>
#include <thread>

#include "app/store/hdf5_file.h"
#include "app/store/material.h"
#include "app/store/particles.h"
#include "app/store/segmentation.h"
#include "app/store/solid.h"
#include "app/store/training.h"
#include "app/store/trajectory.h"
#include "gaussians/io/files/files.h"
#include "tests/app/store/random_values.h"
#include "tests/temporary_folder.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

Segmentation some_segmentation() {
  Segmentation s;
  s.attribute = floats(50 * kSemanticChannels);
  s.classifier = floats(3 * kSemanticChannels);
  s.classifier_bias = floats(3);
  s.class_id = {1, 4, 70000};
  s.class_name = {"flower", "größe \"x\"", "table"};
  for (int i = 0; i < 50; ++i) {
    s.label.push_back(s.class_id[i % 3]);
    s.seen.push_back(i % 2);
  }
  s.confidence = floats(50, 0, 1);
  s.class_cameras = {{0, 2, 7}, {}, {1}};
  s.class_origin = {"masks", "split from 1", "größe"};
  s.next_id = 80000;
  s.screen_variance = 0.15;
  return s;
}

ParticleFile some_particles() {
  ParticleFile p;
  p.solid_position = vectors(40);
  p.solid_volume = floats(40, 0, 1);
  p.driving_position = vectors(5);
  p.driving_volume = floats(5, 0, 1);
  for (int i = 0; i < 40; ++i) p.solid_driver.push_back(i % 6 - 1);
  for (int i = 0; i < 40; ++i) p.solid_follows.push_back(i % 12 == 0 ? i + 1 : -1);
  p.cell_size = 0.03;
  p.metres_per_unit = 0.25;
  p.pinned_json = R"([{"sphere": [0, 0, 0, 1]}])";
  return p;
}

TrajectoryFile some_trajectory() {
  TrajectoryFile t;
  t.object = "1_flower";
  t.fps = 24;
  t.metres_per_unit = 0.5;
  t.cell_size = 0.02;
  t.up = {0, 0.6, -0.8};
  for (int i = 0; i < 4; ++i) t.frames.push_back({i / 24.0, 10 * i, vectors(6), vectors(6), matrices(6)});
  return t;
}

TEST(Store, SegmentationSurvives) {
  const TemporaryFolder folder;
  const Segmentation s = some_segmentation();
  write_segmentation(folder / "s.h5", s, "{}");
  const Segmentation back = read_segmentation(folder / "s.h5");
  EXPECT_EQ(back.attribute, s.attribute);
  EXPECT_EQ(back.classifier, s.classifier);
  EXPECT_EQ(back.classifier_bias, s.classifier_bias);
  EXPECT_EQ(back.class_id, s.class_id);
  EXPECT_EQ(back.class_name, s.class_name);
  EXPECT_EQ(back.label, s.label);
  EXPECT_EQ(back.confidence, s.confidence);
  EXPECT_EQ(back.seen, s.seen);
  EXPECT_EQ(back.class_cameras, s.class_cameras);
  EXPECT_EQ(back.class_origin, s.class_origin);
  EXPECT_EQ(back.next_id, s.next_id);
  EXPECT_EQ(back.screen_variance, s.screen_variance);
  const LabelFile labels = read_labels(folder / "s.h5");
  EXPECT_EQ(labels.label, s.label);
  EXPECT_EQ(labels.names.at(70000), "table");
  write_labels(folder / "labels.h5", labels, "{}");
  EXPECT_EQ(read_labels(folder / "labels.h5").names, labels.names);
}

SolidFile some_solid() {
  SolidFile solid;
  solid.samples.position = vectors(40);
  solid.samples.volume = floats(40, 0, 1);
  solid.samples.thickness = floats(40, 0, 0.1);
  solid.samples.spacing = 0.02f;
  for (int i = 0; i < 40; ++i) solid.samples.rod.push_back(i % 2);
  for (int i = 0; i < 40; ++i) solid.simulated.push_back(i % 3 > 0);
  solid.volume = 17.25;
  solid.pinned_json = R"([{"sphere": [0, 0, 0, 0.5]}])";
  return solid;
}

TEST(Store, SolidSamplesSurviveAndBadOnesNameTheDataset) {
  const TemporaryFolder folder;
  const SolidFile solid = some_solid();
  write_solid(folder / "solid.h5", solid, "{}");
  const SolidFile back = read_solid(folder / "solid.h5");
  EXPECT_EQ(back.samples.position, solid.samples.position);
  EXPECT_EQ(back.samples.volume, solid.samples.volume);
  EXPECT_EQ(back.samples.thickness, solid.samples.thickness);
  EXPECT_EQ(back.samples.spacing, solid.samples.spacing);
  EXPECT_EQ(back.samples.rod, solid.samples.rod);
  EXPECT_EQ(back.simulated, solid.simulated);
  EXPECT_EQ(back.volume, solid.volume);
  EXPECT_EQ(back.pinned_json, solid.pinned_json);
  const auto refused = [&](const std::function<void(SolidFile&)>& spoil, const std::vector<std::string>& words) {
    SolidFile bad = some_solid();
    spoil(bad);
    write_solid(folder / "bad.h5", bad, "{}");
    expect_error(Failure::kInput, words, [&] { read_solid(folder / "bad.h5"); });
  };
  refused([](SolidFile& s) { s.simulated[4] = 2; }, {"bad.h5", "/solid/simulated", "0 and 1"});
  refused([](SolidFile& s) { s.samples.thickness[7] = NAN; }, {"bad.h5", "/solid/thickness", "row 7"});
  refused([](SolidFile& s) { s.samples.spacing = 0; }, {"bad.h5", "spacing", "positive"});
  refused([](SolidFile& s) { s.pinned_json = "[{"; }, {"bad.h5", "pinned", "JSON"});
  const std::string good = read_text(folder / "solid.h5");
  for (size_t part = 1; part < 8; ++part)
    expect_error(Failure::kInput, {"cut.h5"},
                 [&] { read_solid(folder.file("cut.h5", good.substr(0, good.size() * part / 8))); });
}

TEST(Store, ParticlesAndMaterialSurviveAndMaterialFindsItsSamples) {
  const TemporaryFolder folder;
  const ParticleFile p = some_particles();
  write_particles(folder / "particles.h5", p, "{}");
  const ParticleFile back = read_particles(folder / "particles.h5");
  EXPECT_EQ(back.solid_position, p.solid_position);
  EXPECT_EQ(back.solid_volume, p.solid_volume);
  EXPECT_EQ(back.solid_driver, p.solid_driver);
  EXPECT_EQ(back.solid_follows, p.solid_follows);
  EXPECT_EQ(back.driving_position, p.driving_position);
  EXPECT_EQ(back.driving_volume, p.driving_volume);
  EXPECT_EQ(back.cell_size, p.cell_size);
  EXPECT_EQ(back.metres_per_unit, p.metres_per_unit);
  EXPECT_EQ(back.pinned_json, p.pinned_json);
  const MaterialFile m = {floats(40, 1, 2), floats(40, 0, 0.4), floats(40, 1, 2), "fitted", {}, {}};
  write_material(folder / "material.h5", m, "{}");
  const MaterialFile found = read_material(folder / "material.h5");
  EXPECT_EQ(found.young, m.young);
  EXPECT_EQ(found.poisson, m.poisson);
  EXPECT_EQ(found.density, m.density);
  EXPECT_EQ(found.source, "fitted");
  EXPECT_EQ(found.position, p.solid_position);
  EXPECT_EQ(found.volume, p.solid_volume);
  EXPECT_TRUE(found.branch.empty());
}

/// Writes a trajectory where no file may grow beyond 64 kB, and ends: 7 = with the message.
[[noreturn]] void write_to_a_full_disk(const fs::path& file) {
  signal(SIGXFSZ, SIG_IGN);
  const rlimit most{1 << 16, 1 << 16};
  setrlimit(RLIMIT_FSIZE, &most);
  TrajectoryFile t = some_trajectory();
  Random random(1, 0);
  const size_t count = 20000;
  for (TrajectoryFile::Frame& frame : t.frames) {
    frame.position.resize(count);
    for (Vec3f& x : frame.position)
      for (int a = 0; a < 3; ++a) x[a] = static_cast<float>(random.normal());
    frame.velocity = frame.position;
    frame.F.assign(count, Mat3f::Identity());
  }
  try {
    write_trajectory(file, t, "{}");
  } catch (const Error& error) {
    std::exit(std::string(error.what()).find("free space") != std::string::npos ? 7 : 8);
  }
  std::exit(9);
}

// A file that cannot grow is as good as a full disk; the program then ends as it always does.
TEST(Store, AFullDiskIsSaidAndTheProgramEndsWithoutACrash) {
  const TemporaryFolder folder;
  EXPECT_EXIT(write_to_a_full_disk(folder / "t.h5"), testing::ExitedWithCode(7), "");
}

TEST(Store, RelaxingBranchesOfAMaterialSurvive) {
  const TemporaryFolder folder;
  MaterialFile m = {floats(3, 1, 2), floats(3, 0, 0.4), floats(3, 1, 2), "physics3d", {}, {}};
  m.branch = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  write_material(folder / "material.h5", m, "{}");
  const std::vector<RelaxingBranch> found = read_material(folder / "material.h5").branch;
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[1].shear, 4);
  EXPECT_EQ(found[1].lambda, 5);
  EXPECT_EQ(found[2].viscosity, 9);
  m.branch[1].viscosity = 0;
  write_material(folder / "wrong.h5", m, "{}");
  expect_error(Failure::kInput, {"wrong.h5", "/solid/branch", "row 1"}, [&] { read_material(folder / "wrong.h5"); });
}

TEST(Store, TrajectorySurvivesInTheShapeOfH5md) {
  const TemporaryFolder folder;
  const TrajectoryFile t = some_trajectory();
  write_trajectory(folder / "t.h5", t, R"({"seed": 3})");
  const TrajectoryFile back = read_trajectory(folder / "t.h5");
  EXPECT_EQ(back.object, "1_flower");
  EXPECT_EQ(back.fps, 24);
  EXPECT_EQ(back.metres_per_unit, 0.5);
  EXPECT_EQ(back.cell_size, 0.02);
  EXPECT_EQ(back.up, t.up);
  ASSERT_EQ(back.frames.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(back.frames[i].time, t.frames[i].time);
    EXPECT_EQ(back.frames[i].step, t.frames[i].step);
    EXPECT_EQ(back.frames[i].position, t.frames[i].position);
    EXPECT_EQ(back.frames[i].velocity, t.frames[i].velocity);
    EXPECT_EQ(back.frames[i].F, t.frames[i].F);
  }
  const Hdf5Reader in(folder / "t.h5");
  EXPECT_EQ(in.shape("/particles/1_flower/F/value"), (Shape{4, 6, 3, 3}));
  EXPECT_EQ(in.shape("/particles/1_flower/velocity/time"), (Shape{4}));
  EXPECT_EQ(in.text("/", "provenance"), R"({"seed": 3})");
  EXPECT_TRUE(in.has_attribute("/h5md", "version"));
  EXPECT_TRUE(in.has_attribute("/particles/1_flower/box", "dimension"));
  // F is stored by rows.
  EXPECT_EQ(in.dataset<float>("/particles/1_flower/F/value", {4, 6, 3, 3})[1], t.frames[0].F[0](0, 1));
}

/// A training of 7 Gaussians with every part in use, or only what is always there.
TrainingCheckpoint some_training(bool everything) {
  TrainingCheckpoint c;
  TrainingState& s = c.state;
  s.iteration = 321;
  s.seconds = 12.5;
  s.started_with = 5;
  s.cloud.sh_degree = 1;
  s.cloud.resize(7);
  if (everything) {
    s.attribute = floats(7 * 3);
    s.shared = floats(11);
    s.exposure = floats(2 * 12);
    s.screen_gradient = floats(7);
    s.times_seen = floats(7);
    s.curve = {{100, 3.25, 6, 21.5, 0.7}, {200, 7.5, 7, INFINITY, 1}};
  }
  fit_moments(s);
  visit_gaussian_arrays(s, [](const std::string&, auto& array) {
    for (float& value : flat(array)) value = static_cast<float>(dice.normal());
  });
  for (auto* m : {&s.shared_moments, &s.exposure_moments}) {
    m->first = floats(m->first.size());
    m->second = floats(m->second.size());
  }
  s.cloud.position[3].x() = NAN;  // a Gaussian that was lost is kept for the strategy to deal with
  c.start_json = R"({"kind": "random"})";
  c.provenance_json = R"({"seed": 1})";
  return c;
}

std::map<std::string, std::vector<uint32_t>> bits_of(const TrainingState& s) {
  std::map<std::string, std::vector<uint32_t>> bits;
  visit_gaussian_arrays(s, [&](const std::string& name, const auto& array) {
    for (float value : flat(array)) bits[name].push_back(std::bit_cast<uint32_t>(value));
  });
  return bits;
}

TEST(Trajectory, BetweenTwoFramesACubicMotionIsExact) {
  TrajectoryFile motion;
  motion.fps = 4;
  motion.metres_per_unit = 2;
  const auto position = [](double t) { return Vec3f(t, 1 - t * t, 0.5 * t * t * t); };         // scene units
  const auto velocity = [](double t) { return Vec3f(2 * 1, 2 * (-2 * t), 2 * 1.5 * t * t); };  // m/s
  for (int f = 0; f < 4; ++f) {
    const double t = f / motion.fps;
    TrajectoryFile::Frame frame;
    frame.time = t;
    frame.position = {position(t)};
    frame.velocity = {velocity(t)};
    frame.F = {Mat3f::Identity() * static_cast<float>(1 + t)};
    motion.frames.push_back(frame);
  }
  for (double t = 0; t <= 0.75; t += 0.03) {
    const TrajectoryFile::Frame between = motion.at(t);
    EXPECT_LT((between.position[0] - position(t)).norm(), 1e-6) << t;
    EXPECT_NEAR(between.F[0](1, 1), 1 + t, 1e-6);
  }
  EXPECT_EQ(motion.at(0.5).position[0], motion.frames[2].position[0]);
  EXPECT_EQ(motion.at(0.5 + 1e-9).velocity[0], motion.frames[2].velocity[0]);
  EXPECT_EQ(motion.at(-1).position[0], motion.frames[0].position[0]);
  EXPECT_EQ(motion.at(9).position[0], motion.frames[3].position[0]);
}

TEST(Store, TrainingSurvivesBitForBit) {
  const TemporaryFolder folder;
  for (const bool everything : {true, false}) {
    const TrainingCheckpoint c = some_training(everything);
    write_training(folder / "c.h5", c);
    const TrainingCheckpoint back = read_training(folder / "c.h5");
    EXPECT_EQ(bits_of(back.state), bits_of(c.state));
    EXPECT_EQ(back.state.cloud.sh_degree, 1);
    EXPECT_EQ(back.state.iteration, 321);
    EXPECT_EQ(back.state.seconds, 12.5);
    EXPECT_EQ(back.state.started_with, 5u);
    EXPECT_EQ(back.state.exposure, c.state.exposure);
    EXPECT_EQ(back.state.exposure_moments.first, c.state.exposure_moments.first);
    EXPECT_EQ(back.state.exposure_moments.second, c.state.exposure_moments.second);
    EXPECT_EQ(back.state.shared, c.state.shared);
    EXPECT_EQ(back.state.shared_moments.first, c.state.shared_moments.first);
    EXPECT_EQ(back.state.shared_moments.second, c.state.shared_moments.second);
    ASSERT_EQ(back.state.curve.size(), c.state.curve.size());
    for (size_t i = 0; i < c.state.curve.size(); ++i) {
      EXPECT_EQ(back.state.curve[i].iteration, c.state.curve[i].iteration);
      EXPECT_EQ(back.state.curve[i].seconds, c.state.curve[i].seconds);
      EXPECT_EQ(back.state.curve[i].gaussians, c.state.curve[i].gaussians);
      EXPECT_EQ(back.state.curve[i].psnr, c.state.curve[i].psnr);
      EXPECT_EQ(back.state.curve[i].ssim, c.state.curve[i].ssim);
    }
    EXPECT_EQ(back.start_json, c.start_json);
    EXPECT_EQ(read_training_provenance(folder / "c.h5"), c.provenance_json);
  }
}

TEST(Store, ATrainingThatDoesNotFitTogetherNamesTheDataset) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::function<void(TrainingCheckpoint&)>& spoil, const std::string& word) {
    TrainingCheckpoint c = some_training(true);
    spoil(c);
    write_training(folder / "bad.h5", c);
    expect_error(Failure::kInput, {"bad.h5", word}, [&] { read_training(folder / "bad.h5"); });
  };
  refused([](TrainingCheckpoint& c) { c.state.sh.first.clear(); }, "/gaussians/sh_first");
  refused([](TrainingCheckpoint& c) { c.state.cloud.sh.resize(7 * 3); }, "/gaussians/sh");
  refused([](TrainingCheckpoint& c) { c.state.attribute.resize(7 * 17); }, "/gaussians/attribute");
  refused([](TrainingCheckpoint& c) { c.state.attribute_moments.second.resize(7); }, "/gaussians/attribute_second");
  refused([](TrainingCheckpoint& c) { c.state.times_seen.resize(14); }, "/gaussians/times_seen");
  refused([](TrainingCheckpoint& c) { c.state.exposure_moments.first.resize(12); }, "/exposure");
  refused([](TrainingCheckpoint& c) { c.state.shared_moments.second.clear(); }, "/shared");
  refused([](TrainingCheckpoint& c) { c.state.curve[1].iteration = -4; }, "/curve");
  refused([](TrainingCheckpoint& c) { c.state.iteration = -1; }, "iteration");
  refused([](TrainingCheckpoint& c) { c.state.seconds = -1; }, "seconds");
  refused([](TrainingCheckpoint& c) { c.state.cloud.sh_degree = 7; }, "sh_degree");
  write_training(folder / "good.h5", some_training(true));
  const std::string good = read_text(folder / "good.h5");
  for (size_t part = 1; part < 8; ++part) {
    folder.file("cut.h5", good.substr(0, good.size() * part / 8));
    expect_error(Failure::kInput, {"cut.h5"}, [&] { read_training(folder / "cut.h5"); });
  }
  write_particles(folder / "p.h5", some_particles(), "{}");
  expect_error(Failure::kInput, {"p.h5"}, [&] { read_training(folder / "p.h5"); });
}

TEST(Store, EqualContentsGiveEqualBytesAtAnotherTime) {
  const TemporaryFolder folder;
  const Segmentation s = some_segmentation();
  const TrajectoryFile t = some_trajectory();
  const ParticleFile p = some_particles();
  const std::string provenance(100000, 'p');  // longer than what an attribute header holds
  for (const char* name : {"a", "b"}) {
    write_segmentation(folder / (name + std::string("_s.h5")), s, provenance);
    write_trajectory(folder / (name + std::string("_t.h5")), t, provenance);
    write_particles(folder / (name + std::string("_p.h5")), p, provenance);
    if (name[0] == 'a') std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  }
  for (const char* kind : {"_s.h5", "_t.h5", "_p.h5"}) {
    EXPECT_EQ(sha256_of_file(folder / (std::string("a") + kind)), sha256_of_file(folder / (std::string("b") + kind)))
        << kind;
  }
  EXPECT_EQ(Hdf5Reader(folder / "a_t.h5").text("/", "provenance"), provenance);
}

TEST(Store, FilesOfAnotherKindNameFileAndDataset) {
  const TemporaryFolder folder;
  write_particles(folder / "p.h5", some_particles(), "{}");
  const std::string good = read_text(folder / "p.h5");
  const auto refused = [&](const fs::path& file, std::vector<std::string> words,
                           const std::function<void(const fs::path&)>& read) {
    words.push_back(file.filename());
    expect_error(Failure::kInput, words, [&] { read(file); });
  };
  const auto particles = [](const fs::path& file) { read_particles(file); };
  refused(folder / "none.h5", {"does not exist"}, particles);
  refused(folder.path(), {"is not a file"}, particles);
  refused(folder.file("empty.h5", ""), {"not an HDF5 file"}, particles);
  refused(folder.file("text.h5", "hello"), {"not an HDF5 file"}, particles);
  for (size_t part = 1; part < 8; ++part)
    refused(folder.file("cut.h5", good.substr(0, good.size() * part / 8)), {}, particles);
  refused(folder / "p.h5", {"/label", "missing"}, [](const fs::path& f) { read_segmentation(f); });
  refused(folder / "p.h5", {"/label", "missing"}, [](const fs::path& f) { read_labels(f); });
  refused(folder / "p.h5", {"/solid/young", "missing"}, [](const fs::path& f) { read_material(f); });
  refused(folder / "p.h5", {"/particles", "missing"}, [](const fs::path& f) { read_trajectory(f); });
}

TEST(Store, WrongShapesTypesAndValuesNameTheDataset) {
  const TemporaryFolder folder;
  const auto written = [&](const std::function<void(Hdf5Writer&)>& body) {
    write_hdf5(folder / "bad.h5", body);
    return folder / "bad.h5";
  };
  const std::vector<float> f = floats(30, 0.1, 0.4);
  const std::vector<double> d(30, 1.0);
  const auto material = [&](const std::function<void(Hdf5Writer&)>& young, std::vector<std::string> words) {
    const fs::path file = written([&](Hdf5Writer& out) {
      out.group("/solid");
      young(out);
      out.dataset("/solid/poisson", f.data(), {30});
      out.dataset("/solid/density", f.data(), {30});
      out.text("/solid", "source", "x");
    });
    words.insert(words.end(), {"bad.h5", "/solid/"});
    expect_error(Failure::kInput, words, [&] { read_material(file); });
  };
  material([&](Hdf5Writer& out) { out.dataset("/solid/young", d.data(), {30}); }, {"young", "32-bit float"});
  material([&](Hdf5Writer& out) { out.dataset("/solid/young", f.data(), {10, 3}); }, {"young", "[10, 3]"});
  material([&](Hdf5Writer& out) { out.dataset("/solid/young", f.data(), {29}); }, {"poisson", "[30]", "[29]"});
  material([&](Hdf5Writer& out) { out.group("/solid/young"); }, {"young", "not a dataset"});
  for (float bad : {-1.0f, 0.0f, NAN, INFINITY}) {
    std::vector<float> values(30, 1.0f);
    values[7] = bad;
    material([&](Hdf5Writer& out) { out.dataset("/solid/young", values.data(), {30}); }, {"young", "row 7"});
  }
  ParticleFile p = some_particles();
  p.solid_driver[3] = 5;
  write_particles(folder / "bad.h5", p, "{}");
  expect_error(Failure::kInput, {"/solid/driver", "5 of 5"}, [&] { read_particles(folder / "bad.h5"); });
  p = some_particles();
  for (const int followed : {-2, 6, 40}) {  // of which 6 is not simulated
    p.solid_follows[12] = followed;
    write_particles(folder / "bad.h5", p, "{}");
    expect_error(Failure::kInput, {"/solid/follows", std::to_string(followed)},
                 [&] { read_particles(folder / "bad.h5"); });
  }
  p = some_particles();
  p.driving_position[2].y() = NAN;
  write_particles(folder / "bad.h5", p, "{}");
  expect_error(Failure::kInput, {"/driving/position", "row 2"}, [&] { read_particles(folder / "bad.h5"); });
  p = some_particles();
  p.pinned_json = "[{";
  write_particles(folder / "bad.h5", p, "{}");
  expect_error(Failure::kInput, {"pinned", "JSON"}, [&] { read_particles(folder / "bad.h5"); });
  TrajectoryFile t = some_trajectory();
  t.frames[2].time = 0;
  write_trajectory(folder / "bad.h5", t, "{}");
  expect_error(Failure::kInput, {"/particles/1_flower/position/time"}, [&] { read_trajectory(folder / "bad.h5"); });
  t = some_trajectory();
  t.frames[1].F[3](0, 0) = NAN;
  write_trajectory(folder / "bad.h5", t, "{}");
  expect_error(Failure::kInput, {"/F/value", "frame 1"}, [&] { read_trajectory(folder / "bad.h5"); });
  expect_error(Failure::kInput, {"/particles/other"}, [&] { read_trajectory(folder / "bad.h5", "other"); });
}

TEST(Store, AnyNameOfAnObjectIsThatOfAGroup) {
  const TemporaryFolder folder;
  for (const auto& [name, group] :
       {std::pair("größe \"x\"", "größe \"x\""), std::pair("a/b", "a_b"), std::pair("/", "_"), std::pair(".", "_"),
        std::pair("", "_"), std::pair("..", "..")}) {
    TrajectoryFile t = some_trajectory();
    t.object = group_name(name);
    EXPECT_EQ(t.object, group);
    write_trajectory(folder / "t.h5", t, "{}");
    EXPECT_EQ(read_trajectory(folder / "t.h5").object, group);
  }
}

TEST(Store, PromisedArraysThatAreNotStoredAreRefusedBeforeTheyAreAllocated) {
  const TemporaryFolder folder;
  const hsize_t rows = hsize_t{1} << 40, chunk = 1024;
  const hid_t file = H5Fcreate((folder / "huge.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t space = H5Screate_simple(1, &rows, nullptr), properties = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_chunk(properties, 1, &chunk);
  H5Dclose(H5Dcreate2(file, "/label", H5T_NATIVE_UINT32, space, H5P_DEFAULT, properties, H5P_DEFAULT));
  H5Pclose(properties);
  H5Sclose(space);
  H5Fclose(file);
  expect_error(Failure::kInput, {"huge.h5", "/label", "not stored"}, [&] { read_labels(folder / "huge.h5"); });
}

}  // namespace
}  // namespace pliant
