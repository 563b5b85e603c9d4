// Nothing is stale: the key of a stage changes with everything that the stage reads, of the scene, of its files and of
// its options, and with nothing else.

#include <algorithm>
#include <cstring>
#include <set>

#include "app/fit/fit_stage.h"
#include "app/predict/predict_stage.h"
#include "app/reconstruct/photo_set.h"
#include "app/reconstruct/reconstruct_stage.h"
#include "app/render/render_stage.h"
#include "app/seed/seed_stage.h"
#include "app/segment/extract_stage.h"
#include "app/segment/label_photos.h"
#include "app/segment/repair_stage.h"
#include "app/segment/segment_stage.h"
#include "app/simulate/simulate_stage.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/fit_video_scene.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

using Names = std::set<std::string>;

/// Bytes of an object.
struct Bytes {
  size_t begin, end;
};

Bytes bytes_of(const void* object, const void* field, size_t size) {
  const size_t begin = static_cast<size_t>(static_cast<const char*>(field) - static_cast<const char*>(object));
  return {begin, begin + size};
}

Bytes bytes_of(const void* object, const OptionField& field) {
  return std::visit(
      [object](const auto& f) {
        if constexpr (std::is_pointer_v<std::decay_t<decltype(f)>>)
          return bytes_of(object, f, sizeof(*f));
        else if constexpr (std::is_same_v<std::decay_t<decltype(f)>, EntryField>)
          return bytes_of(object, f.values, sizeof(*f.values));
        else
          return bytes_of(object, f.value, sizeof(*f.value));
      },
      field);
}

/// Offsets of bytes of a stage that belong neither to an option nor to `other`, and are no padding: a constructor
/// writes the same into them whatever was there before.
template <class Stage>
std::vector<size_t> unknown_bytes(const std::function<std::vector<Bytes>(const Stage&)>& other) {
  alignas(Stage) unsigned char zeros[sizeof(Stage)], ones[sizeof(Stage)];
  std::memset(zeros, 0, sizeof(Stage));
  std::memset(ones, 0xff, sizeof(Stage));
  Stage* stage = new (zeros) Stage;
  Stage* twin = new (ones) Stage;
  std::vector<bool> known(sizeof(Stage));
  std::vector<Bytes> ranges = other(*stage);
  for (const Option& option : options_of(*stage).options) ranges.push_back(bytes_of(stage, option.field));
  for (const Bytes& range : ranges)
    for (size_t b = range.begin; b < range.end; ++b) known.at(b) = true;
  std::vector<size_t> unknown;
  for (size_t b = 0; b < sizeof(Stage); ++b)
    if (!known[b] && zeros[b] == ones[b]) unknown.push_back(b);
  stage->~Stage();
  twin->~Stage();
  return unknown;
}

class StageKeys : public FitVideo {
 protected:
  void SetUp() override {
    settings_ = original_ = json::parse(read_text(folder / "scene/scene.json"));
    // Only the contents count of what later stages read.
    const fs::path object = fs::directory_iterator(folder / "run/objects")->path();
    for (const char* name : {"trajectory.h5", "material.h5", "velocity.h5"}) write_text(object / name, name);
    json record = json::parse(read_text(folder / "run/run.json"));
    // Only keys are asked for here, not whether the particles are of this object.
    for (const char* stage : {"fill", "seed"}) record["stages"][stage]["inputs"].erase("object");
    record["stages"]["simulate"] = record["stages"]["seed"];
    write_text(folder / "run/run.json", record.dump());
    write_text(folder / "markers.csv", "time");
  }
  void TearDown() override {
    settings_ = original_;
    write_settings();
  }
  void write_settings() const { write_text(folder / "scene/scene.json", settings_.dump(2)); }

  using Keys = std::map<std::string, json>;

  template <class Stage>
  static void add(const std::string& name, const RunDirectory& run, const Scene& scene, const Stage& stage,
                  Keys& keys) {
    keys[name] = record_of(key_of(inputs_of(run, scene, stage)), 1);
  }

  /// The keys of all stages, some of them in several situations.
  static Keys keys() {
    const RunDirectory run = RunDirectory::open(folder / "run");
    const Scene scene = load_run_scene(run);
    Keys all;
    const PhotoSet set = find_photo_set(scene.source, "");
    ReconstructStage joint;
    joint.joint = true;
    all["reconstruct"] = record_of(key_of(inputs_of(set, read_photo_cameras(set), ReconstructStage())), 1);
    all["reconstruct jointly"] = record_of(key_of(inputs_of(set, read_photo_cameras(set), joint)), 1);
    add("label", run, scene, LabelStage(), all);
    add("segment", run, scene, SegmentStage(), all);
    SegmentStage automatic, sphere;
    automatic.automatic = true;
    sphere.sphere = {0, 0, 0.2, 0.1};
    add("segment automatically", run, scene, automatic, all);
    add("segment a sphere", run, scene, sphere, all);
    add("extract", run, scene, ExtractStage(), all);
    add("repair", run, scene, RepairStage(), all);
    add("fill", run, scene, FillStage(), all);
    add("predict", run, scene, PredictStage(), all);
    add("seed", run, scene, SeedStage(), all);
    FitStage find, markers, guided;
    find.cameras = {"find"};
    markers.markers.file = folder / "markers.csv";
    add("fit", run, scene, FitStage(), all);
    add("fit, camera found", run, scene, find, all);
    add("fit to markers", run, scene, markers, all);
    add("simulate", run, scene, SimulateStage(), all);
    SimulateStage moving;
    moving.velocity_file = folder / "markers.csv";
    add("simulate a start", run, scene, moving, all);
    RenderStage named;
    named.shot.camera = scene.cameras[0].name;
    add("render", run, scene, RenderStage(), all);
    add("render a camera", run, scene, named, all);
    return all;
  }

  /// Names of keys that are not what they were before `change`.
  static Names changed_by(const std::function<void()>& change) {
    const Keys before = keys();
    change();
    const Keys after = keys();
    Names changed;
    for (const auto& [name, key] : before)
      if (after.at(name) != key) changed.insert(name);
    return changed;
  }
  Names changed_by_setting(const std::string& pointer, const json& value) {
    const json before = settings_;
    const Names changed = changed_by([&] {
      settings_[json::json_pointer(pointer)] = value;
      write_settings();
    });
    settings_ = before;
    write_settings();
    return changed;
  }

  json settings_, original_;
};

const Names kAll = {"reconstruct",
                    "reconstruct jointly",
                    "label",
                    "segment",
                    "segment automatically",
                    "segment a sphere",
                    "extract",
                    "repair",
                    "fill",
                    "predict",
                    "seed",
                    "fit",
                    "fit, camera found",
                    "fit to markers",
                    "simulate",
                    "simulate a start",
                    "render",
                    "render a camera"};
const Names kSegment = {"segment", "segment automatically", "segment a sphere"};
const Names kBody = {"fill", "predict", "seed"};
const Names kReconstruct = {"reconstruct", "reconstruct jointly"};
const Names kFit = {"fit", "fit, camera found", "fit to markers"};
const Names kSimulate = {"simulate", "simulate a start"};
const Names kRender = {"render", "render a camera"};

Names operator+(const Names& a, const Names& b) {
  Names both = a;
  both.insert(b.begin(), b.end());
  return both;
}

}  // namespace

// A field that no option sets cannot differ between two runs, unless it is listed here with what records it.
TEST(StageFields, BelongToAnOptionOrToSomethingElseThatIsRecorded) {
  const auto inpainter = [](const auto& stage, const LabelStage& label) {  // which is none of labels
    return std::vector<Bytes>{bytes_of(&stage, &label.models.inpainter, sizeof(label.models.inpainter))};
  };
  EXPECT_EQ(unknown_bytes<SegmentStage>([&](const SegmentStage& s) { return inpainter(s, s.label); }),
            std::vector<size_t>{});
  EXPECT_EQ(unknown_bytes<LabelStage>([&](const LabelStage& s) { return inpainter(s, s); }), std::vector<size_t>{});
  EXPECT_EQ(unknown_bytes<ExtractStage>([](const ExtractStage& s) {  // found.id, which it may decide
              return std::vector<Bytes>{bytes_of(&s, &s.label, sizeof(s.label))};
            }),
            std::vector<size_t>{});
  EXPECT_EQ(unknown_bytes<PredictStage>([](const PredictStage& s) {
              // Of the first it takes E, nu and rho, which are options; the second is found.known; where answers are
              // kept does not count.
              return std::vector<Bytes>{bytes_of(&s, &s.given, sizeof(s.given)),
                                        bytes_of(&s, &s.known, sizeof(s.known)),
                                        bytes_of(&s, &s.answers, sizeof(s.answers))};
            }),
            std::vector<size_t>{});
  EXPECT_EQ(unknown_bytes<SeedStage>([](const SeedStage&) { return std::vector<Bytes>{}; }), std::vector<size_t>{});
  EXPECT_EQ(unknown_bytes<SimulateStage>([](const SimulateStage& s) {  // what is said, of no effect on the motion
              return std::vector<Bytes>{bytes_of(&s, &s.expects_push, sizeof(s.expects_push))};
            }),
            std::vector<size_t>{});
  EXPECT_EQ(unknown_bytes<RenderStage>([](const RenderStage&) { return std::vector<Bytes>{}; }), std::vector<size_t>{});
  EXPECT_EQ(unknown_bytes<RepairStage>([](const RepairStage& s) {
              // Networks that it does not use.
              const ModelChoice& m = s.models;
              return std::vector<Bytes>{
                  bytes_of(&s, &m.detector, sizeof(m.detector)), bytes_of(&s, &m.tagger, sizeof(m.tagger)),
                  bytes_of(&s, &m.tracker, sizeof(m.tracker)), bytes_of(&s, &m.segmenter, sizeof(m.segmenter)),
                  bytes_of(&s, &m.vocabularies, sizeof(m.vocabularies))};
            }),
            std::vector<size_t>{});
  EXPECT_EQ(unknown_bytes<FitStage>([](const FitStage& s) {
              // How options are written; which of the videos it is; law and constants are recorded as found.material.
              return std::vector<Bytes>{bytes_of(&s, &s.prefix, sizeof(s.prefix)),
                                        bytes_of(&s, &s.beside, sizeof(s.beside)),
                                        bytes_of(&s, &s.material.law, sizeof(s.material.law)),
                                        bytes_of(&s, &s.material.constants, sizeof(s.material.constants))};
            }),
            std::vector<size_t>{});
  EXPECT_EQ(unknown_bytes<ReconstructStage>([](const ReconstructStage& s) {
              // Constants of the training; files, which tell the level of the splats, and found.joint.
              return std::vector<Bytes>{
                  bytes_of(&s, &s.train, sizeof(s.train)),        bytes_of(&s, &s.photo, sizeof(s.photo)),
                  bytes_of(&s, &s.joint, sizeof(s.joint)),        bytes_of(&s, &s.masks, sizeof(s.masks)),
                  bytes_of(&s, &s.splats, sizeof(s.splats)),      bytes_of(&s, &s.level, sizeof(s.level)),
                  bytes_of(&s, &s.mask_zero, sizeof(s.mask_zero))};
            }),
            std::vector<size_t>{});
}

TEST_F(StageKeys, ValuesOfTheSceneFileChangeTheKeysOfTheStagesThatReadThem) {
  const auto expect = [&](const char* pointer, const json& value, const Names& wanted) {
    EXPECT_EQ(changed_by_setting(pointer, value), wanted) << pointer;
  };
  EXPECT_EQ(changed_by([] {}), Names());
  expect("/up", {0, 0.1, 1}, kSegment + Names{"extract"} + kBody + kFit + kSimulate + kRender);
  expect("/metres_per_unit", 2.5, Names{"predict", "seed"} + kFit + kSimulate + kRender);
  expect("/support", "ball", {"extract"});
  expect("/object", "table", {"extract"});
  expect("/pinned/0/box/5", 0.2, {"fill"});
  expect("/material/young", 12345, Names{"predict"} + kFit + kSimulate);
  expect("/material/poisson", 0.123, Names{"predict"} + kFit + kSimulate);
  expect("/material/density", 123, Names{"predict"} + kFit + kSimulate);
  expect("/material/law", "neo_hookean", Names{"predict"} + kFit + kSimulate);
  expect("/material/constants", {{"viscosity_time", 0.01}}, Names{"predict"} + kFit + kSimulate);
  expect("/video/fps", 2 * fps, {"fit", "fit, camera found"});
  fs::copy_file(folder / "scene/reference.mp4", folder / "swing.mp4", fs::copy_options::overwrite_existing);
  expect("/video/file", (folder / "swing.mp4").string(), {});  // a copy
  const Names drawing = kSegment + Names{"extract", "repair", "fill", "fit", "fit, camera found"} + kRender;
  expect("/background", {1, 1, 1}, drawing + kReconstruct);
  expect("/background", {0, 0, 0}, kReconstruct);  // where it is not random behind photos with alpha then
  expect("/antialiased", true, drawing);
  expect("/video/camera", camera == "view_001" ? "view_002" : "view_001",
         {"fit", "fit, camera found", "simulate", "render"});
}

TEST_F(StageKeys, FilesOfTheSceneChangeTheKeysOfTheStagesThatReadThem) {
  const fs::path scene = folder / "scene";
  const auto expect = [&](const std::string& name, const std::function<void()>& change, const Names& wanted) {
    fs::remove_all(folder / "kept");
    fs::copy(scene, folder / "kept", fs::copy_options::recursive);
    EXPECT_EQ(changed_by(change), wanted) << name;
    fs::remove_all(scene);
    fs::rename(folder / "kept", scene);
  };
  const auto append = [&](const fs::path& file) { write_text(file, read_text(file) + "\n"); };
  expect(
      "splats",
      [&] {
        GaussianCloud cloud = read_ply(scene / "splats.ply");
        cloud.opacity_logit[5] += 1;
        write_ply(scene / "splats.ply", cloud);
      },
      kSegment + Names{"extract", "fit, camera found"});
  expect(
      "cameras",
      [&] {
        std::vector<Camera> cameras = read_cameras(scene / "transforms.json").cameras;
        cameras[2].cam_from_world.translation().x() += 0.01;
        write_cameras(scene / "transforms.json", cameras);
      },
      kReconstruct + Names{"label"} + kSegment + Names{"repair", "fill", "fit", "fit, camera found", "simulate"} +
          kRender);
  expect(
      "a photo",
      [&] {
        const fs::path photo = fs::directory_iterator(scene / "photos")->path();
        ImageF image = read_image(photo);
        image(3, 3, 0) = 1 - image(3, 3, 0);
        write_image(photo, image);
      },
      kReconstruct + Names{"label"} + kSegment);
  expect(
      "a mask",
      [&] {
        const fs::path mask = fs::directory_iterator(scene / "masks")->path();
        IdImage ids = read_ids(mask);
        ids(3, 3) = 77;
        write_ids(mask, ids);
      },
      kReconstruct + Names{"segment"});
  expect("names of labels",
         [&] {
           json names = json::parse(read_text(scene / "labels.json"));
           names.begin().value() = "another name";
           write_text(scene / "labels.json", names.dump());
         },
         {"reconstruct jointly", "segment"});
  expect("the video", [&] { append(scene / "reference.mp4"); }, {"fit", "fit, camera found"});
}

TEST_F(StageKeys, FilesOfTheRunChangeTheKeysOfTheStagesThatReadThem) {
  const fs::path run = folder / "run", object = fs::directory_iterator(run / "objects")->path();
  const auto expect = [&](const fs::path& file, const Names& wanted) {
    const std::string before = read_text(file);
    EXPECT_EQ(changed_by([&] { write_text(file, before + "\n"); }), wanted) << file;
    write_text(file, before);
  };
  expect(object / "object.ply",
         kBody + Names{"repair", "fit", "fit, camera found", "simulate", "render", "render a camera"});
  // They show the hole until it is repaired.
  expect(run / "background.ply", Names{"repair", "fit", "fit, camera found"} + kRender);
  expect(run / "background_repaired.ply", Names{"fit", "fit, camera found"} + kRender);
  expect(object / "solid.h5", {"predict", "seed"});
  expect(object / "particles.h5", kFit + kSimulate + kRender);
  expect(object / "trajectory.h5", kRender);
  expect(folder / "markers.csv", {"fit to markers", "simulate a start"});
  // What extract found reaches later stages by value.
  const auto found = [&](const std::string& pointer, const json& value) {
    json record = json::parse(read_text(run / "run.json"));
    const std::string before = record.dump();
    const Names changed = changed_by([&] {
      record[json::json_pointer(pointer)] = value;
      write_text(run / "run.json", record.dump());
    });
    write_text(run / "run.json", before);
    return changed;
  };
  EXPECT_EQ(found("/stages/extract/summary/height", 0.123), kSimulate);
  EXPECT_EQ(found("/stages/extract/summary/contact", {{"support", "shelf"}}), Names{"fill"} + kSimulate);
  EXPECT_EQ(found("/stages/extract/summary/rules", json::object()), Names());
}

TEST_F(StageKeys, EachFileOfTheSplatsThatJointTrainingGoesOnFromCounts) {
  const PhotoSet set = find_photo_set(folder / "scene", "");
  const CameraFile cameras = read_photo_cameras(set);
  ReconstructStage joint;
  joint.joint = true;
  joint.splats = {folder / "sog/lod-meta.json", folder / "sog/0_0/meta.json", folder / "sog/0_0/means_l.webp"};
  for (const fs::path& file : joint.splats) write_text(file, "before");
  const auto key = [&] { return record_of(key_of(inputs_of(set, cameras, joint)), 1); };
  const json before = key();
  for (const char* role : {"splats", "splats 0_0/meta.json", "splats 0_0/means_l.webp"})
    EXPECT_TRUE(before["inputs"].contains(role)) << role;
  for (const fs::path& file : joint.splats) {
    write_text(file, "after");
    EXPECT_NE(key(), before) << file;
    write_text(file, "before");
  }
  EXPECT_EQ(key(), before);
  fs::remove_all(folder / "sog");
}

TEST_F(StageKeys, TheSeedChangesAllOfThem) {
  const RunDirectory run = RunDirectory::open(folder / "run");
  const StageKey key = key_of(inputs_of(run, load_run_scene(run), SeedStage()));
  EXPECT_EQ(first_difference(record_of(key, 1), record_of(key, 2)), "option 'seed' was 1, now 2");
  EXPECT_EQ(keys().size(), kAll.size());
}

}  // namespace pliant
