// Which videos a fit takes, by the way that the command goes: cameras that are named, given in a file or found; videos that
// another program makes; and what is refused with a reason.

#include <gtest/gtest.h>
#include <unistd.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <atomic>
#include <map>
#include <numeric>
#include <nlohmann/json.hpp>

#include "app/demo/demo.h"
#include "app/pipeline/fit_scene.h"
#include "app/pipeline/fit_video.h"
#include "app/store/fit_checkpoint.h"
#include "app/store/material.h"
#include "app/store/particles.h"
#include "app/store/segmentation.h"
#include "app/store/velocity.h"
#include "fitting/fields/triplane_field.h"
#include "fitting/fit/frame_source.h"
#include "gaussians/io/cameras.h"
#include "gaussians/io/files.h"
#include "gaussians/io/image_io.h"
#include "gaussians/io/ply.h"
#include "gaussians/io/video.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class FitVideo : public ::testing::Test {
 protected:
  /// A demo scene and a run of it up to `seed`, once for all tests of this build of the program.
  static void prepare(const fs::path& prepared) {
    // Another test may prepare, and clear, at the same time.
    std::error_code taken;
    fs::create_directories(prepared.parent_path());
    std::vector<fs::path> older;
    for (fs::directory_iterator entry(prepared.parent_path(), taken), end; entry != end; entry.increment(taken)) older.push_back(entry->path());
    for (const fs::path& path : older)
      if (path != prepared) fs::remove_all(path, taken);
    const fs::path partial = prepared.parent_path().string() + "_" + std::to_string(getpid());
    fs::remove_all(partial);
    DemoOptions demo;
    demo.training = 50;
    demo.out = partial / "scene", demo.gaussians = 9000, demo.photos = 8, demo.width = 240, demo.height = 180;
    demo.video_particles = 2500, demo.video_seconds = 1.25;
    make_demo(demo);
    fs::remove_all(partial / "scene/truth");
    const std::string out = (partial / "run").string();
    ASSERT_EQ(run_quietly({"segment", (partial / "scene").string(), "--out", out, "--segment-iterations", "60"}), 0);
    ASSERT_EQ(run_quietly({"extract", out}), 0);
    ASSERT_EQ(run_quietly({"repair", out}), 0);
    ASSERT_EQ(run_quietly({"seed", out, "--particles", "600"}), 0);
    write_text(partial / "place", partial.string());
    // Either's is as good.
    fs::rename(partial, prepared, taken);
    if (taken) fs::remove_all(partial);
  }

  static void SetUpTestSuite() {
    const fs::path program = fs::read_symlink("/proc/self/exe");
    const fs::path prepared = program.parent_path() / "fit_video_scene" / std::to_string(fs::last_write_time(program).time_since_epoch().count());
    if (!fs::exists(prepared)) prepare(prepared);
    folder = fs::temp_directory_path() / ("pliant_fit_video_" + std::to_string(getpid()));
    fs::remove_all(folder);
    fs::copy(prepared, folder, fs::copy_options::recursive);
    // The run directory names the scene that it was made from.
    std::string run = read_text(folder / "run/run.json");
    const std::string from = read_text(prepared / "place");
    for (size_t at = run.find(from); at != std::string::npos; at = run.find(from, at)) run.replace(at, from.size(), folder.string());
    write_text(folder / "run/run.json", run);
    const json video = json::parse(read_text(folder / "scene/scene.json"))["video"];
    file = folder / "scene" / video["file"].get<std::string>();
    camera = video["camera"].get<std::string>();
    const auto source = open_frames(file, 0);
    fps = source->fps();
    while (auto frame = source->next()) frames.push_back(frame->picture);
  }
  static void TearDownTestSuite() { fs::remove_all(folder), frames.clear(); }

  static std::string write(const std::string& name, const std::vector<ImageF>& pictures) {
    VideoWriter writer(folder / name, fps, pictures[0].width, pictures[0].height);
    for (const ImageF& picture : pictures) writer.write(picture);
    writer.close();
    return (folder / name).string();
  }
  static std::vector<std::string> fit(std::vector<std::string> more) {
    more.insert(more.begin(), {"fit", (folder / "run").string(), "--overwrite"});
    return more;
  }
  /// The command ends with 1 and says these words.
  static void expect_refused(std::vector<std::string> more, const std::vector<std::string>& words) {
    ::testing::internal::CaptureStderr();
    const int code = run_quietly(fit(std::move(more)));
    const std::string said = ::testing::internal::GetCapturedStderr();
    EXPECT_EQ(code, 1) << said;
    for (const std::string& word : words) EXPECT_NE(said.find(word), std::string::npos) << "'" << word << "' in: " << said;
    EXPECT_FALSE(fs::exists(folder / "run/fit/results.json"));
  }
  static ReferenceVideo load(const FitStage& stage) {
    Progress progress(true);
    const Context context{progress, [] { return false; }};
    const RunDirectory run = RunDirectory::open(folder / "run");
    return load_fit_video(context, run, load_run_scene(run), stage);
  }

  static fs::path folder, file;
  static std::string camera;
  static double fps;
  static std::vector<ImageF> frames;
};
fs::path FitVideo::folder, FitVideo::file;
std::string FitVideo::camera;
double FitVideo::fps = 0;
std::vector<ImageF> FitVideo::frames;

double degrees_between(const Camera& a, const Camera& b) {
  return 180 / M_PI * Eigen::AngleAxisd(a.cam_from_world.linear() * b.cam_from_world.linear().transpose().eval()).angle();
}

TEST_F(FitVideo, WhatTheObjectsMotionCannotExplainIsRefusedWithItsReason) {
  expect_refused({"--video-camera", camera == "view_001" ? "view_002" : "view_001"}, {"does not show the scene from camera"});
  expect_refused({"--video", write("still.mp4", std::vector<ImageF>(12, frames[0])), "--video-camera", camera}, {"still.mp4", "does not move"});
  std::vector<ImageF> cut = frames;
  for (size_t f = cut.size() / 2; f < cut.size(); ++f) std::reverse(cut[f].data.begin(), cut[f].data.end());
  expect_refused({"--video", write("cut.mp4", cut), "--video-camera", camera}, {"cut.mp4", "jumps at frame " + std::to_string(cut.size() / 2)});
  std::vector<ImageF> other = frames;
  for (ImageF& picture : other) std::reverse(picture.data.begin(), picture.data.end());
  const std::string other_file = write("other.mp4", other);
  expect_refused({"--video", other_file, "--video-camera", camera}, {"other.mp4", "check that the video is of this scene"});
  expect_refused({"--video", other_file, "--video-camera", "find"}, {"none of the 8 known cameras"});
  // The scene file tells another rate than the file.
  const std::string settings = read_text(folder / "scene/scene.json");
  json wrong = json::parse(settings);
  wrong["video"]["fps"] = 2 * fps;
  write_text(folder / "scene/scene.json", wrong.dump());
  expect_refused({}, {"frames per second", "grows with the square of the rate"});
  write_text(folder / "scene/scene.json", settings);
}

TEST_F(FitVideo, TheCameraComesFromAPoseFileOrIsFoundByTheFirstFrame) {
  FitStage stage;
  const Camera truth = load(stage).camera;
  EXPECT_EQ(truth.name, camera);
  Camera beside = truth;
  beside.name = "phone";
  beside.cam_from_world.linear() = Eigen::AngleAxisd(0.02, Vec3d::UnitY()).toRotationMatrix() * beside.cam_from_world.linear();
  write_cameras(folder / "pose/transforms.json", {beside});
  stage.pose = (folder / "pose/transforms.json").string();
  EXPECT_NEAR(degrees_between(load(stage).camera, beside), 0, 1e-3);
  stage.refine_camera = true;
  EXPECT_LT(degrees_between(load(stage).camera, truth), 0.3);
  FitStage search;
  search.camera = "find";
  const ReferenceVideo found = load(search);
  EXPECT_LT(degrees_between(found.camera, truth), 0.3);
  EXPECT_EQ(found.camera.name, camera + "_found");
  // What was found is a pose file.
  FitStage again;
  again.pose = (folder / "run/fit/transforms.json").string();
  EXPECT_LT(degrees_between(load(again).camera, found.camera), 1e-3);

  FitStage wrong = search;
  wrong.pose = stage.pose;
  expect_error(Failure::kUsage, {"--video-camera", "--video-pose"}, [&] { load(wrong); });
  wrong = FitStage();
  wrong.camera = "fnd";
  expect_error(Failure::kUsage, {"did you mean 'find'"}, [&] { load(wrong); });
  beside.photo = (folder / "scene/photos" / (camera == "view_001" ? "view_002.png" : "view_001.png")).string();
  write_cameras(folder / "pose/transforms.json", {beside, truth});
  wrong = FitStage();
  wrong.pose = stage.pose;
  expect_error(Failure::kUsage, {"2 cameras", "--video-camera"}, [&] { load(wrong); });
  write_text(folder / "pose/bad.json", "{}");
  wrong.pose = (folder / "pose/bad.json").string();
  EXPECT_THROW(load(wrong), Error);
}

TEST_F(FitVideo, APartOfTheFileIsTaken) {
  FitStage stage;
  stage.first = 5 / fps, stage.last = 14 / fps;
  const ReferenceVideo part = load(stage);
  EXPECT_EQ(part.frames.size(), 10u);
  EXPECT_NEAR(part.start, 5 / fps, 1e-6);
}

TEST_F(FitVideo, WhatAMaskLeavesDarkIsNotCompared) {
  Progress progress(true);
  const Context context{progress, [] { return false; }};
  const RunDirectory run = RunDirectory::open(folder / "run");
  const Scene scene = load_run_scene(run);
  FitStage stage;
  const FitScene whole = load_fit_scene(context, run, scene, stage);
  const int width = whole.moving.width, height = whole.moving.height;
  double middle = 0;
  for (const Eigen::Vector2d& x : whole.pixel) middle += x.x() / static_cast<double>(whole.pixel.size());
  const auto mask_from = [&](double left) {
    ImageF mask(width, height, 3);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int c = 0; c < 3; ++c) mask(x, y, c) = x >= left;
    return mask;
  };
  // One for all frames: no point begins, and no pixel counts, in its dark half.
  write_image(folder / "mask.png", mask_from(middle));
  stage.video_mask = (folder / "mask.png").string();
  const FitScene half = load_fit_scene(context, run, scene, stage);
  EXPECT_GT(half.pixel.size(), 20u);
  for (const Eigen::Vector2d& x : half.pixel) EXPECT_GE(x.x() + 1, middle);
  ImageF weight(width, height, 1, -1);
  weight.data.assign(weight.data.size(), 1.0f);
  leave_out(weight, half, 3);
  EXPECT_EQ(weight(static_cast<int>(middle) - 2, height / 2), 0);
  EXPECT_EQ(weight(static_cast<int>(middle) + 2, height / 2), 1);

  // One for every frame: what is dark from the fourth on is followed until then.
  fs::create_directories(folder / "masks");
  char name[32];
  for (size_t f = 0; f < frames.size(); ++f) std::snprintf(name, sizeof name, "%04zu.png", f), write_image(folder / "masks" / name, mask_from(f < 3 ? 0 : width));
  stage.video_mask = (folder / "masks").string();
  const FitScene some = load_fit_scene(context, run, scene, stage);
  EXPECT_EQ(some.pixel.size(), whole.pixel.size());
  const PointTracks tracks = follow_points(context, some);
  for (size_t f = 0; f < frames.size(); ++f) {
    const double seen = std::accumulate(tracks.weight[f].begin(), tracks.weight[f].end(), 0.0);
    EXPECT_EQ(seen > 0, f < 3) << f;
  }
  // Each video has its own.
  FitStage both;
  both.video = file.string(), both.camera = camera, both.video_mask = "none";
  both.further = {{file.string(), camera, (folder / "mask.png").string()}, {file.string(), camera, ""}};
  const FitScene three = load_fit_scene(context, run, scene, both);
  ASSERT_EQ(three.further.size(), 2u);
  EXPECT_EQ(three.pixel.size(), whole.pixel.size());
  EXPECT_EQ(three.further[0].pixel.size(), half.pixel.size());
  EXPECT_TRUE(three.compared.empty() && three.further[1].compared.empty());
  EXPECT_FALSE(is_compared(three.further[0], 3, middle - 2, height / 2));

  fs::remove(folder / "masks" / name);
  expect_error(Failure::kInput, {"masks", std::to_string(frames.size())}, [&] { load_fit_scene(context, run, scene, stage); });
  write_image(folder / "square.png", ImageF(64, 64, 3, 1.0f));
  const std::string square = (folder / "square.png").string();
  expect_refused({"--video", file.string(), "--camera", camera, "--video", file.string(), "--camera", camera, "--video-mask", "none", "--video-mask", square}, {"square.png", "64 x 64"});
  EXPECT_EQ(run_quietly(fit({"--video", file.string(), "--camera", camera, "--video-mask", "none", "--video-mask", square})), 2);
  EXPECT_EQ(run_quietly(fit({"--video-mask", "nothing.png"})), 2);
}

TEST_F(FitVideo, FramesAreComparedAtTheRateThatIsAskedFor) {
  Progress progress(true);
  const Context context{progress, [] { return false; }};
  const RunDirectory run = RunDirectory::open(folder / "run");
  FitStage stage;
  stage.compare_fps = fps / 2;
  stage.video = file.string(), stage.camera = camera, stage.further = {{file.string(), camera, ""}};
  const FitScene scene = load_fit_scene(context, run, load_run_scene(run), stage);
  for (const FitView* view : scene.views()) {
    EXPECT_DOUBLE_EQ(view->video.fps, fps / 2);
    EXPECT_EQ(view->video.frames.size(), (frames.size() + 1) / 2);
    EXPECT_EQ(view->video.blended, 0);
    EXPECT_DOUBLE_EQ(view->video.source_fps, fps);
  }
  // Every second frame tells the same material.
  const auto fitted = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--points", "100"});
    EXPECT_EQ(run_quietly(fit(more)), 0);
    return json::parse(read_text(folder / "run/fit/results.json"));
  };
  const json all = fitted({}), half = fitted({"--compare-fps", std::to_string(fps / 2)});
  EXPECT_EQ(all["fps"], fps);
  EXPECT_EQ(half["fps"], fps / 2);
  EXPECT_EQ(all["frames_used"], frames.size());
  EXPECT_EQ(half["frames_used"], (frames.size() + 1) / 2);
  EXPECT_NEAR(half["young_pa"].get<double>() / all["young_pa"].get<double>(), 1, 0.04);
  // What a wrong rate would do to E is said with the numbers.
  const double young = half["young_pa"];
  const std::string said = half["undetermined"].dump();
  for (const std::string& words : {fmt::format("{:.4g} frames a second", fps), fmt::format("4 times as large, {:.3g} Pa", 4 * young), fmt::format("a quarter, {:.3g} Pa", young / 4)})
    EXPECT_NE(said.find(words), std::string::npos) << words << " in: " << said;
  // A folder of frames has no rate of its own.
  fs::create_directories(folder / "no_rate");
  for (int f = 0; f < 3; ++f) write_image(folder / "no_rate" / (std::to_string(f) + ".png"), frames[f]);
  fs::remove(folder / "run/fit/results.json");
  expect_refused({"--video", (folder / "no_rate").string(), "--camera", camera}, {"no_rate", "has no frame rate", "--video-fps"});
}

TEST_F(FitVideo, AProgramMakesTheVideoThatIsFitted) {
  // It films what the scene's own video shows, whatever it is asked.
  fs::create_directories(folder / "film");
  char name[32];
  for (size_t f = 0; f < frames.size(); ++f) std::snprintf(name, sizeof name, "%04zu.png", f), write_image(folder / "film" / name, frames[f]);
  write_text(folder / "film.sh", "cp " + (folder / "film").string() + "/*.png \"$1/frames/\"\n");
  const std::string command = "sh " + (folder / "film.sh").string();
  ASSERT_EQ(run_quietly(fit({"--generate-with", command, "--generate-frames", std::to_string(frames.size()), "--generate-prompt", "it swings", "--video-camera",
                             camera, "--video-fps", std::to_string(fps)})),
            0);
  const json request = json::parse(read_text(folder / "run/fit/generated/request.json"));
  EXPECT_EQ(request["prompt"], "it swings");
  EXPECT_EQ(request["frames"], frames.size());
  const json result = json::parse(read_text(folder / "run/fit/results.json"));
  EXPECT_GT(result["young_pa"].get<double>(), 0);
  EXPECT_LT(result["rms_px"].get<double>(), 0.5 * result["rms_still_px"].get<double>());
  EXPECT_GE(result["undetermined"].size(), 3u);
  for (const char* picture : {"slices.png", "search.png", "loss.png", "young.png", "uncertainty.png", "report.html"})
    EXPECT_TRUE(fs::exists(folder / "run/fit" / picture)) << picture;
  EXPECT_NE(read_text(folder / "run/fit/report.html").find("does not determine"), std::string::npos);
  EXPECT_EQ(run_quietly(fit({"--generate-with", "exit 3;", "--video-camera", camera})), 1);
  EXPECT_EQ(run_quietly(fit({"--generate-with", command, "--video", file.string()})), 2);
}

TEST_F(FitVideo, PartsAreThoseOfGivenLabels) {
  const GaussianCloud cloud = read_ply(folder / "scene/splats.ply");
  // Labels of another scene, and labels that tell nothing apart.
  fs::remove(folder / "run/fit/results.json");
  LabelFile wrong{std::vector<uint32_t>(cloud.size(), 3), {}};
  write_labels(folder / "same.h5", wrong, "{}");
  expect_refused({"--field", "parts", "--part-labels", (folder / "same.h5").string()}, {"same on everything", "uniform"});
  wrong.label.pop_back();
  write_labels(folder / "few.h5", wrong, "{}");
  expect_refused({"--field", "parts", "--part-labels", (folder / "few.h5").string()}, {"few.h5", std::to_string(cloud.size())});

  LabelFile labels;
  for (const Vec3f& x : cloud.position) labels.label.push_back(x.z() > 0.22f ? 7 : 3);  // of a flower of 0.32 m
  write_labels(folder / "halves.h5", labels, "{}");
  ASSERT_EQ(run_quietly(fit({"--field", "parts", "--part-labels", (folder / "halves.h5").string(), "--until", "0.9", "--points", "100"})), 0);
  const fs::path object = fs::directory_iterator(folder / "run/objects")->path();
  const MaterialFile material = read_material(object / "material.h5");
  std::map<long, double> mean_height;  // of the samples of each stiffness, but for rounding
  std::map<long, size_t> count;
  const ParticleFile particles = read_particles(object / "particles.h5");
  for (size_t s = 0; s < material.young.size(); ++s)
    if (particles.solid_driver[s] >= 0) {
      const long stiffness = std::lround(1e3 * std::log(material.young[s]));
      mean_height[stiffness] += particles.solid_position[s].z(), ++count[stiffness];
    }
  ASSERT_EQ(count.size(), 2u);
  const double first = mean_height.begin()->second / count.begin()->second, second = mean_height.rbegin()->second / count.rbegin()->second;
  EXPECT_GT(std::abs(first - second), 0.03);
  const json steps = json::parse(read_text(folder / "run/fit/results.json"))["steps"];
  ASSERT_EQ(steps.size(), 3u);
  EXPECT_EQ(steps[2]["name"], "field");
  EXPECT_FALSE(steps[2]["stopped_by"].get<std::string>().empty());
  EXPECT_LE(steps[2]["loss"].back().get<double>(), steps[2]["loss"].front().get<double>());
  EXPECT_NE(read_text(folder / "run/fit/report.html").find("ended by"), std::string::npos);
}

TEST_F(FitVideo, SmoothFieldsAndTriplanesAreFittedByTheCommand) {
  // Few particles and frames: what is looked at is that each kind comes out whole.
  fs::copy(folder / "run", folder / "small", fs::copy_options::recursive);
  const std::string out = (folder / "small").string();
  ASSERT_EQ(run_quietly({"seed", out, "--particles", "200", "--overwrite"}), 0);
  const auto fitted = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"fit", out, "--overwrite", "--points", "60", "--video-last", "0.9", "--compare-fps", "12"});
    EXPECT_EQ(run_quietly(more), 0);
    return json::parse(read_text(folder / "small/fit/results.json"));
  };
  const fs::path object = fs::directory_iterator(folder / "small/objects")->path();
  const size_t samples = read_particles(object / "particles.h5").solid_position.size();
  const json smooth = fitted({"--field", "smooth"});
  const MaterialFile uneven = read_material(object / "material.h5");
  EXPECT_EQ(uneven.source.substr(0, 14), "a smooth field");
  const auto [least, most] = std::minmax_element(uneven.young.begin(), uneven.young.end());
  EXPECT_GT(*most, 1.05f * *least);
  EXPECT_GT(*least, 0);
  // How sure each sample's E is goes with it.
  ASSERT_EQ(uneven.log10_young_sigma.size(), samples);
  for (const float sigma : uneven.log10_young_sigma) EXPECT_TRUE(std::isfinite(sigma) && sigma > 0);
  ASSERT_EQ(smooth["steps"].size(), 3u);
  EXPECT_EQ(smooth["steps"][2]["name"], "field");
  EXPECT_LE(smooth["steps"][2]["loss"].back().get<double>(), smooth["steps"][2]["loss"].front().get<double>());
  EXPECT_LT(smooth["rms_px"].get<double>(), 0.3 * smooth["rms_still_px"].get<double>());

  if (!has_triplane_fields()) GTEST_SKIP() << "the rest needs triplanes, and this is built without libtorch";
  const json planes = fitted({"--field", "triplanes", "--gradient-iterations", "4"});
  const MaterialFile material = read_material(object / "material.h5");
  EXPECT_EQ(material.source.substr(0, 9), "triplanes");
  ASSERT_EQ(material.young.size(), samples);
  ASSERT_EQ(material.log10_young_sigma.size(), samples);
  for (const float sigma : material.log10_young_sigma) EXPECT_TRUE(std::isfinite(sigma) && sigma > 0);
  ASSERT_EQ(planes["iterations"].size(), 4u);
  EXPECT_GT(planes["iterations"][3]["field_s"].get<double>(), 0);
  ASSERT_EQ(planes["steps"].size(), 4u);
  EXPECT_EQ(planes["steps"][3]["name"], "gradients");
  EXPECT_LT(planes["rms_px"].get<double>(), 0.3 * planes["rms_still_px"].get<double>());
  EXPECT_NE(planes["undetermined"].dump().find("The uncertainty of E is what the followed points leave open"), std::string::npos);
  const VelocityFile start = read_velocity(object / "velocity.h5");
  EXPECT_EQ(start.velocity.size(), 200u);
  for (const Vec3f& v : start.velocity) EXPECT_TRUE(v.allFinite());
}

TEST_F(FitVideo, GradientsComparePicturesAndFlowOfSeveralCamerasBesideTracks) {
  const std::vector<std::string> twice = {"--video", file.string(), "--camera", camera, "--video", file.string(), "--camera", camera, "--video-fps", std::to_string(fps)};
  std::vector<std::string> more = twice;
  for (const char* word : {"--loss", "both", "--loss-lambda", "0.2", "--flow-weight", "0.5", "--gradient-window", "4", "--gradient-iterations", "6", "--fit-poisson", "--until", "0.9"}) more.push_back(word);
  ASSERT_EQ(run_quietly(fit(more)), 0);
  const json result = json::parse(read_text(folder / "run/fit/results.json"));
  ASSERT_EQ(result["iterations"].size(), 6u);  // the last three of them over all frames
  EXPECT_EQ(result["iterations"][3]["frames"], result["iterations"][5]["frames"]);
  // They begin where the tracks were explained best, and stay near it.
  EXPECT_LT(result["iterations"][5]["loss"].get<double>(), 1.02 * result["iterations"][3]["loss"].get<double>());
  EXPECT_LT(result["rms_px"].get<double>(), 1.1 * result["rms_homogeneous_px"].get<double>());
  EXPECT_GT(result["poisson"].get<double>(), 0);
  EXPECT_LT(result["poisson"].get<double>(), 0.49);
  EXPECT_NE(result["poisson"].get<double>(), 0.3);
  EXPECT_GT(result["log10_sigma"].get<double>(), 0);
  EXPECT_TRUE(fs::exists(folder / "run/fit/uncertainty.png"));
  EXPECT_LT(result["rms_px"].get<double>(), 0.5 * result["rms_still_px"].get<double>());
  // A camera without a video, and terms without a video to compare.
  EXPECT_EQ(run_quietly(fit({"--video", file.string(), "--camera", camera, "--camera", camera})), 2);
  EXPECT_EQ(run_quietly(fit({"--loss", "nothing"})), 2);
}

TEST_F(FitVideo, PhysDreamersRecipeGoesFromTheStiffnessThatIsGiven) {
  const std::vector<std::string> recipe = {"--recipe", "physdreamer", "--from", "0.5", "--until", "0.9", "--points", "100", "--gradient-iterations", "8", "--young", "20000", "--poisson", "0.3", "--density", "300"};
  ASSERT_EQ(run_quietly(fit(recipe)), 0);
  const json result = json::parse(read_text(folder / "run/fit/results.json"));
  ASSERT_EQ(result["steps"].size(), 2u);
  for (const json& step : result["steps"]) {
    EXPECT_EQ(step["loss"].size(), 8u);
    EXPECT_FALSE(step["stopped_by"].get<std::string>().empty());
  }
  EXPECT_EQ(result["steps"][0]["name"], "velocity");
  EXPECT_LT(result["steps"][0]["loss"][7], result["steps"][0]["loss"][0]);
  EXPECT_EQ(result["steps"][1]["name"], "material");
  EXPECT_TRUE(result["search"].empty());
  EXPECT_EQ(result["first_frame"].get<int>(), std::lround(0.5 * fps));
  EXPECT_EQ(result["damping_time_s"], 0);
  EXPECT_NE(result["young_pa"], 20000);
  EXPECT_NEAR(std::log(result["young_pa"].get<double>() / 20000), 0, 0.3);  // 8 steps of at most 0.03
  const fs::path object = fs::directory_iterator(folder / "run/objects")->path();
  EXPECT_NEAR(read_material(object / "material.h5").young.front() / result["young_pa"].get<double>(), 1, 1e-5);
  EXPECT_NE(read_text(folder / "run/fit/report.html").find("not searched"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder / "run/fit/search.png"));
  for (const char* picture : {"loss.png", "young.png", "uncertainty.png"}) EXPECT_TRUE(fs::exists(folder / "run/fit" / picture)) << picture;
  EXPECT_EQ(read_material(object / "material.h5").log10_young_sigma.size(), read_material(object / "material.h5").young.size());
}

TEST_F(FitVideo, InterruptedBetweenStepsOfGaussNewtonItEndsWithTheSameFiles) {
  Progress progress(true);
  std::atomic<int> asked = 0;
  int most = std::numeric_limits<int>::max();
  Context context{progress, [&] { return ++asked > most; }};
  RunDirectory run = RunDirectory::open(folder / "run");
  const Scene scene = load_run_scene(run);
  FitStage stage;
  stage.until = 0.9, stage.points = 60;
  const auto fit_up_to = [&](int calls) {
    asked = 0, most = calls;
    run_fit(context, run, scene, stage);
  };
  const auto files = [&] {
    const fs::path object = fs::directory_iterator(folder / "run/objects")->path();
    return read_text(object / "material.h5") + read_text(object / "velocity.h5");
  };
  context.overwrite = true;
  fs::remove(folder / "run/fit/results.json");
  fit_up_to(most);
  const std::string whole = files();
  const int all = asked;
  context.overwrite = false;
  const fs::path checkpoint = folder / "run/fit/checkpoint.h5";
  EXPECT_FALSE(fs::exists(checkpoint));

  fs::remove(folder / "run/fit/results.json");
  expect_error(Failure::kInterrupted, {}, [&] { fit_up_to(3 * all / 4); });
  const FitCheckpoint kept = read_fit_checkpoint(checkpoint);
  EXPECT_FALSE(kept.homogeneous);
  EXPECT_FALSE(kept.vibration.refinements.empty());
  fit_up_to(std::numeric_limits<int>::max());
  EXPECT_EQ(files(), whole);
  EXPECT_LT(asked.load(), all);
}

TEST_F(FitVideo, WithoutAVideoAProgramThatLikesStillnessGuidesTheMaterial) {
  // Derivatives of half the squared distance from the first frame: the more a motion is damped, the less it moves.
  if (system("command -v python3 > /dev/null") != 0) GTEST_SKIP() << "python3 is not installed";
  write_text(folder / "still.py", R"(
import array, json, os, sys
print(json.dumps({'ready': 1, 'name': 'stillness'}), flush=True)
for line in sys.stdin:
    request = json.loads(line)
    if 'quit' in request: break
    steps = sys.argv[1] + '/steps.txt'
    died = os.path.exists(steps) and '6' in open(steps).read()
    open(steps, 'a').write('%d ' % request['step'])
    if request['step'] == 6 and not died: sys.exit('no memory')
    frames = array.array('f'); frames.frombytes(open(sys.argv[1] + '/frames.f32', 'rb').read())
    size = len(frames) // request['shape'][0]
    pull = array.array('f', [frames[i] - frames[i % size] for i in range(len(frames))])
    pull.tofile(open(sys.argv[1] + '/gradient.f32', 'wb'))
    print(json.dumps({'step': request['step'], 'loss': 0.5 * sum(p * p for p in pull)}), flush=True)
)");
  const std::string settings = read_text(folder / "scene/scene.json");
  json silent = json::parse(settings);
  silent.erase("video");
  write_text(folder / "scene/scene.json", silent.dump());
  const std::vector<std::string> guided = fit({"--guide-with", "python3 " + (folder / "still.py").string(), "--guide-frames", "8", "--gradient-iterations", "8", "--camera", camera});
  const int died = run_quietly(guided), code = run_quietly(guided);
  const json result = code == 0 ? json::parse(read_text(folder / "run/fit/results.json")) : json();
  const int refused = run_quietly(fit({"--guide-with", "exit 3;", "--camera", camera})), wrong = run_quietly(fit({"--guide-with", "exit 3;", "--loss", "both"}));
  write_text(folder / "scene/scene.json", settings);
  EXPECT_EQ(died, 1);
  ASSERT_EQ(code, 0);
  EXPECT_EQ(read_text(folder / "run/fit/guide/steps.txt"), "0 1 2 3 4 5 6 6 7 ");
  EXPECT_LT(result["damping_time_s"].get<double>(), 0.95);
  EXPECT_NE(result["young_pa"], result["young_before_pa"]);
  EXPECT_LT(result["loss_last"].get<double>(), result["loss_first"].get<double>());
  EXPECT_EQ(result["guide"], "stillness");
  EXPECT_EQ(refused, 1);
  EXPECT_EQ(wrong, 2);
}

}  // namespace
}  // namespace pliant
