#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/store/material.h"
#include "gaussians/io/files/json_file.h"
#include "tests/app/beam_scene.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace pliant {

/// A beam whose scene file says nothing of its material.
class Predict : public ::testing::Test {
 protected:
  void SetUp() override {
    fixture::make_beam_scene(folder_ / "scene");
    nlohmann::json scene = read_json(folder_ / "scene/scene.json");
    scene.erase("material");
    scene.erase("metres_per_unit");
    write_text(folder_ / "scene/scene.json", scene.dump());
  }
  /// `run` with these words besides.
  int run(std::vector<std::string> words) const {
    words.insert(words.begin(), {"run", (folder_ / "scene").string(), "--out", (folder_ / "run").string(), "--aabb",
                                 "-0.1,-0.1,0.9,0.9,0.3,1.3", "--scene.orbit-views", "6", "--seed.particles", "300",
                                 "--seed.no-pin-contact", "--simulate.fps", "20", "--duration", "0.2", "--no-html",
                                 "--render.no-orbit"});
    return run_quietly(words);
  }
  nlohmann::json summary(const char* stage) const {
    return read_json(folder_ / "run/run.json")["stages"][stage]["summary"];
  }
  MaterialFile material(const char* file) const { return read_material(folder_ / "run/objects/1_object" / file); }

  const TemporaryFolder folder_;
};

}  // namespace pliant
