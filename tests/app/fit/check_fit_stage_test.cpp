// What a fit would leave unused is refused by the name of its option.

#include <gtest/gtest.h>

#include <functional>

#include "app/fit/fit_stage.h"
#include "gaussians/base/error.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

struct Unused {
  const char* option;
  std::function<void(FitStage&)> choose;
};

void expect_refused(const std::vector<Unused>& choices, const std::function<void(FitStage&)>& kind, bool has_video) {
  FitStage usual;
  kind(usual);
  EXPECT_NO_THROW(check_fit_stage(usual, has_video));
  for (const Unused& choice : choices) {
    FitStage stage;
    kind(stage);
    choice.choose(stage);
    try {
      check_fit_stage(stage, has_video);
      ADD_FAILURE() << choice.option << " was not refused";
    } catch (const Error& error) {
      EXPECT_EQ(error.failure, Failure::kUsage);
      EXPECT_NE(std::string(error.what()).find(choice.option), std::string::npos) << error.what();
    }
  }
}

TEST(CheckFitStage, OptionsOfVideosAreRefusedWithMarkersAndWithReleasedFields) {
  const std::vector<Unused> of_videos = {{"--field", [](FitStage& s) { s.field = "smooth"; }},
                                         {"--end", [](FitStage& s) { s.until = 1; }},
                                         {"--recipe", [](FitStage& s) { s.recipe = "physdreamer"; }},
                                         {"--start", [](FitStage& s) { s.from = 0; }},
                                         {"--video-camera", [](FitStage& s) { s.cameras = {"a"}; }},
                                         {"--loss", [](FitStage& s) { s.compare.loss = "both"; }},
                                         {"--fit-poisson", [](FitStage& s) { s.compare.poisson = true; }},
                                         {"--fit-density", [](FitStage& s) { s.compare.density = true; }},
                                         {"--guidance-cmd", [](FitStage& s) { s.compare.guide = "x"; }},
                                         {"--video-model-cmd", [](FitStage& s) { s.generate.command = "x"; }},
                                         {"--points", [](FitStage& s) { s.points = 100; }},
                                         {"--video-fps", [](FitStage& s) { s.fps = 24; }},
                                         {"--video", [](FitStage& s) { s.videos = {"v.mp4"}; }},
                                         {"--compare-fps", [](FitStage& s) { s.compare_fps = 12; }},
                                         {"--video-mask", [](FitStage& s) { s.masks = {"m.png"}; }}};
  expect_refused(
      of_videos, [](FitStage& s) { s.markers.file = "m.csv"; }, false);
  expect_refused(
      of_videos, [](FitStage& s) { s.released_young = 1e5; }, true);
}

TEST(CheckFitStage, OptionsOfGradientsAreRefusedWhereNoneRun) {
  const std::vector<Unused> of_gradients = {{"--gradient-window", [](FitStage& s) { s.compare.window = 1; }},
                                            {"--gradient-iterations", [](FitStage& s) { s.compare.iterations = 5; }}};
  expect_refused(
      of_gradients, [](FitStage& s) { s.field = "smooth"; }, true);
  for (const auto& kind : std::vector<std::function<void(FitStage&)>>{
           [](FitStage& s) { s.field = "triplanes"; }, [](FitStage& s) { s.compare.loss = "pictures"; },
           [](FitStage& s) { s.compare.flow_weight = 1; }, [](FitStage& s) { s.recipe = "physdreamer"; },
           [](FitStage& s) { s.compare.poisson = true; },
           [](FitStage& s) {
             s.field = "parts";
             s.compare.density = true;
           }}) {
    FitStage stage;
    kind(stage);
    stage.compare.window = 1;
    stage.compare.iterations = 5;
    EXPECT_NO_THROW(check_fit_stage(stage, true));
  }
}

TEST(CheckFitStage, OneDensityOfTheWholeNeedsAKnownForce) {
  FitStage stage;
  stage.compare.density = true;
  expect_error(Failure::kUsage, {"--fit-density", "E / density", "--field"}, [&] { check_fit_stage(stage, true); });
  for (const char* field : {"parts", "smooth", "triplanes", "kan"}) {
    stage.field = field;
    EXPECT_NO_THROW(check_fit_stage(stage, true)) << field;
  }
  stage.field = "";
  stage.compare.guide = "x";
  EXPECT_NO_THROW(check_fit_stage(stage, false));
}

TEST(CheckFitStage, ARecipeSetsWhatIsLeftOpenAndNothingThatIsSaid) {
  const FitStage search = with_recipe({});
  EXPECT_EQ(search.field, "uniform");
  EXPECT_EQ(search.compare.loss, "tracks");
  EXPECT_EQ(search.compare.picture_weight, 10);
  EXPECT_EQ(search.compare.window, 0);
  FitStage stage;
  stage.recipe = "physdreamer";
  const FitStage published = with_recipe(stage);
  EXPECT_EQ(published.field, "triplanes");
  EXPECT_EQ(published.compare.loss, "image");
  EXPECT_EQ(published.compare.picture_weight, 1);  // against the total variation, 1e-4 of E and 1e-2 of v0
  EXPECT_EQ(published.compare.window, 1);
  EXPECT_EQ(published.compare.lambda, 0.1);
  // An image loss of the recipe's has a weight; one that was refused has none.
  stage.compare.lambda = 0.2;
  EXPECT_NO_THROW(check_fit_stage(stage, true));
  stage.field = "smooth";
  stage.compare.loss = "tracks";
  stage.compare.window = 3;
  const FitStage said = with_recipe(stage);
  EXPECT_EQ(said.field, "smooth");
  EXPECT_EQ(said.compare.loss, "tracks");
  EXPECT_EQ(said.compare.window, 3);
  EXPECT_THROW(check_fit_stage(stage, true), Error);
}

TEST(CheckFitStage, TheReleasedCodesRecipeLeavesNoChoiceOfFieldsAndLoss) {
  FitStage stage;
  stage.recipe = "physdreamer-code";
  EXPECT_NO_THROW(check_fit_stage(stage, true));
  const FitStage chosen = with_recipe(stage);
  EXPECT_EQ(chosen.field, "triplanes");
  EXPECT_EQ(chosen.compare.iterations, 200);
  EXPECT_EQ(chosen.compare.window, 1);
  expect_refused(
      {{"--field", [](FitStage& s) { s.field = "smooth"; }},
       {"--loss", [](FitStage& s) { s.compare.loss = "image"; }},
       {"--loss-lambda", [](FitStage& s) { s.compare.lambda = 0.5; }},
       {"--image-weight", [](FitStage& s) { s.compare.picture_weight = 1; }},
       {"--flow-weight", [](FitStage& s) { s.compare.flow_weight = 1; }},
       {"--fit-poisson", [](FitStage& s) { s.compare.poisson = true; }},
       {"--fit-density", [](FitStage& s) { s.compare.density = true; }}},
      [](FitStage& s) { s.recipe = "physdreamer-code"; }, true);
}

TEST(CheckFitStage, RecipesThatLetAProgramJudgeWantItAndNoVideo) {
  for (const char* recipe : {"physics3d", "dreamphysics"}) {
    FitStage stage;
    stage.recipe = recipe;
    expect_error(Failure::kUsage, {"--guidance-cmd"}, [&] { check_fit_stage(stage, false); });
    stage.compare.guide = "x";
    EXPECT_NO_THROW(check_fit_stage(stage, false));
    EXPECT_NO_THROW(check_fit_stage(stage, true));  // the scene's, which it leaves alone
    EXPECT_EQ(with_recipe(stage).compare.iterations, 50);
    EXPECT_EQ(with_recipe(stage).compare.guide_frames, 16);
    expect_refused(
        {{"--video", [](FitStage& s) { s.videos = {"v.mp4"}; }},
         {"--field", [](FitStage& s) { s.field = "smooth"; }},
         {"--fit-poisson", [](FitStage& s) { s.compare.poisson = true; }},
         {"--fit-density", [](FitStage& s) { s.compare.density = true; }},
         {"--gradient-window", [](FitStage& s) { s.compare.window = 2; }},
         {"--guidance-weight", [](FitStage& s) { s.compare.guide_weight = 2; }}},
        [&](FitStage& s) { s = stage; }, true);
  }
}

TEST(CheckFitStage, ANetworkOfPlacesIsDreamphysicsAlone) {
  FitStage stage;
  stage.compare.guide = "x";
  stage.field = "kan";
  stage.recipe = "dreamphysics";
  EXPECT_NO_THROW(check_fit_stage(stage, false));
  stage.recipe = "physics3d";
  expect_error(Failure::kUsage, {"--field"}, [&] { check_fit_stage(stage, false); });
}

TEST(CheckFitStage, AMaterialToStartFromSaysAllItsConstants) {
  expect_refused(
      {{"--young", [](FitStage& s) { s.material.young = 1e5; }},
       {"--poisson", [](FitStage& s) { s.material.poisson = 0.3; }},
       {"--density", [](FitStage& s) { s.material.density = 1e3; }},
       {"--released-fields", [](FitStage& s) { s.released_young = 1e5; }}},
      [](FitStage& s) { s.initial_material = "m.h5"; }, true);
}

TEST(CheckFitStage, AMotionWithoutPhysicsTakesNoMaterial) {
  FitStage stage;
  stage.recipe = "dreamgaussian4d";
  EXPECT_NO_THROW(check_fit_stage(stage, true));
  EXPECT_EQ(with_recipe(stage).compare.iterations, 500);
  EXPECT_EQ(with_recipe(stage).compare.loss, "image");
  expect_refused(
      {{"--field", [](FitStage& s) { s.field = "smooth"; }},
       {"--young", [](FitStage& s) { s.material.young = 1e5; }},
       {"--poisson", [](FitStage& s) { s.material.poisson = 0.3; }},
       {"--density", [](FitStage& s) { s.material.density = 1e3; }},
       {"--initial-material", [](FitStage& s) { s.initial_material = "m.h5"; }},
       {"--solver", [](FitStage& s) { s.solver = "eulerian"; }},
       {"--start", [](FitStage& s) { s.from = 0; }},
       {"--fit-poisson", [](FitStage& s) { s.compare.poisson = true; }},
       {"--fit-density", [](FitStage& s) { s.compare.density = true; }},
       {"--gradient-window", [](FitStage& s) { s.compare.window = 2; }},
       {"--periods", [](FitStage& s) { s.periods = "2"; }},
       {"--guidance-cmd", [](FitStage& s) { s.compare.guide = "x"; }}},
      [](FitStage& s) { s.recipe = "dreamgaussian4d"; }, true);
}

TEST(CheckFitStage, WhatBelongsToAnotherOptionIsRefusedWithoutIt) {
  expect_refused(
      {{"--loss-lambda", [](FitStage& s) { s.compare.lambda = 0.5; }},
       {"--image-weight", [](FitStage& s) { s.compare.picture_weight = 1; }},
       {"--guidance-frames", [](FitStage& s) { s.compare.guide_frames = 5; }},
       {"--video-model-prompt", [](FitStage& s) { s.generate.prompt = "a"; }},
       {"--parts", [](FitStage& s) { s.parts = 3; }},
       {"--part-labels", [](FitStage& s) { s.part_labels = "l.h5"; }}},
      [](FitStage&) {}, true);
  expect_refused(
      {{"--marker-axes", [](FitStage& s) { s.markers.axes = "y,x,z"; }},
       {"--marker-offset",
        [](FitStage& s) {
          s.markers.offset = {0, 0, 1};
        }},
       {"--marker-release", [](FitStage& s) { s.markers.release = 0; }},
       {"--marker-window", [](FitStage& s) { s.markers.window = 2; }}},
      [](FitStage&) {}, true);
  expect_refused(
      {{"--points", [](FitStage& s) { s.points = 100; }},
       {"--end", [](FitStage& s) { s.until = 1; }},
       {"--compare-fps", [](FitStage& s) { s.compare_fps = 12; }},
       {"--video-camera find", [](FitStage& s) { s.cameras = {"find"}; }},
       {"a second --video-camera",
        [](FitStage& s) {
          s.cameras = {"a", "b"};
        }}},
      [](FitStage& s) {
        s.compare.guide = "x";
        s.cameras = {"a"};
      },
      false);
  expect_refused(
      {{"--guidance-cmd", [](FitStage& s) { s.compare.guide = "x"; }}}, [](FitStage& s) { s.recipe = "physdreamer"; },
      true);
  expect_refused(
      {{"--guidance-load", [](FitStage& s) { s.compare.load = "l.json"; }}}, [](FitStage& s) { s.compare.guide = "x"; },
      true);
  expect_refused(
      {{"--video-first", [](FitStage& s) { s.first = 1; }},
       {"--video-camera find", [](FitStage& s) { s.cameras = {"find"}; }},
       {"--compare-fps", [](FitStage& s) { s.compare_fps = 12; }}},
      [](FitStage& s) { s.generate.command = "x"; }, false);
  expect_refused(
      {{"--parts", [](FitStage& s) { s.parts = 3; }}},
      [](FitStage& s) {
        s.field = "parts";
        s.part_labels = "l.h5";
      },
      true);
}

TEST(CheckFitStage, InRunOptionsAreNamedAsTheyAreTypedThere) {
  const auto in_run = [](const std::function<void(FitStage&)>& kind) {
    return [kind](FitStage& s) {
      s.prefix = "fit.";
      kind(s);
    };
  };
  expect_refused({{"--fit.field", [](FitStage& s) { s.field = "smooth"; }},
                  {"--fit.points", [](FitStage& s) { s.points = 100; }},
                  {"--fit.compare-fps", [](FitStage& s) { s.compare_fps = 12; }},
                  {"--fit.loss", [](FitStage& s) { s.compare.loss = "both"; }},
                  {"--video-camera", [](FitStage& s) { s.cameras = {"a"}; }},
                  {"--fit.video-fps", [](FitStage& s) { s.fps = 24; }}},
                 in_run([](FitStage& s) { s.markers.file = "m.csv"; }), false);
  expect_refused(
      {{"add --fit.loss", [](FitStage& s) { s.compare.lambda = 0.5; }},
       {"add --fit.field parts", [](FitStage& s) { s.parts = 3; }},
       {"--fit.flow-weight, --fit.field triplanes or kan, or --fit.recipe", [](FitStage& s) { s.compare.window = 1; }}},
      in_run([](FitStage&) {}), true);
}

/// `run` on a few Gaussians without a video ends with 2 before its first stage, and says these words.
void expect_run_refuses(std::vector<std::string> options, const std::string& words) {
  const TemporaryFolder folder;
  GaussianCloud cloud;
  cloud.resize(60);
  for (int i = 0; i < 60; ++i)
    cloud.position[i] = Vec3f(0.1f * static_cast<float>(i % 4), 0.1f * static_cast<float>(i / 4 % 4),
                              0.1f * static_cast<float>(i / 16));
  write_ply(folder / "scene.ply", cloud);
  const std::string markers = folder.file("markers.csv", "time,a_x,a_y,a_z\n").string();
  for (std::string& option : options)
    if (option == "MARKERS") option = markers;
  options.insert(options.begin(),
                 {"run", (folder / "scene.ply").string(), "--out", (folder / "run").string(), "--aabb", "0,0,0,1,1,1"});
  ::testing::internal::CaptureStderr();
  const int code = run_quietly(options);
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(code, 2) << said;
  EXPECT_NE(said.find(words), std::string::npos) << said;
  EXPECT_FALSE(std::filesystem::exists(folder / "run/segmentation.h5"));
}

TEST(CheckFitStage, RunRefusesBeforeItsFirstStage) {
  expect_run_refuses({"--fit.markers", "MARKERS", "--fit.field", "smooth"},
                     "--fit.field: does nothing with --fit.markers");
  for (const std::string option : {"--fit.points", "--fit.video-fps", "--video"})
    expect_run_refuses({"--fit.markers", "MARKERS", option, "50"}, option + ": does nothing with --fit.markers");
}

TEST(CheckFitStage, WhereRunFitsNothingOptionsOfTheFitAreRefused) {
  expect_run_refuses({"--fit.field", "smooth"}, "--fit.field: does nothing without a reference video");
  expect_run_refuses({"--fit.gradient-iterations", "5"},
                     "--fit.gradient-iterations: does nothing without a reference video");
  expect_run_refuses({"--no-video", "--fit.markers", "MARKERS"}, "--fit.markers: does nothing with --no-video");
  expect_run_refuses({"--young", "1e5", "--fit.markers", "MARKERS"}, "--fit.markers: does nothing with --young");
  const auto refused = [](const std::function<void(FitStage&)>& choose) {
    FitStage stage;
    choose(stage);
    EXPECT_THROW(check_no_fit_stage(stage, "here", "leave it out"), Error);
  };
  EXPECT_NO_THROW(check_no_fit_stage(FitStage(), "here", "leave it out"));
  refused([](FitStage& s) { s.released_young = 1e5; });
  refused([](FitStage& s) { s.compare.lambda = 0.5; });
  refused([](FitStage& s) { s.compare.guide_limit = 5; });
  refused([](FitStage& s) { s.generate.prompt = "x"; });
  refused([](FitStage& s) { s.part_labels = "l.h5"; });
  refused([](FitStage& s) { s.markers.reach = 1; });
}

}  // namespace
}  // namespace pliant
