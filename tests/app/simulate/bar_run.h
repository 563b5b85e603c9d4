#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/run/attach_scene.h"
#include "app/store/particles.h"
#include "app/store/trajectory.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/finished_stage.h"
#include "tests/app/run_pliant.h"
#include "tests/physics/shapes.h"
#include "tests/temporary_folder.h"

namespace pliant {

/// A run made by hand up to `seed`: a bar of 0.32 x 0.08 x 0.08 m along x over a plate, with few particles.
class BarRun : public ::testing::Test {
 protected:
  static constexpr const char* kFoot = R"({"box": [-1, -1, -1, 0.05, 1, 1]})";  // region of one end

  BarRun() {
    const Particles bar = fixture::block<float>({0.32, 0.08, 0.08}, 0.04, 0);
    particles_.driving_position = particles_.solid_position = bar.position;
    particles_.driving_volume = particles_.solid_volume = bar.volume;
    for (size_t i = 0; i < bar.size(); ++i) particles_.solid_driver.push_back(static_cast<int>(i));
    particles_.cell_size = bar.cell_size;
    GaussianCloud plate;
    plate.sh_degree = 0;
    for (int i = 0; i < 36; ++i)
      for (int k = 0; k < 24; ++k) {
        const size_t at = plate.size();
        plate.resize(at + 1);
        plate.position[at] = Vec3f(0.02f * i - 0.2f, 0.02f * k - 0.2f, -0.01f);
        plate.log_scale[at] = Vec3f(0.012f, 0.012f, 0.002f).array().log();
        plate.rotation[at] = Vec4f(1, 0, 0, 0);
        plate.opacity_logit[at] = 4;
      }
    write_ply(folder_ / "scene.ply", plate);
  }

  /// The run of the object `name`, held at its foot or free.
  void make(bool pinned, const std::string& name = "bar") {
    std::filesystem::remove_all(folder_ / "run");
    particles_.pinned_json = pinned ? std::string("[") + kFoot + "]" : "[]";
    write_particles(object() / "particles.h5", particles_, "{}");
    std::filesystem::copy_file(folder_ / "scene.ply", folder_ / "run/background.ply");
    const nlohmann::json extracted = {{"folder", "objects/1_bar"}, {"name", name}, {"height", 0.08}};
    const nlohmann::json manifest = {
        {"scene",
         {{"source", (folder_ / "scene.ply").string()}, {"orbit_views", 4}, {"up", {0, 0, 1}}, {"metres_per_unit", 1}}},
        {"stages", {{"extract", finished_stage(extracted)}, {"seed", finished_stage(nlohmann::json::object())}}}};
    write_text(folder_ / "run/run.json", manifest.dump());
  }

  /// `simulate` with these words, at 60 frames per second.
  int simulate(std::vector<std::string> words) const {
    words.insert(words.begin(), {"simulate", run(), "--poisson", "0.3", "--density", "500", "--fps", "60"});
    return run_quietly(words);
  }
  /// A file of interactions.
  std::string script(const nlohmann::json& rows) const { return folder_.file("script.json", rows.dump()).string(); }

  std::string run() const { return (folder_ / "run").string(); }
  std::filesystem::path object() const { return folder_ / "run/objects/1_bar"; }
  TrajectoryFile motion() const { return read_trajectory(object() / "trajectory.h5"); }
  nlohmann::json summary() const {
    return nlohmann::json::parse(read_text(folder_ / "run/run.json"))["stages"]["simulate"]["summary"];
  }

  const TemporaryFolder folder_;
  ParticleFile particles_;
};

}  // namespace pliant
