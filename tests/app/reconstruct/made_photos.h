#pragma once

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "app/reconstruct/photo_set.h"
#include "app/reconstruct/reconstruct_stage.h"
#include "gaussians/base/error.h"
#include "gaussians/base/random.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/render/render.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace pliant {

/// Pictures this small are not worth more than one thread.
class Reconstruct : public ::testing::Test {
 protected:
  Reconstruct() : threads_(omp_get_max_threads()) { omp_set_num_threads(1); }
  ~Reconstruct() override { omp_set_num_threads(threads_); }

 private:
  int threads_;
};

constexpr int kWidth = 80, kHeight = 60;

/// Blobs of many colours in a ball of radius 0.5.
inline GaussianCloud made_cloud() {
  GaussianCloud cloud;
  cloud.resize(150);
  for (size_t i = 0; i < cloud.size(); ++i) {
    Random random(5, i);
    const Vec3d direction(random.normal(), random.normal(), random.normal());
    cloud.position[i] = (0.5 * std::cbrt(random.uniform()) * direction.normalized()).cast<float>();
    cloud.log_scale[i].setConstant(std::log(0.07f));
    cloud.opacity_logit[i] = 2;
    for (int c = 0; c < 3; ++c) cloud.sh_of(i)[c] = static_cast<float>(random.uniform(-1.5, 1.5));
  }
  return cloud;
}

/// Photos of the made cloud from all around: transforms.json and photos/.
inline void make_photos(const std::filesystem::path& folder, int count = 16) {
  const GaussianCloud cloud = made_cloud();
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count, height = 0.6 * std::sin(3 * angle);
    Camera camera =
        look_at({2 * std::cos(angle), 2 * std::sin(angle), height}, {0, 0, 0}, {0, 0, 1}, kWidth, kHeight, 90);
    camera.name = "v" + std::to_string(10 + i);
    camera.photo = (folder / "photos" / (camera.name + ".png")).string();
    std::filesystem::create_directories(folder / "photos");
    write_image(camera.photo, render(cloud, camera).color);
    cameras.push_back(camera);
  }
  write_transforms(folder / "transforms.json", cameras);
}

inline std::vector<std::string> command(const std::filesystem::path& photos, const std::filesystem::path& out,
                                        std::vector<std::string> more = {}) {
  std::vector<std::string> words = {"reconstruct", photos.string(), "--out", out.string()};
  words.insert(words.end(), more.begin(), more.end());
  for (const auto& [option, value] : {std::pair{"--init", "random"}, {"--max-gaussians", "1k"}, {"--sh-degree", "0"}})
    if (std::find(more.begin(), more.end(), option) == more.end()) words.insert(words.end(), {option, value});
  return words;
}

/// Trains with the library; interrupted after so many questions about it, two an iteration (-1 = never).
inline bool train(const std::filesystem::path& photos, const std::filesystem::path& out, ReconstructStage stage,
                  int questions, bool overwrite = false) {
  RunDirectory run = RunDirectory::create(out);
  Progress progress(true);
  const Context context{progress, [&, asked = 0]() mutable { return questions >= 0 && asked++ >= questions; }, 1, 1,
                        overwrite};
  try {
    run_reconstruct(context, run, photos, stage);
    return true;
  } catch (const Error& error) {
    if (error.failure != Failure::kInterrupted) throw;
    return false;
  }
}

inline ReconstructStage short_stage() {
  ReconstructStage stage;
  stage.train.iterations = 250;
  stage.train.most_gaussians = 600;
  stage.train.exposure = true;
  stage.start = "random";
  return stage;
}

}  // namespace pliant
