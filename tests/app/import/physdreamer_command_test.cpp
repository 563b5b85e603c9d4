// A scene folder of PhysDreamer, made from the demo's flower, through the command line: what moves, what is held, its
// video, and fields as they were released.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/fit/fit_scene.h"
#include "app/import/physdreamer_fields.h"
#include "app/run/attach_scene.h"
#include "app/run/physdreamer_scene.h"
#include "app/store/material.h"
#include "app/store/particles.h"
#include "app/store/segmentation.h"
#include "app/store/velocity.h"
#include "fitting/fields/triplane_field.h"
#include "gaussians/base/random.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/run_pliant.h"
#include "tests/app/small_demo.h"
#include "tests/app/torch_files.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

bool inside(const std::vector<SceneFile::Region>& boxes, const Vec3f& x) {
  for (const SceneFile::Region& box : boxes)
    if (box.contains(x)) return true;
  return false;
}

TEST(PhysDreamerCommand, BoxesHoldWhatIsHeldAndNothingElse) {
  std::vector<Vec3f> held, free;
  for (int i = 0; i < 4000; ++i) {
    Random random(3, i);
    const Vec3f x(static_cast<float>(random.uniform()), static_cast<float>(random.uniform()),
                  static_cast<float>(random.uniform()));
    (x.sum() < 1.2f ? held : free).push_back(x);  // a slanted border
  }
  const auto boxes = boxes_around(held, free, 0.05);
  EXPECT_LE(boxes.size(), 64u);
  size_t within = 0;
  for (const Vec3f& x : held) within += inside(boxes, x);
  EXPECT_GT(static_cast<double>(within),
            0.75 * static_cast<double>(held.size()));  // cells on the border belong to what is free
  for (const Vec3f& x : free) EXPECT_FALSE(inside(boxes, x));
  EXPECT_TRUE(boxes_around({}, free, 0.05).empty());
}

FitScene load_fit(const RunDirectory& run, const FitStage& stage, std::string& said) {
  Progress progress(false);
  const Context context{progress, [] { return false; }};
  struct Captured {
    std::string& said;
    Captured(std::string& said) : said(said) { ::testing::internal::CaptureStderr(); }
    ~Captured() { said = ::testing::internal::GetCapturedStderr(); }
  } captured(said);
  return load_fit_scene(context, run, inputs_of(run, load_run_scene(run), stage));
}

/// Masks say what moves at rest; of several videos the first one is fitted, and others by name, as the folder's are.
void expect_masks_and_videos(const fs::path& scene, const RunDirectory& run) {
  std::string said;
  const FitScene whole = load_fit(run, {}, said);
  EXPECT_EQ(said.find("is fitted, and not"), std::string::npos) << said;
  const std::string camera = whole.video.camera.name;
  const int width = whole.moving.width, height = whole.moving.height;
  double middle = 0;
  for (const Eigen::Vector2d& x : whole.pixel) middle += x.x() / static_cast<double>(whole.pixel.size());
  ImageF mask(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = static_cast<int>(middle) - 4; x < width; ++x)
      for (int c = 0; c < 3; ++c) mask(x, y, c) = 1;
  fs::create_directories(scene / "masks");
  write_image(scene / "masks" / (camera + "_mask.png"), mask);
  const fs::path first = scene / "videos" / (camera + "_swing.mp4"), second = scene / "videos" / (camera + "_two.mp4");
  fs::copy_file(first, second);
  const FitScene masked = load_fit(run, {}, said);
  EXPECT_NE(said.find("of the movable pixels"), std::string::npos) << said;
  EXPECT_NE(said.find(first.string() + " is fitted, and not " + second.filename().string()), std::string::npos) << said;
  EXPECT_GT(masked.pixel.size(), 20u);
  for (const Eigen::Vector2d& x : masked.pixel) EXPECT_GE(x.x() + 4, middle);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      EXPECT_EQ(masked.moving(x, y), mask(x, y, 0) * whole.moving(x, y));
      EXPECT_EQ(masked.mask(x, y) != 0, masked.moving(x, y) > 0.5f);
    }
  // By name: its camera and 30 frames a second, though the file says 24.
  FitStage both;
  both.videos = {second.string(), first.string()};
  const FitScene two = load_fit(run, both, said);
  EXPECT_EQ(said.find("is fitted, and not"), std::string::npos) << said;
  ASSERT_EQ(two.further.size(), 1u);
  for (const FitView* view : two.views()) {
    EXPECT_EQ(view->video.camera.name, camera);
    EXPECT_EQ(view->video.source_fps, 30);
    EXPECT_EQ(view->pixel.size(), masked.pixel.size());
  }
  // A camera names its video: this one shows what another camera saw.
  const std::string beside = camera == "view_001" ? "view_002" : "view_001";
  fs::rename(second, scene / "videos" / (beside + "_other.mp4"));
  FitStage other;
  other.cameras = {beside};
  expect_error(Failure::kInput, {beside + "_other.mp4", "does not show the scene from camera '" + beside},
               [&] { load_fit(run, other, said); });
  fs::remove(scene / "videos" / (beside + "_other.mp4"));
  fs::remove_all(scene / "masks");
}

struct NamedTensor {
  std::string name;
  std::vector<int64_t> shape;
  std::vector<float> values;
};

std::string state_dict_of(const std::vector<NamedTensor>& tensors) {
  std::vector<std::pair<std::string, std::string>> entries;
  std::vector<std::string> storages;
  for (const auto& [name, shape, values] : tensors) {
    int64_t count = 1;
    std::vector<int64_t> stride(shape.size());
    for (size_t a = shape.size(); a-- > 0;) {
      stride[a] = count;
      count *= shape[a];
    }
    EXPECT_EQ(static_cast<size_t>(count), values.size()) << name;
    entries.push_back(
        {name, tensor_pickle("FloatStorage", static_cast<int>(storages.size()), count, 0, shape, stride)});
    storages.push_back(floats(values));
  }
  return torch_archive("archive", pickle_of(entries), storages);
}

/// A field whose value is the same everywhere: only the last bias is not zero.
std::string constant_field(const std::vector<float>& value, const std::vector<int64_t>& plane = {4, 8, 8}) {
  const int64_t n = static_cast<int64_t>(value.size());
  std::vector<NamedTensor> tensors;
  for (int k = 0; k < 3; ++k)
    tensors.push_back({"kplanes_encoding.plane_coefs." + std::to_string(k), plane, std::vector<float>(256, 0.3f)});
  tensors.push_back({"decoder.layers.0.weight", {4, 4}, std::vector<float>(16, 0.1f)});
  tensors.push_back({"decoder.layers.0.bias", {4}, std::vector<float>(4)});
  tensors.push_back({"decoder.layers.1.weight", {n, 4}, std::vector<float>(value.size() * 4)});
  tensors.push_back({"decoder.layers.1.bias", {n}, value});
  return state_dict_of(tensors);
}

/// Names and shapes of the released code: the value rises along x from 0 to 100 within the box `aabb`.
std::string linear_field(const std::vector<float>& aabb) {
  std::vector<float> plane(256);
  for (size_t i = 0; i < 64; ++i) plane[i] = static_cast<float>(i % 8) / 7;
  std::vector<float> same(16);
  for (size_t i = 0; i < 4; ++i) same[5 * i] = 1;
  return state_dict_of({{"aabb", {2, 3}, aabb},
                        {"kplanes_encoding.plane_coefs.0", {4, 8, 8}, plane},
                        {"kplanes_encoding.plane_coefs.1", {4, 8, 8}, std::vector<float>(256)},
                        {"kplanes_encoding.plane_coefs.2", {4, 8, 8}, std::vector<float>(256)},
                        {"decoder.layers.0.weight", {4, 4}, same},
                        {"decoder.layers.0.bias", {4}, std::vector<float>(4)},
                        {"decoder.layers.1.weight", {1, 4}, {100, 0, 0, 0}},
                        {"decoder.layers.1.bias", {1}, {0}}});
}

/// The demo's scene as PhysDreamer keeps scenes; the flower's stem and blossom move.
void make_folder(const fs::path& folder) {
  DemoOptions demo = small_demo(folder / "demo");
  demo.video_particles = 2000;
  demo.video_seconds = 1;
  make_demo(demo);
  const fs::path scene = folder / "flower";
  const json settings = json::parse(read_text(folder / "demo/scene.json"));
  fs::create_directories(scene / "videos");
  fs::rename(folder / "demo/splats.ply", scene / "point_cloud.ply");
  fs::rename(folder / "demo/photos", scene / "images");
  std::string cameras = read_text(folder / "demo/transforms.json");
  for (size_t at = 0; (at = cameras.find("photos/", at)) != std::string::npos;) cameras.replace(at, 7, "images/");
  write_text(scene / "transforms_train.json", cameras);
  fs::rename(folder / "demo/reference.mp4",
             scene / "videos" / (settings["video"]["camera"].get<std::string>() + "_swing.mp4"));
  const LabelFile labels = read_labels(folder / "demo/truth/labels.h5");
  const GaussianCloud cloud = read_ply(scene / "point_cloud.ply");
  const json box = settings["pinned"][0]["box"];
  std::vector<int> of_object, of_moving;
  for (size_t i = 0; i < cloud.size(); ++i) {
    if (labels.label[i] == 0 || labels.names.at(labels.label[i]) != "flower") continue;
    of_object.push_back(static_cast<int>(i));
    if (cloud.position[i].z() > box[5].get<float>()) of_moving.push_back(static_cast<int>(i));
  }
  write_ply(scene / "clean_object_points.ply", cloud.select(of_object));
  write_ply(scene / "moving_part_points.ply", cloud.select(of_moving));
}

TEST(PhysDreamerCommand, ASceneFolderRunsAsItIsAndItsReleasedFieldsAreTaken) {
  const TemporaryFolder folder;
  make_folder(folder.path());
  const std::string scene = (folder / "flower").string(), out = (folder / "run").string();
  EXPECT_EQ(run_quietly({"info", scene, "--json"}), 0);
  ASSERT_EQ(run_quietly({"run", scene, "--out", out, "--seed.particles", "500", "--duration", "0.3", "--simulate.fps",
                         "10", "--render.no-orbit"}),
            0);
  const json stages = json::parse(read_text(folder / "run/run.json"))["stages"];
  EXPECT_EQ(stages["extract"]["summary"]["name"], "object");
  EXPECT_GT(stages["extract"]["summary"]["object_gaussians"].get<size_t>(),
            0.8 * read_ply(folder / "flower/clean_object_points.ply").size());
  EXPECT_GT(stages["seed"]["summary"]["pinned"].size(), 0u);
  EXPECT_EQ(stages["fit"]["found"]["material"]["density"], 2000);
  EXPECT_GT(stages["fit"]["summary"]["young_pa"].get<double>(), 0);

  expect_masks_and_videos(folder / "flower", RunDirectory::open(out));

  // Released fields: E0 + 1000 f in its cube, whose edge is 1.8 times the object's largest extent.
  folder.file("flower/sim_fields.pt", constant_field({25}));
  folder.file("flower/velo_fields.pt", constant_field({2, 0, -1}));
  const std::vector<std::string> released = {"fit", out, "--released-fields", "1e5"};
  ASSERT_EQ(run_quietly(released), 0);
  const RunDirectory run = RunDirectory::open(out);
  const fs::path object = run / object_folder(run);
  const Scene loaded = load_run_scene(run);
  const PhysDreamerSpace space = physdreamer_roles({}, *physdreamer_folder(loaded), loaded.cloud.position).space;
  const double edge = space.scale * loaded.metres_per_unit;
  const MaterialFile material = read_material(object / "material.h5");
  for (const float young : material.young) EXPECT_NEAR(young / (1.25e5 * edge * edge), 1, 1e-5);
  EXPECT_EQ(material.density.front(), 2000);
  const VelocityFile start = read_velocity(object / "velocity.h5");
  EXPECT_NEAR(start.velocity.front().x(), 0.2 * edge, 1e-6);
  EXPECT_NEAR(start.velocity.front().z(), -0.1 * edge, 1e-6);
  EXPECT_EQ(start.position, read_particles(object / "particles.h5").driving_position);

  // The box that a file holds is where its field lies.
  folder.file("flower/sim_fields.pt", linear_field({0.4f, 0.2f, 0.1f, 0.5f, 0.8f, 0.9f}));
  ASSERT_EQ(run_quietly(released), 0);
  const std::vector<float> linear = read_material(object / "material.h5").young;
  const std::vector<Vec3f> places = read_particles(object / "particles.h5").solid_position;
  ASSERT_EQ(linear.size(), places.size());
  for (size_t i = 0; i < places.size(); ++i) {
    const double along = std::clamp((space.inside(places[i].cast<double>()).x() - 0.4) / 0.1, 0.0, 1.0);
    EXPECT_NEAR(linear[i] / (edge * edge), 1e5 + 1e5 * along, 20);
  }

  folder.file("flower/sim_fields.pt", constant_field({25, 3}));
  EXPECT_EQ(run_quietly(released), 1);
  folder.file("flower/sim_fields.pt", "no archive");
  EXPECT_EQ(run_quietly(released), 1);
  fs::remove(folder / "flower/sim_fields.pt");
  EXPECT_EQ(run_quietly(released), 1);
}

TEST(PhysDreamerFields, WhatIsNoFieldIsRefusedByName) {
  const TemporaryFolder folder;
  const PhysDreamerField field = read_physdreamer_field(folder.file("good.pt", constant_field({1, 2, 3})), 3);
  EXPECT_EQ(field.layers, 2);
  EXPECT_EQ(field.features, 4);
  EXPECT_EQ(field.hidden, 4);
  EXPECT_EQ(field.resolution, 8);
  EXPECT_EQ(field.parameters.size(), 3u * 4 * 64 + 16 + 4 + 12 + 3);
  EXPECT_FALSE(field.box);
  const std::string leading = constant_field({1, 2, 3}, {1, 4, 8, 8});
  EXPECT_EQ(read_physdreamer_field(folder.file("leading.pt", leading), 3).parameters, field.parameters);
  const PhysDreamerField boxed = read_physdreamer_field(folder.file("box.pt", linear_field({0, 1, 2, 3, 4, 5})), 1);
  ASSERT_TRUE(boxed.box);
  EXPECT_EQ((*boxed.box)[0], Vec3d(0, 1, 2));
  EXPECT_EQ((*boxed.box)[1], Vec3d(3, 4, 5));
  folder.file("flat.pt", linear_field({0, 1, 2, 3, 1, 5}));
  expect_error(Failure::kInput, {"flat.pt", "aabb", "low end"}, [&] { read_physdreamer_field(folder / "flat.pt", 1); });
  expect_error(Failure::kInput, {"good.pt", "3 values", "1 are needed"},
               [&] { read_physdreamer_field(folder / "good.pt", 1); });
  folder.file("conv.pt",
              torch_archive("a", conv_pickle(3, 4), {floats(std::vector<float>(12)), floats(std::vector<float>(3))}));
  expect_error(Failure::kInput, {"conv.pt", "weight", "not a feature plane"},
               [&] { read_physdreamer_field(folder / "conv.pt", 1); });
}

}  // namespace
}  // namespace pliant
