#pragma once

#include "app/store/material.h"
#include "app/store/particles.h"
#include "tests/app/fit_video_scene.h"

namespace pliant {

/// A fit of few particles and frames: what is looked at is that each kind comes out whole.
class FitOfFewParticles : public FitVideo {
 protected:
  void SetUp() override {
    std::filesystem::copy(folder / "run", folder / "small", std::filesystem::copy_options::recursive);
    ASSERT_EQ(run_quietly({"seed", (folder / "small").string(), "--particles", "300"}), 0);
    object = std::filesystem::directory_iterator(folder / "small/objects")->path();
  }
  void TearDown() override { std::filesystem::remove_all(folder / "small"); }

  nlohmann::json fitted(std::vector<std::string> more) {
    more.insert(more.begin(), {"fit", (folder / "small").string(), "--overwrite", "--points", "60", "--video-last",
                               "0.9", "--compare-fps", "12"});
    EXPECT_EQ(run_quietly(more), 0);
    return nlohmann::json::parse(read_text(folder / "small/fit/results.json"));
  }
  /// How sure each sample's E is goes with it.
  void expect_sigmas(const MaterialFile& material) {
    const size_t samples = read_particles(object / "particles.h5").solid_position.size();
    ASSERT_EQ(material.young.size(), samples);
    ASSERT_EQ(material.log10_young_sigma.size(), samples);
    for (const float sigma : material.log10_young_sigma) EXPECT_TRUE(std::isfinite(sigma) && sigma > 0);
  }
  Path object;
};

}  // namespace pliant
