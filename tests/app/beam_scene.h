#pragma once

#include <cmath>
#include <filesystem>

#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/ply.h"

namespace pliant::fixture {

constexpr double kBeamUnit = 0.5;  // m

/// A level beam 0.8 x 0.16 x 0.16 units of 0.5 m along x over a plate, held at its first eighth.
inline void make_beam_scene(const std::filesystem::path& folder) {
  GaussianCloud cloud;
  cloud.sh_degree = 0;
  const auto add = [&](const Vec3f& x, float size, float grey) {
    const size_t i = cloud.size();
    cloud.resize(i + 1);
    cloud.position[i] = x;
    cloud.log_scale[i] = Vec3f::Constant(std::log(size));
    cloud.rotation[i] = Vec4f(1, 0, 0, 0);
    cloud.opacity_logit[i] = 4;
    for (int c = 0; c < 3; ++c) cloud.sh_of(i)[c] = grey;
  };
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 8; ++j)
      for (int k = 0; k < 8; ++k)
        if (j % 7 == 0 || k % 7 == 0 || i % 39 == 0) add(Vec3f(0.02f * i, 0.02f * j, 1 + 0.02f * k), 0.012f, 0.5f);
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 20; ++j) add(Vec3f(0.1f * i - 0.6f, 0.1f * j - 0.9f, 0), 0.06f, -0.5f);
  std::filesystem::create_directories(folder);
  write_ply(folder / "splats.ply", cloud);
  write_text(folder / "scene.json", R"({"splats": "splats.ply", "up": [0, 0, 1], "metres_per_unit": 0.5,
    "pinned": [{"box": [-0.1, -0.1, 0.9, 0.1, 0.3, 1.3]}], "material": {"poisson": 0.35, "density": 900}})");
}

}  // namespace pliant::fixture
