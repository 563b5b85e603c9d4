// `predict`, and `run` without a material: what is known is kept, what is not is predicted and said.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/import/material_fields.h"
#include "app/predict/object_prior.h"
#include "app/run/attach_scene.h"
#include "app/store/material.h"
#include "app/store/particles.h"
#include "app/store/trajectory.h"
#include "fitting/predict/material_table.h"
#include "gaussians/io/files/json_file.h"
#include "tests/app/finished_stage.h"
#include "tests/app/predict/predict_case.h"
#include "tests/fitting/predict/mock_server.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using namespace fixture;
using nlohmann::json;

TEST(ObjectPrior, ComesFromMaterialLabelAndNameInThisOrder) {
  const ObjectPrior rubber = object_prior({"silicone rubber", "", "palm", {}, {}});
  EXPECT_LT(rubber.young.low, 2.6e5);
  EXPECT_GT(rubber.young.high, 2.6e5);
  EXPECT_FALSE(rubber.guessed);
  const ObjectPrior labelled = object_prior({"", "a potted palm", "guitar", {}, {}});
  EXPECT_EQ(labelled.name, object_prior({"", "", "palm", {}, {}}).name);
  ASSERT_TRUE(labelled.height && labelled.frequency);
  EXPECT_GT(labelled.frequency->typical, 0);
}

TEST(ObjectPrior, WarnsWhereLittleOfALabelIsKnown) {
  EXPECT_EQ(object_prior({"", "potted palm", "", {}, {}}).warning, "");
  const std::string warning = object_prior({"", "zorbulated quantic flimflam palm", "", {}, {}}).warning;
  EXPECT_NE(warning.find("only part"), std::string::npos) << warning;
  EXPECT_NE(warning.find("palm"), std::string::npos) << warning;
}

TEST(ObjectPrior, WarnsOfAMaterialInTheLabelThatCountsForNothing) {
  const std::string warning = object_prior({"", "leather sofa", "", {}, {}}).warning;
  for (const char* word : {"'leather'", "'leather sofa'", "--material"})
    EXPECT_NE(warning.find(word), std::string::npos) << warning;
  EXPECT_EQ(object_prior({"", "steel chair", "", {}, {}}).warning, "");
}

TEST(ObjectPrior, OfANameThatMeansNothingIsAGuessAndALabelThatMeansNothingIsRefused) {
  const ObjectPrior guess = object_prior({"", "", "object_1", {}, {}});
  EXPECT_TRUE(guess.guessed);
  ASSERT_TRUE(guess.frequency);
  EXPECT_EQ(guess.frequency->typical, 2);
  expect_error(Failure::kUsage, {"--label", "xyzzy", "--list"}, [] {
    object_prior({"", "xyzzy", "object_1", {}, {}});
  });
  expect_error(Failure::kUsage, {"--material", "unobtainium"}, [] { object_prior({"unobtainium", "", "", {}, {}}); });
}

TEST(ObjectPrior, OfALabelThatOnlyALanguageModelKnows) {
  int status = 401;
  MockServer server([&](int connection, const std::string&) {
    reply(connection, status == 200 ? envelope(kGood) : "no", status == 200 ? "200 OK" : "401 Unauthorized");
  });
  const PriorQuestion question{"", "椅子", "object_1", options_for(server.url()), {}};
  expect_error(Failure::kUsage, {"--label", "401"}, [&] { object_prior(question); });
  EXPECT_TRUE(object_prior({"", "palm", "", question.llm, {}}).unanswered);
  status = 200;
  const ObjectPrior prior = object_prior(question);
  EXPECT_EQ(prior.name, "椅子");
  EXPECT_EQ(prior.warning, "");
  EXPECT_EQ(prior.young.typical, 3e6);
  EXPECT_FALSE(prior.unanswered || prior.height);
}

TEST_F(Predict, RunWithoutAMaterialEndsWithAClipThatSwaysAtTwoHertz) {
  ASSERT_EQ(run({}), 0);
  const json found = summary("predict");
  EXPECT_TRUE(found["guessed"]);
  EXPECT_EQ(found["frequency_hz"], 2);
  EXPECT_TRUE(fs::exists(folder_ / "run/clip.mp4"));
  // E of the guess gives that frequency: f = .1615 (t / L^2) sqrt(E / rho) of a clamped beam, .16 high and .7 long.
  const double expected = 0.1615 * 0.16 / (0.7 * 0.7) * std::sqrt(found["young"].get<double>() / 500);
  EXPECT_NEAR(expected, 2, 0.7);
  // What is simulated is what was predicted.
  EXPECT_EQ(material("material.h5").young, material("predicted.h5").young);
  EXPECT_EQ(material("predicted.h5").log10_young_sigma.size(), material("predicted.h5").young.size());
  const std::string report = read_text(folder_ / "run/report.html");
  for (const char* word : {"Assumed", "a guess", "length of a unit"})
    EXPECT_NE(report.find(word), std::string::npos) << word;
}

TEST_F(Predict, WhatIsGivenIsKeptAndTheRestIsThatOfTheLabel) {
  ASSERT_EQ(run({"--label", "sunflower", "--young", "3e4"}), 0);
  const json found = summary("predict");
  EXPECT_NEAR(found["young"], 3e4, 1);
  const ObjectPrior prior = object_prior({"", "sunflower", "", {}, {}});
  EXPECT_EQ(found["density"], prior.density.typical);
  // The scale is that of its usual height.
  const TrajectoryFile motion = read_trajectory(folder_ / "run/objects/1_object/trajectory.h5");
  EXPECT_NEAR(motion.metres_per_unit, prior.height->typical / summary("extract")["height"].get<double>(), 1e-9);
  // E is 3e4 on average over what is simulated.
  const MaterialFile field = material("predicted.h5");
  const ParticleFile particles = read_particles(folder_ / "run/objects/1_object/particles.h5");
  double sum = 0, volume = 0, mean_density = 0;
  for (size_t i = 0; i < field.young.size(); ++i) {
    if (particles.solid_driver[i] < 0) continue;
    sum += particles.solid_volume[i] * field.young[i];
    mean_density += particles.solid_volume[i] * field.density[i];
    volume += particles.solid_volume[i];
  }
  EXPECT_NEAR(sum / volume, 3e4, 30);
  EXPECT_NEAR(mean_density / volume, prior.density.typical, 1e-3 * prior.density.typical);
  // Once everything is given nothing is predicted any more.
  ASSERT_EQ(run({"--young", "3e4", "--poisson", "0.3", "--density", "500"}), 0);
  EXPECT_TRUE(summary("predict").is_null());
  EXPECT_EQ(material("material.h5").young.front(), 3e4f);
}

TEST_F(Predict, APartOfTheMaterialInTheSceneFileIsKept) {
  json scene = read_json(folder_ / "scene/scene.json");
  scene["material"] = {{"young", 2e4}, {"density", 300}};
  write_text(folder_ / "scene/scene.json", scene.dump());
  ASSERT_EQ(run({}), 0);
  EXPECT_NEAR(summary("predict")["young"], 2e4, 1);
  EXPECT_EQ(summary("predict")["density"], 300);
  EXPECT_EQ(summary("predict")["given"], json::array({"young", "density"}));
  const std::string report = read_text(folder_ / "run/report.html");
  EXPECT_NE(report.find("Poisson's ratio"), std::string::npos);
  EXPECT_EQ(report.find("density [kg/m^3]"), std::string::npos) << "it was not assumed";
  // A label asks for the E of such a thing.
  ASSERT_EQ(run({"--label", "sunflower"}), 0);
  EXPECT_NE(summary("predict")["young"], 2e4);
  // So does any softness, and the usual one too.
  ASSERT_EQ(run_quietly({"predict", (folder_ / "run").string()}), 0);
  EXPECT_NEAR(summary("predict")["young"], 2e4, 1);
  const std::string predicted = read_text(folder_ / "run/objects/1_object/predicted.h5"),
                    record = read_text(folder_ / "run/run.json");
  EXPECT_EQ(run_quietly({"predict", (folder_ / "run").string(), "--preview"}), 2) << "it has no band";
  EXPECT_EQ(run_quietly({"predict", (folder_ / "run").string(), "--poisson", "0.4", "--preview"}), 2);
  EXPECT_EQ(read_text(folder_ / "run/objects/1_object/predicted.h5"), predicted) << "what is refused replaces nothing";
  EXPECT_EQ(read_text(folder_ / "run/run.json"), record);
  EXPECT_FALSE(fs::exists(folder_ / "run/softness"));
  ASSERT_EQ(run_quietly({"predict", (folder_ / "run").string(), "--softness", "0.5"}), 0);
  EXPECT_GT(std::abs(summary("predict")["young"].get<double>() / 2e4 - 1), 0.01);
}

TEST_F(Predict, SoftnessMovesEAlongItsBand) {
  std::vector<double> young, frequency;
  for (const char* softness : {"0", "0.5", "1"}) {
    ASSERT_EQ(run({"--softness", softness}), 0);
    young.push_back(summary("predict")["young"]);
    frequency.push_back(summary("predict")["frequency_hz"]);
    EXPECT_NEAR(summary("predict")["young_band"]["typical"], young.front() / 9, 0.02 * young.front() / 9);
  }
  EXPECT_EQ(frequency, (std::vector<double>{6, 2, 0.7}));
  EXPECT_NEAR(young[0] / young[1], 9, 0.05);
}

TEST_F(Predict, SoftnessOfALabelMovesEAndNotItsBand) {
  ASSERT_EQ(run({"--label", "sunflower"}), 0);
  const json usual = summary("predict");
  std::vector<double> young, frequency;
  for (const char* softness : {"0", "0.25", "0.5", "0.75", "1"}) {
    ASSERT_EQ(run_quietly({"predict", (folder_ / "run").string(), "--label", "sunflower", "--softness", softness}), 0);
    const json found = summary("predict");
    young.push_back(found["young"]);
    frequency.push_back(found["frequency_hz"]);
    EXPECT_EQ(found["young_band"], usual["young_band"]) << softness;
    EXPECT_EQ(found["softness"], std::stod(softness));
  }
  EXPECT_EQ(young[2], usual["young"]);
  EXPECT_EQ(frequency[2], usual["frequency_hz"]);
  EXPECT_NEAR(young[0] / usual["young_band"]["high"].get<double>(), 1, 1e-9);
  EXPECT_NEAR(young[4] / usual["young_band"]["low"].get<double>(), 1, 1e-9);
  for (size_t i = 0; i + 1 < young.size(); ++i) {
    EXPECT_GT(young[i], young[i + 1]);
    EXPECT_NEAR(frequency[i] / frequency[i + 1], std::sqrt(young[i] / young[i + 1]), 1e-9);
  }
}

TEST_F(Predict, ALabelOfTheStageSetsTheScaleAndAnotherScaleIsRefused) {
  ASSERT_EQ(run({}), 0);
  const std::string directory = (folder_ / "run").string();
  const auto height = [&] {
    const json note = read_json(folder_ / "run/run.json").value("assumed_height", json());
    return note.is_object() ? note["height"] : note;
  };
  EXPECT_TRUE(height().is_null());
  ASSERT_EQ(run_quietly({"predict", directory, "--label", "sunflower"}), 0);
  EXPECT_EQ(height(), object_prior({"", "sunflower", "", {}, {}}).height->typical);
  const std::vector<std::string> simulate = {"simulate", directory, "--fps", "20", "--duration", "0.1"};
  EXPECT_EQ(run_quietly(simulate), 0);
  // It stays while the scene is attached as before, and goes once that tells the length of its unit.
  const json assumed = height();
  std::vector<std::string> segment = {"segment", (folder_ / "scene").string(), "--out",         directory,
                                      "--aabb",  "-0.1,-0.1,0.9,0.9,0.3,1.3",  "--orbit-views", "6"};
  EXPECT_EQ(run_quietly(segment), 0);
  EXPECT_EQ(height(), assumed);
  segment.insert(segment.end(), {"--metres-per-unit", "0.5"});
  EXPECT_EQ(run_quietly(segment), 0);
  EXPECT_TRUE(height().is_null());
  segment.resize(segment.size() - 2);
  EXPECT_EQ(run_quietly(segment), 0);
  ASSERT_EQ(run_quietly({"predict", directory, "--label", "sunflower"}), 0);
  EXPECT_EQ(height(), assumed);
  ASSERT_EQ(run({"--young", "1e5", "--poisson", "0.3", "--density", "500"}), 0);
  EXPECT_TRUE(height().is_null()) << "nothing is predicted";
  ASSERT_EQ(run_quietly({"predict", directory, "--label", "sunflower"}), 0);
  json record = read_json(folder_ / "run/run.json");
  record["assumed_height"] = 7;
  write_text(folder_ / "run/run.json", record.dump());
  EXPECT_EQ(run_quietly(simulate), static_cast<int>(Failure::kUsage));
  EXPECT_EQ(run_quietly({"predict", directory, "--label", "rose", "--material", "oak"}), 2);
  EXPECT_EQ(height(), 7) << "nothing is assumed for what is refused";
  // Of a material alone no height is known: not that of the label before it.
  ASSERT_EQ(run_quietly({"predict", directory, "--material", "silicone rubber"}), 0);
  EXPECT_TRUE(height().is_null());
}

TEST_F(Predict, OfALongThingTheLengthSetsTheScaleHoweverItLies) {
  ASSERT_EQ(run({"--label", "banana"}), 0);
  const double length = object_prior({"", "banana", "", {}, {}}).height->typical;
  // The beam lies level, .78 long and .14 high.
  const TrajectoryFile motion = read_trajectory(folder_ / "run/objects/1_object/trajectory.h5");
  EXPECT_NEAR(motion.metres_per_unit * 0.78, length, 0.1 * length);
  const double height = read_json(folder_ / "run/run.json")["assumed_height"]["height"];
  EXPECT_NEAR(height, motion.metres_per_unit * summary("extract")["height"].get<double>(), 1e-9);
  EXPECT_LT(height, 0.3 * length);
}

TEST_F(Predict, AnEOfTheUserTakesTheRestFromThePrediction) {
  ASSERT_EQ(run({"--label", "sunflower"}), 0);
  ASSERT_EQ(run_quietly({"simulate", (folder_ / "run").string(), "--young", "1e6", "--fps", "20", "--duration", "0.1"}),
            0);
  const json uniform = summary("simulate")["session"]["uniform"];
  EXPECT_EQ(uniform["young"], 1e6);
  for (const char* name : {"poisson", "density"}) EXPECT_EQ(uniform[name], summary("predict")[name]) << name;
}

TEST_F(Predict, AMaterialOfTheUserWithoutEIsRefusedWithWhatWorks) {
  ASSERT_EQ(run({"--label", "sunflower"}), 0);
  const std::string directory = (folder_ / "run").string();
  for (const char* option : {"--poisson", "--density"}) {
    const std::vector<std::string> clip = {"simulate", directory, option, "0.4", "--fps", "20", "--duration", "0.1"};
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_pliant(clip), static_cast<int>(Failure::kUsage));
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find("that of the prediction"), std::string::npos) << said;
    EXPECT_NE(said.find(std::string("give ") + option + " to `pliant predict`"), std::string::npos) << said;
    EXPECT_EQ(said.find("--no-fit"), std::string::npos) << said;
  }
  ASSERT_EQ(run_quietly({"predict", directory, "--label", "sunflower", "--poisson", "0.4"}), 0);
  EXPECT_NEAR(summary("predict")["poisson"], 0.4, 1e-6);
  ASSERT_EQ(run_quietly({"simulate", directory, "--fps", "20", "--duration", "0.1"}), 0);
}

TEST_F(Predict, ContradictionsAndUnknownWordsAreRefused) {
  ASSERT_EQ(run({}), 0);
  const std::string directory = (folder_ / "run").string();
  const auto predict = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"predict", directory});
    return run_quietly(words);
  };
  EXPECT_EQ(predict({"--label", "palm"}), 0);
  EXPECT_EQ(predict({"--label", "fern"}), 0);
  EXPECT_EQ(predict({"--label", "palm", "--material", "oak"}), 2);
  EXPECT_EQ(predict({"--label", "xyzzy"}), 2);
  EXPECT_EQ(predict({"--young", "1e5", "--softness", "0.2"}), 2);
  EXPECT_EQ(predict({"--young", "1e5", "--softness", "0.5"}), 2);
  EXPECT_EQ(predict({"--llm-url", "http://127.0.0.1:9"}), 2);
  EXPECT_EQ(predict({"--softness", "2"}), 2);
  EXPECT_EQ(predict({"--llm-url", "http://127.0.0.1:9/v1", "--llm-model", "m"}), 0);  // down: the table is used
  EXPECT_EQ(run_quietly({"predict", "--list", "--label", "palm"}), 2);
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_quietly({"predict", "--list", "--json"}), 0);
  const json list = json::parse(testing::internal::GetCapturedStdout(), nullptr, false);
  ASSERT_TRUE(list.is_object()) << "JSON and nothing else";
  ASSERT_EQ(list["materials"].size(), material_table().materials.size());
  ASSERT_EQ(list["objects"].size(), material_table().objects.size());
  EXPECT_EQ(list["materials"][0]["young_pa"]["typical"], material_table().materials[0].young.typical);
  EXPECT_EQ(run({"--young", "1", "--poisson", "0.3", "--density", "1", "--softness", "0.5"}), 2);
  EXPECT_EQ(run({"--young", "1", "--poisson", "0.3", "--density", "1", "--predict.weights",
                 (folder_ / "scene/scene.json").string()}),
            2);
}

TEST_F(Predict, RunTakesALabelThatOnlyALanguageModelKnows) {
  MockServer server([&](int connection, const std::string&) { reply(connection, envelope(kGood)); });
  ASSERT_EQ(run({"--label", "zorbulon", "--predict.llm-url", server.url(), "--predict.llm-model", "mock"}), 0);
  EXPECT_EQ(server.requests, 1);
  EXPECT_EQ(summary("predict")["understood"], "zorbulon");
  EXPECT_EQ(summary("predict")["density"], 800);
  EXPECT_EQ(run({"--label", "zorbulon"}), 2);
}

TEST_F(Predict, AsksAServiceThatFailedAgain) {
  std::string status = "401 Unauthorized";
  MockServer server([&](int connection, const std::string&) {
    reply(connection, envelope(kGood), status);
    status = "200 OK";
  });
  ASSERT_EQ(run({}), 0);
  const auto predict = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"predict", (folder_ / "run").string(), "--llm-url", server.url(), "--llm-model", "m"});
    return run_quietly(words);
  };
  ASSERT_EQ(predict({"--label", "rose"}), 0);
  EXPECT_TRUE(summary("predict")["unanswered"]);
  for (int again = 0; again < 2; ++again) {
    ASSERT_EQ(predict({"--label", "rose"}), 0);
    EXPECT_FALSE(summary("predict")["unanswered"]);
    EXPECT_EQ(summary("predict")["density"], 800);
    EXPECT_EQ(server.requests, 2);
  }
  EXPECT_EQ(predict({"--material", "steel"}), 2);
}

TEST_F(Predict, ConstantsOfThePredictedLawAreTakenAndOthersAreNot) {
  ASSERT_EQ(run({"--label", "plasticine", "--simulate.yield-stress", "1e4"}), 0);
  EXPECT_EQ(summary("predict")["material"]["law"], "plasticine");
  EXPECT_EQ(run({"--label", "wooden chair", "--simulate.yield-stress", "100"}), 2);
  EXPECT_EQ(summary("predict")["material"]["law"], "fixed_corotated") << "simulate refuses it, after the prediction";
}

TEST_F(Predict, AdaptiveSamplingSeesThePredictionInOneCommand) {
  ASSERT_EQ(run({"--label", "sunflower", "--seed.sampling", "pgas"}), 0);
  const json record = read_json(folder_ / "run/run.json")["stages"];
  EXPECT_TRUE(record["seed"]["inputs"].contains("material"));
  const auto positions = [&] { return read_particles(folder_ / "run/objects/1_object/particles.h5").driving_position; };
  const std::vector<Vec3f> seen = positions();
  // A uniform E places them otherwise.
  MaterialFile uniform = material("predicted.h5");
  uniform.young.assign(uniform.young.size(), 1e5f);
  write_material(folder_ / "uniform.h5", uniform, "{}");
  ASSERT_EQ(run_quietly({"seed", (folder_ / "run").string(), "--particles", "300", "--no-pin-contact", "--sampling",
                         "pgas", "--material", (folder_ / "uniform.h5").string()}),
            0);
  EXPECT_NE(positions(), seen);
}

TEST_F(Predict, ThePreviewShowsTheBandAndIsMadeOnce) {
  // Its first answer is 3e6 Pa; each further one would be a hundredth of the one before.
  json answer = json::parse(kGood);
  MockServer server([&](int connection, const std::string&) {
    reply(connection, envelope(answer.dump()));
    for (auto& [end, young] : answer["E"].items()) young = young.get<double>() / 100;
  });
  ASSERT_EQ(run({"--label", "sunflower", "--predict.llm-url", server.url(), "--predict.llm-model", "mock"}), 0);
  const std::string directory = (folder_ / "run").string();
  const std::string before = read_text(folder_ / "run/objects/1_object/trajectory.h5");
  // A fit that is to replace another, and was interrupted, is no matter of the preview.
  json record = read_json(folder_ / "run/run.json");
  const json fit = finished_stage(json::object(), json::array({"objects/1_object/material.h5"}));
  record["begun"]["fit"] = {{"outputs", fit["outputs"]},
                            {"replaced", {{"record", fit}, {"moved", json::array()}, {"written", json::array()}}}};
  write_text(folder_ / "run/run.json", record.dump());
  ASSERT_TRUE(is_refit_unfinished(RunDirectory::open(folder_ / "run")));
  ASSERT_EQ(run_quietly({"predict", directory, "--label", "sunflower", "--llm-url", server.url(), "--llm-model", "mock",
                         "--preview"}),
            0);
  ASSERT_TRUE(fs::exists(folder_ / "run/softness.mp4"));
  EXPECT_EQ(server.requests, 1);
  std::vector<double> young;
  for (const char* part : {"0", "0.5", "1"})
    young.push_back(read_json(folder_ / "run/softness" / part / "run.json")["stages"]["predict"]["summary"]["young"]);
  EXPECT_GT(young[0], 1.2 * young[1]);
  EXPECT_GT(young[1], 1.2 * young[2]);
  EXPECT_EQ(read_text(folder_ / "run/objects/1_object/trajectory.h5"), before) << "the run itself stays as it is";
  const auto made = fs::last_write_time(folder_ / "run/softness/1/clip.mp4");
  ASSERT_EQ(run_quietly({"predict", directory, "--preview"}), 0);
  EXPECT_EQ(fs::last_write_time(folder_ / "run/softness/1/clip.mp4"), made);
  EXPECT_EQ(read_json(folder_ / "run/run.json")["stages"]["predict"]["options"]["label"], "sunflower");
  const std::string predicted = read_text(folder_ / "run/objects/1_object/predicted.h5"),
                    stages = read_text(folder_ / "run/run.json");
  EXPECT_EQ(run_quietly({"predict", directory, "--young", "1e5", "--preview"}), 2);
  EXPECT_EQ(read_text(folder_ / "run/objects/1_object/predicted.h5"), predicted) << "what is refused replaces nothing";
  EXPECT_EQ(read_text(folder_ / "run/run.json"), stages);
  EXPECT_EQ(run_quietly({"predict", "--list", "--preview"}), 2);
}

TEST_F(Predict, TheMaterialLeavesAndComesBackAsAFileOfOtherPrograms) {
  ASSERT_EQ(run({"--label", "sunflower"}), 0);
  const std::string directory = (folder_ / "run").string();
  const std::vector<float> young = material("material.h5").young;
  for (const char* name : {"field.npz", "field.ply"}) {
    const std::string file = (folder_ / name).string();
    ASSERT_EQ(run_quietly({"export", directory, "--material", file}), 0);
    EXPECT_EQ(read_material_field(file).young, young) << name;
    EXPECT_EQ(run_quietly({"export", directory, "--material", file}), 2) << "exists";
    EXPECT_EQ(run_quietly({"export", directory, "--material", file, "--overwrite", "--every", "2"}), 2);
    EXPECT_EQ(run_quietly({"simulate", directory, "--material", file, "--fps", "20", "--duration", "0.1"}), 0);
  }
  EXPECT_EQ(run_quietly({"export", directory, "--material", (folder_ / "field.txt").string()}), 2);
}

}  // namespace
}  // namespace pliant
