// What a fit to a video may vary, and how, by the way that the command goes: fields of stiffness, gradients,
// PhysDreamer's recipe, a program that judges; and a fit that is interrupted.

#include <fmt/format.h>

#include <atomic>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "app/fit/fit_options.h"
#include "app/fit/fit_scene.h"
#include "app/run/attach_scene.h"
#include "app/simulate/simulate_stage.h"
#include "app/store/fit_checkpoint.h"
#include "app/store/material.h"
#include "app/store/particles.h"
#include "app/store/segmentation.h"
#include "app/store/trajectory.h"
#include "app/store/velocity.h"
#include "fitting/fields/triplane_field.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/fit_of_few_particles.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

TEST_F(FitVideo, TouchingPartsRubInAFitAsWhereItIsReplayed) {
  Progress progress(true);
  const RunDirectory run = RunDirectory::open(folder / "run");
  const Context context{progress, [] { return false; }};
  const FitInputs in = inputs_of(run, load_run_scene(run), FitStage());
  const FitScene fit = load_fit_scene(context, run, in);
  const double friction = SimulateStage().contact_friction;
  EXPECT_EQ(rollout_options(in.options).object_friction, friction);
  const MaterialFitOptions options = material_fit_options(context, run, in.scene, in.options, fit, 0);
  EXPECT_EQ(options.vibration.simulate.object_friction, friction);
}

TEST_F(FitVideo, NetworksBeginByTheSeedOfTheProgram) {
  Progress progress(true);
  const RunDirectory run = RunDirectory::open(folder / "run");
  FitStage stage;
  stage.field = "kan";
  const FitInputs in = inputs_of(run, load_run_scene(run), stage);
  Context context{progress, [] { return false; }};
  const FitScene fit = load_fit_scene(context, run, in);
  const auto seeds = [&] {
    const MaterialFitOptions options = material_fit_options(context, run, in.scene, in.options, fit, 0);
    return std::set<uint64_t>{options.kan.seed, options.planes.seed};
  };
  EXPECT_EQ(seeds(), std::set<uint64_t>{0}) << "of the default";
  context.seed = 8;
  EXPECT_EQ(seeds(), std::set<uint64_t>{7});
}

TEST_F(FitVideo, PartsAreThoseOfGivenLabels) {
  const GaussianCloud cloud = read_ply(folder / "scene/splats.ply");
  // Labels of another scene, and labels that tell nothing apart.
  LabelFile wrong{std::vector<uint32_t>(cloud.size(), 3), {}};
  write_labels(folder / "same.h5", wrong, "{}");
  expect_refused({"--field", "parts", "--part-labels", (folder / "same.h5").string()},
                 {"same for all moving Gaussians", "uniform"});
  wrong.label.pop_back();
  write_labels(folder / "few.h5", wrong, "{}");
  expect_refused({"--field", "parts", "--part-labels", (folder / "few.h5").string()},
                 {"few.h5", std::to_string(cloud.size())});

  LabelFile labels;
  for (const Vec3f& x : cloud.position)
    labels.label.push_back(x.z() > 0.16f ? 7 : 3);  // of a flower of 0.32 m, where its motion tells the two apart
  write_labels(folder / "halves.h5", labels, "{}");
  ASSERT_EQ(run_quietly({"seed", (folder / "run").string(), "--particles", "700"}), 0);
  ASSERT_EQ(run_quietly(fit({"--field", "parts", "--part-labels", (folder / "halves.h5").string(), "--end", "0.9",
                             "--points", "100"})),
            0);
  const fs::path object = fs::directory_iterator(folder / "run/objects")->path();
  const MaterialFile material = read_material(object / "material.h5");
  std::map<long, double> mean_height;  // of the samples of each stiffness, but for rounding
  std::map<long, size_t> count;
  const ParticleFile particles = read_particles(object / "particles.h5");
  for (size_t s = 0; s < material.young.size(); ++s)
    if (particles.solid_driver[s] >= 0) {
      const long stiffness = std::lround(1e3 * std::log(material.young[s]));
      mean_height[stiffness] += particles.solid_position[s].z();
      ++count[stiffness];
    }
  ASSERT_EQ(count.size(), 2u);
  const double first = mean_height.begin()->second / count.begin()->second,
               second = mean_height.rbegin()->second / count.rbegin()->second;
  EXPECT_GT(std::abs(first - second), 0.03);
  const json steps = json::parse(read_text(folder / "run/fit/results.json"))["steps"];
  ASSERT_EQ(steps.size(), 3u);
  EXPECT_EQ(steps[2]["name"], "field");
  EXPECT_FALSE(steps[2]["stopped_by"].get<std::string>().empty());
  EXPECT_LE(steps[2]["loss"].back().get<double>(), steps[2]["loss"].front().get<double>());
  EXPECT_NE(read_text(folder / "run/fit/report.html").find("stopped by"), std::string::npos);
}

TEST_F(FitOfFewParticles, SmoothFieldsAreFittedByTheCommand) {
  const json smooth = fitted({"--field", "smooth"});
  const MaterialFile uneven = read_material(object / "material.h5");
  EXPECT_EQ(uneven.source.substr(0, 14), "a smooth field");
  const auto [least, most] = std::minmax_element(uneven.young.begin(), uneven.young.end());
  EXPECT_GT(*most, 1.05f * *least);
  EXPECT_GT(*least, 0);
  expect_sigmas(uneven);
  ASSERT_EQ(smooth["steps"].size(), 3u);
  EXPECT_EQ(smooth["steps"][2]["name"], "field");
  EXPECT_LE(smooth["steps"][2]["loss"].back().get<double>(), smooth["steps"][2]["loss"].front().get<double>());
  EXPECT_LT(smooth["rms_px"].get<double>(), 0.3 * smooth["rms_still_px"].get<double>());
}

TEST_F(FitOfFewParticles, AKanIsFittedByTheCommand) {
  const json fit = fitted({"--field", "kan", "--gradient-iterations", "4"});
  const MaterialFile material = read_material(object / "material.h5");
  EXPECT_EQ(material.source, "a KAN, fitted to the reference video");
  expect_sigmas(material);
  ASSERT_EQ(fit["iterations"].size(), 4u);
  EXPECT_LT(fit["rms_px"].get<double>(), 0.3 * fit["rms_still_px"].get<double>());
}

TEST_F(FitOfFewParticles, DensityAndPoissonsRatioOfPartsAreFittedByTheCommand) {
  const json found =
      fitted({"--field", "parts", "--parts", "2", "--fit-poisson", "--fit-density", "--gradient-iterations", "14"});
  const ParticleFile particles = read_particles(object / "particles.h5");
  const MaterialFile material = read_material(object / "material.h5");
  const double given = json::parse(read_text(folder / "scene/scene.json"))["material"]["density"];
  double before = 0, after = 0;
  std::set<long> densities;
  for (size_t s = 0; s < material.density.size(); ++s) {
    if (particles.solid_driver[s] < 0) continue;
    densities.insert(std::lround(1e4 * std::log(material.density[s])));
    after += material.density[s] * particles.solid_volume[s];
    before += given * particles.solid_volume[s];
  }
  EXPECT_EQ(densities.size(), 2u);
  EXPECT_NEAR(after, before, 1e-4 * before);
  const json range = found["density_range_kg_m3"], ratios = found["poisson_range"];
  ASSERT_EQ(range.size(), 2u) << found.dump(2);
  EXPECT_LT(range[0].get<double>(), given);
  EXPECT_GT(range[1].get<double>(), given);
  EXPECT_GT(ratios[0].get<double>(), 0);
  EXPECT_LT(ratios[0].get<double>(), ratios[1].get<double>());
  EXPECT_NE(found["undetermined"].dump().find("total mass"), std::string::npos);
}

TEST_F(FitOfFewParticles, TriplanesAreFittedByTheCommand) {
  if (!has_triplane_fields()) GTEST_SKIP() << "triplanes need libtorch, and this is built without";
  const json planes = fitted({"--field", "triplanes", "--gradient-iterations", "4"});
  const MaterialFile material = read_material(object / "material.h5");
  EXPECT_EQ(material.source.substr(0, 9), "triplanes");
  expect_sigmas(material);
  ASSERT_EQ(planes["iterations"].size(), 4u);
  EXPECT_GT(planes["iterations"][3]["field_s"].get<double>(), 0);
  ASSERT_EQ(planes["steps"].size(), 4u);
  EXPECT_EQ(planes["steps"][3]["name"], "gradients");
  EXPECT_LT(planes["rms_px"].get<double>(), 0.3 * planes["rms_still_px"].get<double>());
  EXPECT_NE(planes["undetermined"].dump().find("The uncertainty of E reflects only the tracked points"),
            std::string::npos);
  const VelocityFile start = read_velocity(object / "velocity.h5");
  EXPECT_EQ(start.velocity.size(), read_particles(object / "particles.h5").driving_position.size());
  EXPECT_GE(start.velocity.size(), 200u);
  for (const Vec3f& v : start.velocity) EXPECT_TRUE(v.allFinite());
}

TEST_F(FitVideo, GradientsComparePicturesAndFlowOfSeveralCamerasBesideTracks) {
  const std::vector<std::string> twice = {"--video",     file.string(),      "--video-camera", camera,
                                          "--video",     file.string(),      "--video-camera", camera,
                                          "--video-fps", std::to_string(fps)};
  std::vector<std::string> more = twice;
  for (const char* word : {"--loss", "both", "--loss-lambda", "0.2", "--flow-weight", "0.5", "--gradient-window", "4",
                           "--gradient-iterations", "6", "--fit-poisson", "--end", "0.9"})
    more.push_back(word);
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
  EXPECT_EQ(run_quietly(fit({"--video", file.string(), "--video-camera", camera, "--video-camera", camera})), 2);
  EXPECT_EQ(run_quietly(fit({"--loss", "nothing"})), 2);
}

TEST_F(FitVideo, LawsThatFlowAreNotSearchedByVibrationModes) {
  const RunDirectory run = RunDirectory::open(folder / "run");
  Scene scene = load_run_scene(run);
  FitStage stage;
  for (const char* elastic : {"neo_hookean", "fixed_corotated", "hencky"}) {
    scene.settings.material.law = elastic;
    EXPECT_NO_THROW(inputs_of(run, scene, stage)) << elastic;
  }
  for (const char* flowing : {"sand", "fluid", "metal"}) {
    scene.settings.material.law = flowing;
    if (flowing == std::string("metal")) scene.settings.material.constants["yield_stress"] = 100;
    stage.recipe = "search";
    expect_error(Failure::kUsage, {flowing, "--recipe physdreamer"}, [&] { inputs_of(run, scene, stage); });
    stage.recipe = "physdreamer";
    EXPECT_NO_THROW(inputs_of(run, scene, stage)) << flowing;
  }
}

/// The command line of README.
TEST_F(FitVideo, PhysDreamersRecipeAloneIsThePublishedOne) {
  if (!has_triplane_fields()) GTEST_SKIP() << "the recipe needs triplanes, and this is built without libtorch";
  fs::copy(folder / "run", folder / "published", fs::copy_options::recursive);
  const std::string out = (folder / "published").string();
  ASSERT_EQ(run_quietly({"seed", out, "--particles", "300"}), 0);
  ASSERT_EQ(run_quietly({"fit", out, "--recipe", "physdreamer", "--start", "0.5", "--end", "0.8", "--points", "60",
                         "--gradient-iterations", "4", "--young", "20000", "--poisson", "0.3", "--density", "300"}),
            0);
  const json result = json::parse(read_text(folder / "published/fit/results.json")),
             options = json::parse(read_text(folder / "published/run.json"))["stages"]["fit"]["options"];
  EXPECT_EQ(options["field"], "triplanes");
  EXPECT_EQ(options["loss"], "image");
  EXPECT_EQ(options["image-weight"], 1);
  EXPECT_EQ(options["gradient-window"], 1);
  EXPECT_EQ(options["loss-lambda"], 0.1);
  ASSERT_EQ(result["steps"].size(), 2u);
  EXPECT_EQ(result["steps"][0]["name"], "velocity");
  EXPECT_EQ(result["steps"][1]["name"], "material");
  // The loss is that of images, which is at most 1, and not the squared error of tracks [px^2] beside it.
  for (const json& step : result["steps"])
    for (const json& loss : step["loss"]) EXPECT_TRUE(loss > 0 && loss < 0.5) << loss;
  const fs::path object = fs::directory_iterator(folder / "published/objects")->path();
  EXPECT_EQ(read_material(object / "material.h5").source.substr(0, 9), "triplanes");
}

TEST_F(FitVideo, PhysDreamersRecipeGoesFromTheStiffnessThatIsGiven) {
  const std::vector<std::string> recipe = {"--recipe",
                                           "physdreamer",
                                           "--field",
                                           "uniform",
                                           "--loss",
                                           "tracks",
                                           "--start",
                                           "0.5",
                                           "--end",
                                           "0.9",
                                           "--points",
                                           "100",
                                           "--gradient-iterations",
                                           "8",
                                           "--young",
                                           "20000",
                                           "--poisson",
                                           "0.3",
                                           "--density",
                                           "300"};
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
  for (const char* picture : {"loss.png", "young.png", "uncertainty.png"})
    EXPECT_TRUE(fs::exists(folder / "run/fit" / picture)) << picture;
  EXPECT_EQ(read_material(object / "material.h5").log10_young_sigma.size(),
            read_material(object / "material.h5").young.size());
}

TEST_F(FitVideo, InterruptedBetweenStepsOfGaussNewtonItEndsWithTheSameFiles) {
  Progress progress(true);
  std::atomic<int> asked = 0;
  int most = std::numeric_limits<int>::max();
  Context context{progress, [&] { return ++asked > most; }};
  RunDirectory run = RunDirectory::open(folder / "run");
  const Scene scene = load_run_scene(run);
  FitStage stage;
  stage.until = 0.9;
  stage.points = 60;
  const auto fit_up_to = [&](int calls) {
    asked = 0;
    most = calls;
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
  const std::vector<std::string> guided =
      fit({"--guidance-cmd", "python3 " + (folder / "still.py").string(), "--guidance-frames", "8",
           "--gradient-iterations", "8", "--video-camera", camera});
  const int died = run_quietly(guided), code = run_quietly(guided);
  const json result = code == 0 ? json::parse(read_text(folder / "run/fit/results.json")) : json();
  const int refused = run_quietly(fit({"--guidance-cmd", "exit 3;", "--video-camera", camera})),
            wrong = run_quietly(fit({"--guidance-cmd", "exit 3;", "--loss", "both"})),
            sought = run_quietly(fit({"--guidance-cmd", "exit 3;", "--video-camera", "find"})),
            second =
                run_quietly(fit({"--guidance-cmd", "exit 3;", "--video-camera", camera, "--video-camera", camera}));
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
  EXPECT_EQ(sought, 2) << "there is no first frame";
  EXPECT_EQ(second, 2) << "one clip is drawn";
}

TEST_F(FitVideo, TheCameraOfAVideoThatIsGeneratedIsNamedAndNotFound) {
  Camera known = load_run_scene(RunDirectory::open(folder / "run")).cameras[0];
  known.name = "front";
  known.photo.clear();
  write_cameras(folder / "pose.json", {known});
  const auto said_of = [&](const char* name) {
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(run_quietly(fit({"--video-model-cmd", "exit 3;", "--video-pose", (folder / "pose.json").string(),
                               "--video-camera", name})),
              2);
    return ::testing::internal::GetCapturedStderr();
  };
  EXPECT_NE(said_of("find").find("--video-camera find: does nothing with --video-model-cmd"), std::string::npos);
  EXPECT_NE(said_of("fin").find("did you mean 'front'"), std::string::npos);
}

TEST_F(FitOfFewParticles, Physics3dsRecipeGivesABranchThatIsSimulated) {
  const std::string guide = (folder / "likes.sh").string();
  write_text(guide, R"(cd "$1"; echo '{"ready": 1, "name": "copy"}'; step=0
while read line; do case "$line" in *quit*) exit 0;; esac
cp frames.f32 gradient.f32; echo "{\"step\": $step, \"loss\": 1}"; step=$((step + 1)); done)");
  const std::string run = (folder / "small").string();
  ASSERT_EQ(run_quietly({"fit", run, "--overwrite", "--recipe", "physics3d", "--guidance-cmd", "sh " + guide,
                         "--guidance-frames", "2", "--gradient-iterations", "2", "--video-camera", camera}),
            0);
  const MaterialFile material = read_material(object / "material.h5");
  ASSERT_EQ(material.branch.size(), material.young.size());
  EXPECT_EQ(material.source, "physics3d, guided by 'copy'");
  EXPECT_EQ(read_velocity(object / "velocity.h5").source, "at rest, guided by 'copy'");
  write_text(folder / "none.json", "[]");
  ASSERT_EQ(run_quietly({"simulate", run, "--duration", "0.1", "--interactions", (folder / "none.json").string()}), 0);
  const auto law = [&] {
    return json::parse(read_text(folder / "small/run.json"))["stages"]["simulate"]["summary"]["session"]["law"];
  };
  EXPECT_EQ(law(), "viscoelastic");
  ASSERT_EQ(run_quietly({"simulate", run, "--duration", "0.1", "--law", "neo_hookean", "--interactions",
                         (folder / "none.json").string()}),
            0);
  EXPECT_EQ(law(), "neo_hookean");
}

TEST_F(FitOfFewParticles, Physics3dsRecipeGoesOnAtTheNextStepOfItsProgram) {
  // What it wants depends on the number of the step, as noise does; it dies once in the third iteration of 8 clips.
  const std::string guide = (folder / "dies.sh").string(), died = (folder / "died").string();
  write_text(guide, "died='" + died + R"('; cd "$1"; echo '{"ready": 1, "name": "third"}'
while read line; do case "$line" in *quit*) exit 0;; esac
step=${line##*\"step\":}; step=${step%%[,\}]*}; echo $step >> steps.txt
if [ $step = 20 ] && [ ! -e "$died" ]; then echo > "$died"; exit 3; fi
if [ $((step % 3)) = 0 ]; then cp frames.f32 gradient.f32; else head -c $(wc -c < frames.f32) /dev/zero > gradient.f32; fi
echo "{\"step\": $step, \"loss\": 1}"; done)");
  const auto fit = [&] {
    return run_quietly({"fit", (folder / "small").string(), "--overwrite", "--recipe", "physics3d", "--guidance-cmd",
                        "sh " + guide, "--guidance-frames", "2", "--gradient-iterations", "3", "--video-camera",
                        camera});
  };
  write_text(died, "");
  ASSERT_EQ(fit(), 0);
  const std::string whole = read_text(object / "material.h5");
  fs::remove(died);
  fs::remove_all(folder / "small/fit/guide");
  fs::remove(folder / "small/fit/results.json");
  ASSERT_EQ(fit(), 1);
  ASSERT_EQ(fit(), 0);
  EXPECT_EQ(read_text(object / "material.h5"), whole);
  std::string steps;
  for (int step = 0; step < 24; ++step) steps += step == 20 ? "20\n16\n17\n18\n19\n20\n" : std::to_string(step) + "\n";
  EXPECT_EQ(read_text(folder / "small/fit/guide/steps.txt"), steps);
}

TEST_F(FitVideo, WithoutLibtorchNetworksOfPlanesAreRefusedBeforeTheVideoIsOpened) {
  if (has_triplane_fields()) GTEST_SKIP() << "built with libtorch";
  write_text(folder / "broken.mp4", "no video");
  for (const std::vector<std::string>& choice :
       {std::vector<std::string>{"--field", "triplanes"}, {"--recipe", "dreamgaussian4d"}}) {
    std::vector<std::string> more = {"--video", (folder / "broken.mp4").string(), "--video-camera", camera};
    more.insert(more.end(), choice.begin(), choice.end());
    expect_refused(more, {"pliant_triplanes.so", "libtorch"});
  }
}

TEST_F(FitOfFewParticles, AMotionWithoutPhysicsLooksLikeTheVideoAndIsNotSimulated) {
  if (!has_triplane_fields()) GTEST_SKIP() << "planes need libtorch, and this is built without";
  const json found = fitted({"--recipe", "dreamgaussian4d", "--gradient-iterations", "12"});
  EXPECT_EQ(found["source"], "dreamgaussian4d");
  EXPECT_LT(found["loss_last"].get<double>(), found["loss_first"].get<double>());
  EXPECT_GT(found["psnr_fitted"].get<double>(), 15);
  const TrajectoryFile motion = read_trajectory(folder / "small/fit/trajectory.h5");
  ASSERT_EQ(motion.frames.size(), found["frames_used"].get<size_t>());
  const ParticleFile particles = read_particles(object / "particles.h5");
  for (size_t i = 0; i < particles.driving_position.size(); ++i)
    EXPECT_LT((motion.frames[0].position[i] - particles.driving_position[i]).norm(), 1e-5f);
  EXPECT_EQ(run_quietly({"simulate", (folder / "small").string(), "--duration", "0.1", "--no-fit"}), 2)
      << "nothing was fitted that simulate could use";
}

}  // namespace
}  // namespace pliant
