#pragma once

// Configurations of PhysGaussian from their text, and bodies that they move.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "app/import/physgaussian_world.h"
#include "gaussians/base/error.h"
#include "gaussians/base/random.h"
#include "tests/temporary_folder.h"

namespace pliant::fixture {

inline PhysGaussianConfig parse(const std::string& text) {
  const TemporaryFolder folder;
  folder.file("config.json", text);
  return read_physgaussian_config(folder / "config.json");
}

inline void expect_refused(const std::string& text, const std::vector<std::string>& words) {
  try {
    parse(text);
    ADD_FAILURE() << "accepted: " << text;
  } catch (const Error& error) {
    EXPECT_TRUE(error.failure == Failure::kUsage || error.failure == Failure::kInput) << error.what();
    for (const std::string& word : words)
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << word << " in: " << error.what();
  }
}

/// A solid block of the configuration's extent about (1, 1, 1), eight particles to a cell of at least 1/10
/// of its extent.
inline Particles stand_in(const PhysGaussianConfig& config, std::vector<Vec3d>& gaussians, double width = 0.5) {
  Particles p;
  const double dx = std::max(config.cell_size(), config.scale / 10), h = dx / 2;
  p.cell_size = static_cast<float>(dx);
  const int nz = static_cast<int>(config.scale / h), nx = static_cast<int>(width * config.scale / h);
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < nx; ++j)
      for (int k = 0; k < nz; ++k) {
        Random random(11, p.position.size());
        const Vec3d cell(i - 0.5 * nx, j - 0.5 * nx, k - 0.5 * nz),
            jitter(random.uniform(), random.uniform(), random.uniform());
        p.position.push_back((Vec3d::Ones() + h * (cell + jitter)).cast<float>());
        gaussians.push_back(p.position.back().cast<double>());
      }
  p.volume.assign(p.size(), static_cast<float>(h * h * h));
  p.mass.assign(p.size(), static_cast<float>(200 * h * h * h));
  p.young.assign(p.size(), 1e5f);
  p.poisson.assign(p.size(), 0.3f);
  return p;
}

}  // namespace pliant::fixture
