// Real files: counts and bounds that are known of them, and the same scene in two formats.  Skipped where they are
// absent.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gaussians/base/orbit.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/scene/up_direction.h"
#include "gaussians/io/splats/half_turn.h"
#include "gaussians/io/splats/splats.h"
#include "gaussians/render/render.h"
#include "tests/gaussians/format_files.h"

namespace fs = std::filesystem;

namespace pliant {

fs::path real_data() {
  if (const char* folder = std::getenv("PLIANT_DATA")) return folder;
  std::error_code ignored;
  for (const char* relative : {"../shared/data", "../../shared/data"}) {
    const fs::path folder = fs::path(PLIANT_SOURCE_DIR) / relative;
    if (fs::is_directory(folder, ignored)) return folder.lexically_normal();
  }
  return {};
}

namespace {

struct Known {
  const char* file;
  size_t gaussians;
  int degree;
  Vec3f low, high;  // zero = not known
  Vec3f up;         // zero = not judged
};

const Known kScenes[] = {
    {"gs_daffodils/sog", 542104, 2, {-.307f, -.289f, -.303f}, {.293f, .196f, .297f}, {0, -1, 0}},
    {"gs_daffodils/sog/1_0/meta.json", 0, 2, {}, {}, {0, 0, 0}},
    {"gs_daffodils/sog/2_0/meta.json", 92802, 2, {}, {}, {0, -1, 0}},
    {"gs_daffodils/sog/3_0", 26895, 2, {}, {}, {0, -1, 0}},
    {"gs_daffodils/derived_lod2.ply", 92802, 2, {}, {}, {0, -1, 0}},
    {"gs_potted_palm/centered_lastchance.splat", 14007, 0, {-.345f, -.5f, -.467f}, {.345f, .5f, .428f}, {0, -1, 0}},
    {"gs_potted_palm/derived_palm.ply", 14007, 0, {-.345f, -.5f, -.467f}, {.345f, .5f, .428f}, {0, -1, 0}},
    {"gs_seal_statue/luma-seal.splat", 101780, 0, {-1.52f, -2.26f, -1.35f}, {1.52f, 1.15f, 1.64f}, {0, -1, 0}},
    {"gs_seal_statue/derived_seal.ply", 101780, 0, {-1.52f, -2.26f, -1.35f}, {1.52f, 1.15f, 1.64f}, {0, -1, 0}},
    {"gs_skull/skull.sog", 94936, 3, {}, {}, {0, -1, 0}},
    {"gs_angel/angel.compressed.ply", 71377, 0, {}, {}, {0, 1, 0}},
    {"gs_angel/angel.sog", 71377, 0, {}, {}, {0, -1, 0}},
    {"gs_guitar/guitar.compressed.ply", 90854, 0, {}, {}, {0, -1, 0}},
    {"gs_playbot/sog", 125000, 2, {}, {}, {0, -1, 0}},
    {"gs_playbot/sog/4_0", 8406, 2, {}, {}, {0, -1, 0}},
    {"gs_small_ply/luigi.ply", 14526, 0, {}, {}, {0, 1, 0}},
    {"gs_small_ply/train-1000.ply", 1000, 3, {}, {}, {0, 0, 0}},
    {"gs_format_fixtures/minimal.splat", 4, 0, {}, {}, {0, 0, 0}},
    {"gs_format_fixtures/minimal-raw.spz", 4, 0, {}, {}, {0, 0, 0}},
    {"gs_format_fixtures/minimal-v2.spz", 4, 0, {}, {}, {0, 0, 0}},
    {"gs_format_fixtures/minimal-v3.spz", 4, 0, {}, {}, {0, 0, 0}},
    {"gs_format_fixtures/minimal-v4.spz", 4, 0, {}, {}, {0, 0, 0}},
};

class RealScene : public testing::TestWithParam<Known> {};

TEST_P(RealScene, HasItsKnownCountBoundsAndUp) {
  const Known& known = GetParam();
  const fs::path file = real_data() / known.file;
  REQUIRE_REAL(file);
  ReadReport report;
  const GaussianCloud cloud = read_splats(file, &report);
  EXPECT_EQ(report.dropped, 0u);
  if (known.gaussians > 0) {
    EXPECT_EQ(cloud.size(), known.gaussians);
  }
  EXPECT_EQ(cloud.sh_degree, known.degree);
  if (!known.high.isZero()) {
    EXPECT_LT((cloud.bounds().low - known.low).cwiseAbs().maxCoeff(), 0.0051f);
    EXPECT_LT((cloud.bounds().high - known.high).cwiseAbs().maxCoeff(), 0.0051f);
  }
  if (!known.up.isZero()) {
    EXPECT_GT(up_of_cloud(cloud).up.dot(known.up.cast<double>()), std::cos(3 * M_PI / 180));
  }
}

INSTANTIATE_TEST_SUITE_P(All, RealScene, testing::ValuesIn(kScenes), [](const auto& info) {
  std::string name = info.param.file;
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
});

TEST(RealScenes, LevelsOfDetailHaveTheirKnownCounts) {
  const fs::path file = real_data() / "gs_daffodils/sog";
  REQUIRE_REAL(file);
  const size_t counts[] = {542104, 210422, 92802, 26895};
  for (int level = 1; level < 4; ++level) EXPECT_EQ(read_splats(file, nullptr, level).size(), counts[level]);
}

/// Over the pixels that `a` covers.
double psnr(const RenderResult& a, const RenderResult& b) {
  double sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < a.alpha.data.size(); ++i) {
    if (a.alpha.data[i] < 0.5f) continue;
    for (int c = 0; c < 3; ++c, ++count) sum += std::pow(a.color.data[3 * i + c] - b.color.data[3 * i + c], 2);
  }
  return -10 * std::log10(sum / static_cast<double>(count));
}

TEST(RealScenes, TheAngelIsTheSamePictureInBothFormatsAfterItsHalfTurn) {
  const fs::path folder = real_data() / "gs_angel";
  REQUIRE_REAL(folder);
  GaussianCloud ply = read_splats(folder / "angel.compressed.ply");
  const GaussianCloud sog = read_splats(folder / "angel.sog");
  turn_half(ply, 2);  // x and y have the other sign
  OrbitOptions options;
  options.views = 3;
  options.width = 400;
  options.height = 300;
  for (const Camera& camera : orbit_cameras(options, sog, {0, -1, 0})) {
    const double similar = psnr(render(sog, camera, {}), render(ply, camera, {}));
    std::printf("PSNR %s: %.2f dB\n", camera.name.c_str(), similar);
    EXPECT_GT(similar, 35);
  }
}

TEST(RealScenes, TheDerivedPlyOfTheDaffodilsHasTheValuesOfItsSog) {
  const fs::path folder = real_data() / "gs_daffodils";
  REQUIRE_REAL(folder / "derived_lod2.ply");
  const GaussianCloud sog = read_splats(folder / "sog/2_0"), ply = read_splats(folder / "derived_lod2.ply");
  ASSERT_EQ(sog.size(), ply.size());
  double position = 0, scale = 0, sh = 0, opacity = 0;
  for (size_t i = 0; i < sog.size(); ++i) {
    position = std::max<double>(position, (sog.position[i] - ply.position[i]).norm());
    scale = std::max<double>(scale, (sog.log_scale[i] - ply.log_scale[i]).norm());
    opacity = std::max<double>(opacity, std::abs(sigmoid(sog.opacity_logit[i]) - sigmoid(ply.opacity_logit[i])));
    for (int k = 0; k < 3 * sog.sh_count(); ++k) sh = std::max<double>(sh, std::abs(sog.sh_of(i)[k] - ply.sh_of(i)[k]));
  }
  EXPECT_LT(position, 1e-5);
  EXPECT_LT(scale, 1e-4);
  EXPECT_LT(opacity, 1e-4);
  EXPECT_LT(sh, 1e-4);
  EXPECT_LT(largest_angle(sog, ply), 1e-3);
}

TEST(RealScenes, TheFoxHasFiftyPhotosAndItsDistortion) {
  const fs::path file = real_data() / "photos_fox/transforms.json";
  REQUIRE_REAL(file);
  const CameraFile fox = read_cameras(file);
  EXPECT_EQ(fox.frames, 67);
  EXPECT_EQ(fox.cameras.size(), 50u);
  EXPECT_NE(fox.cameras[0].distortion[0], 0);
  EXPECT_EQ(fox.warnings.size(), 2u);
}

TEST(RealScenes, TheTempleProjectsIntoItsPhotos) {
  const fs::path file = real_data() / "photos_temple/templeR_par.txt";
  REQUIRE_REAL(file);
  const CameraFile temple = read_cameras(file);
  EXPECT_EQ(temple.frames, 47);
  ASSERT_EQ(temple.cameras.size(), 19u);
  const Eigen::Vector3d low(-0.023121, -0.038009, -0.091940), high(0.078626, 0.121636, -0.017395);
  for (const Camera& camera : temple.cameras) {
    EXPECT_EQ(camera.width, 640);
    const Eigen::Vector3d p = camera.cam_from_world * (0.5 * (low + high));
    EXPECT_GT(p.z(), 0);
    EXPECT_LT(std::abs(camera.fx * p.x() / p.z() + camera.cx - 320), 100);
    EXPECT_LT(std::abs(camera.fy * p.y() / p.z() + camera.cy - 240), 100);
  }
}

}  // namespace
}  // namespace pliant
