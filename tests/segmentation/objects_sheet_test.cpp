// The contact sheet shows every object; the overlay leaves unlabelled pixels alone.

#include "segmentation/lift/objects_sheet.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "gaussians/io/image_io.h"
#include "gaussians/render/render.h"
#include "segmentation/lift/semantic_field.h"
#include "tests/segmentation/made_scene.h"

namespace pliant {
namespace {

TEST(ObjectsSheet, UnlabelledPixelsKeepTheirColour) {
  ImageF picture(3, 1, 3, 0.25f);
  IdImage ids(3, 1, 1);
  ids(2, 0) = 7;
  const ImageF out = overlay_ids(picture, ids);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(out(0, 0, k), 0.25f);
  EXPECT_NE(out(2, 0, 0), 0.25f);
}

TEST(ObjectsSheet, HoldsTheOverviewAndACropOfEveryObject) {
  const MadeScene scene = made_scene(two_balls(), 6, 200, 150);
  SemanticOptions options;
  options.iterations = 0;
  const auto result = fit_semantic_field(options, scene.cloud, scene.cameras, cast_masks(scene));
  const ImageF sheet = objects_sheet(result.segmentation, scene.cloud, scene.cameras,
                                     [&](int camera) { return render(scene.cloud, scene.cameras[camera]).color; });
  if (const char* folder = std::getenv("PLIANT_TEST_SHEETS")) write_image(std::filesystem::path(folder) / "objects.png", sheet);
  ASSERT_EQ(sheet.channels, 3);
  EXPECT_GE(sheet.width, 200);
  EXPECT_GE(sheet.height, 150 + 180);
  // The frame of every object's crop has the object's colour.
  for (const uint32_t id : {3u, 300u, 70000u}) {
    size_t found = 0;
    for (int y = 160; y < sheet.height; ++y)
      for (int x = 0; x < sheet.width; ++x)
        found += (Eigen::Map<const Vec3f>(sheet.at(x, y)) - id_color(id)).norm() < 0.02f;
    EXPECT_GT(found, 300u) << id;
  }
}

}  // namespace
}  // namespace pliant
