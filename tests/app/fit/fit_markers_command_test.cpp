// From marker tracks on a made beam to its stiffness, by the command line.

#include <gtest/gtest.h>

#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/fit/fit_stage.h"
#include "app/run/attach_scene.h"
#include "app/simulate/simulated_body.h"
#include "app/store/material.h"
#include "app/store/velocity.h"
#include "fitting/fit/marker_model.h"
#include "gaussians/base/random.h"
#include "gaussians/io/files/files.h"
#include "tests/app/beam_scene.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using namespace fixture;
using nlohmann::json;

constexpr double kYoung = 1.2e5, kDamping = 0.25, kRelease = 0.3, kUnit = kBeamUnit;

/// What markers on that beam do when it is let go under gravity at kRelease; columns in the order y, x, z, with x
/// reversed.
std::string recording(const RunDirectory& run, const Scene& scene) {
  ParticleFile file = read_particles(run / (object_folder(run) + "/particles.h5"));
  ObjectMaterial material;
  material.young = kYoung;
  material.poisson = 0.35;
  material.density = 900;
  const SimulatedBody body = make_body(file, scene, solid_material(file, material), material.material);
  std::vector<Interaction> load = pins_of(body.file.pinned_json, scene);
  Interaction gravity;
  gravity.type = InteractionType::kGust;
  gravity.vector = Vec3d(0, 0, -9.81);
  load.push_back(gravity);
  MarkerModelOptions options;
  options.simulate.gravity.setZero();
  options.simulate.fps = 240;
  options.reach = 0.05;
  const std::vector<Vec3d> rest = {kUnit * Vec3d(0.78, 0.08, 1.15), kUnit * Vec3d(0.6, 0.0, 1.08),
                                   kUnit * Vec3d(0.45, 0.14, 1.05), Vec3d(3, 3, 3)};
  const MarkerMotion motion = MarkerModel(options, body.particles, load, rest).run({1, kDamping, 0}, 0.8);
  std::string table = "time_s";
  for (const char* name : {"tip", "mid", "near", "wall"})
    for (const char* axis : {"x", "y", "z"}) table += std::string(",") + name + "_" + axis + "_mm";
  char row[128];
  for (int t = 0; t < 120; ++t) {
    std::snprintf(row, sizeof row, "\n%.4f", t / 120.0);
    table += row;
    for (int k = 0; k < 4; ++k) {
      const Vec3d x = rest[k] + (k < 3 ? motion.at(t / 120.0 - kRelease, k) : Vec3d::Zero());
      const auto noise = [&](int a) { return 2e-5 * Random(7, t, 3 * k + a).normal(); };
      std::snprintf(row, sizeof row, ",%.5f,%.5f,%.5f", 1e3 * (x.y() + noise(0)), 1e3 * (0.1 - x.x() + noise(1)),
                    1e3 * (x.z() + noise(2)));
      table += row;
    }
  }
  return table + "\n";
}

/// The same from `rest` on, and before as half a second later.
std::string moved_before(double rest, const std::string& table) {
  constexpr size_t kLater = 60;
  std::vector<std::string> rows;
  std::istringstream in(table);
  for (std::string row; std::getline(in, row);) rows.push_back(row);
  std::string out = rows[0];
  for (size_t t = 1; t < rows.size(); ++t) {
    const std::string& seen = std::stod(rows[t]) < rest ? rows[t + kLater] : rows[t];
    out += '\n' + rows[t].substr(0, rows[t].find(',')) + seen.substr(seen.find(','));
  }
  return out + '\n';
}

TEST(FitMarkersCommand, ATableOfMarkersTellsStiffnessDampingAndRelease) {
  const TemporaryFolder folder;
  make_beam_scene(folder / "scene");
  const std::string scene = (folder / "scene").string(), out = (folder / "run").string();
  ASSERT_EQ(run_quietly({"segment", scene, "--out", out, "--aabb", "-0.1,-0.1,0.9,0.9,0.3,1.3"}), 0);
  ASSERT_EQ(run_quietly({"extract", out, "--object", "object"}), 0);
  ASSERT_EQ(run_quietly({"seed", out, "--particles", "500", "--no-pin-contact"}), 0);
  const RunDirectory run = RunDirectory::open(out);
  const std::string table = recording(run, load_run_scene(run));
  folder.file("markers.csv", table);
  const std::vector<std::string> fit = {"fit",
                                        out,
                                        "--markers",
                                        (folder / "markers.csv").string(),
                                        "--marker-axes",
                                        "-y,x,z",
                                        "--marker-units",
                                        "scene",
                                        "--marker-offset",
                                        "0.2,0,0",
                                        "--marker-window",
                                        "0.35"};
  std::vector<std::string> wrong_start = fit;
  wrong_start.insert(wrong_start.end(), {"--young", "15000"});
  ASSERT_EQ(run_quietly(wrong_start), 0);
  const json result = json::parse(read_text(folder / "run/fit/results.json"));
  EXPECT_NEAR(std::log10(result["young_pa"].get<double>() / kYoung), 0, 0.01);
  EXPECT_NEAR(result["damping_time_s"].get<double>(), kDamping, 0.03);
  EXPECT_NEAR(result["release_s"].get<double>(), kRelease, 1e-3);
  EXPECT_LT(result["rms_mm"].get<double>(), 0.4);  // the tip falls by more than 100 mm
  EXPECT_LT(result["rms_with_later_mm"].get<double>(), 1.5);
  EXPECT_GT(result["rms_still_mm"].get<double>(), 10);
  EXPECT_EQ(result["search_end"], 0);
  EXPECT_EQ(result["markers"], json({"tip", "mid", "near"}));
  EXPECT_NE(result["undetermined"].dump().find("density"), std::string::npos);
  for (const char* file : {"fit/markers.png", "fit/search.png", "fit/report.html"})
    EXPECT_TRUE(fs::exists(folder / "run" / file)) << file;
  const fs::path object = run / object_folder(run);
  EXPECT_NEAR(read_material(object / "material.h5").young.front() / result["young_pa"].get<double>(), 1, 1e-5);
  const VelocityFile start = read_velocity(object / "velocity.h5");
  EXPECT_TRUE(start.velocity.front().isZero(0));
  EXPECT_EQ(start.position, read_particles(object / "particles.h5").driving_position);

  // From a file with the material to start from, the same.
  const MaterialFile fitted = read_material(object / "material.h5");
  MaterialFile first = fitted;
  first.young.assign(fitted.young.size(), 15000);
  write_material(folder / "first.h5", first, "{}");
  std::vector<std::string> from_file = fit;
  from_file.insert(from_file.end(), {"--initial-material", (folder / "first.h5").string()});
  ASSERT_EQ(run_quietly(from_file), 0);
  EXPECT_EQ(read_material(object / "material.h5").young, fitted.young);
  EXPECT_EQ(read_material(object / "material.h5").source, "the initial material times one factor, fitted to markers");
  ASSERT_EQ(run_quietly(wrong_start), 0);
  const json again = json::parse(read_text(folder / "run/fit/results.json"));

  // The same again is no work.
  const std::string record = read_text(folder / "run/run.json");
  ASSERT_EQ(run_quietly(wrong_start), 0);
  EXPECT_EQ(read_text(folder / "run/run.json"), record);

  // What cannot be used is said with the right exit code.
  const auto refused = [&](const std::string& bytes, std::vector<std::string> more) {
    folder.file("bad.csv", bytes);
    std::vector<std::string> command = {"fit", out, "--markers", (folder / "bad.csv").string(), "--overwrite"};
    command.insert(command.end(), more.begin(), more.end());
    return run_quietly(command);
  };
  EXPECT_EQ(refused("time,a_x,a_y\n0,1,2\n", {}), 1);
  EXPECT_EQ(refused(table.substr(0, table.size() / 2) + ",abc\n", {}), 1);
  EXPECT_EQ(refused(table, {}), 1);  // another frame: no marker lies on the beam
  EXPECT_EQ(refused(table, {"--marker-axes", "x,x,z"}), 2);
  EXPECT_EQ(refused(table, {"--marker-axes", "y,x,z"}), 2);  // mirrored
  EXPECT_EQ(refused(table, {"--video", "a.mp4"}), 2);
  const auto like_fit = [&](std::vector<std::string> more) {
    more.insert(more.begin(), fit.begin() + 4, fit.end());
    return refused(table, more);
  };
  EXPECT_EQ(like_fit({"--marker-release", "100"}), 2);
  EXPECT_EQ(like_fit({"--marker-rest", "0.5", "--marker-release", "0.3"}), 2);
  EXPECT_EQ(run_quietly({"fit", out, "--markers", (folder / "none.csv").string(), "--overwrite"}), 1);
  EXPECT_EQ(json::parse(read_text(folder / "run/fit/results.json")), again);

  // Interrupted in the search or in the refinement it goes on, and ends with the same numbers.
  EXPECT_EQ(again["young_pa"], result["young_pa"]);
  Progress progress(true);
  int asked = 0, most = std::numeric_limits<int>::max();
  const Context context{progress, [&] { return ++asked > most; }};
  FitStage stage;
  stage.markers.file = (folder / "markers.csv").string();
  stage.markers.axes = "-y,x,z";
  stage.markers.offset = {0.1, 0, 0};
  stage.markers.window = 0.35;
  stage.material.young = 15000;
  const auto fit_up_to = [&](int calls) {
    asked = 0;
    most = calls;
    fs::remove(folder / "run/fit/results.json");
    RunDirectory again = RunDirectory::open(out);
    run_fit(context, again, load_run_scene(again), stage);
  };
  fit_up_to(most);
  const int all = asked;
  const auto numbers = [&] {
    const json now = json::parse(read_text(folder / "run/fit/results.json"));
    return json({now["young_pa"], now["damping_time_s"], now["release_s"], now["log10_sigma"], now["loss"],
                 now["search_young_pa_rms_mm"]});
  };
  const json whole = numbers();
  EXPECT_EQ(whole[0], result["young_pa"]) << "the same in meters";
  for (const int share : {3, 8}) {
    expect_error(Failure::kInterrupted, {}, [&] { fit_up_to(share * all / 10); });
    EXPECT_TRUE(fs::exists(folder / "run/fit/checkpoint.h5"));
    fit_up_to(std::numeric_limits<int>::max());
    EXPECT_LT(asked, all) << share;
    EXPECT_EQ(numbers(), whole) << share;
    EXPECT_FALSE(fs::exists(folder / "run/fit/checkpoint.h5"));
  }

  // What came before the rest that is named does not show.
  std::vector<std::string> fit_rested = wrong_start;
  fit_rested[3] = (folder / "rested.csv").string();
  fit_rested.insert(fit_rested.end(), {"--marker-rest", "0.1", "--overwrite"});
  const auto chart = [&](const std::string& rows) {
    folder.file("rested.csv", rows);
    EXPECT_EQ(run_quietly(fit_rested), 0);
    return read_text(folder / "run/fit/markers.png");
  };
  EXPECT_TRUE(chart(moved_before(0.1, table)) == chart(table));

  // A release that is given too early, and out of reach from there, is doubted.
  const auto undetermined = [&] {
    return json::parse(read_text(folder / "run/fit/results.json"))["undetermined"].dump();
  };
  EXPECT_EQ(undetermined().find("--marker-release"), std::string::npos) << undetermined();
  std::vector<std::string> early = fit;
  early.insert(early.end(), {"--young", "120000", "--marker-release", "0.24", "--overwrite"});
  ASSERT_EQ(run_quietly(early), 0);
  EXPECT_NE(undetermined().find("of --marker-release, which may be wrong"), std::string::npos) << undetermined();
}

}  // namespace
}  // namespace pliant
