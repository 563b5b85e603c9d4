// The contact sheet shows every object; the overlay leaves unlabelled pixels alone.

#include "segmentation/sheets/objects_sheet.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "gaussians/io/images/image_io.h"
#include "gaussians/render/render.h"
#include "segmentation/field/semantic_field.h"
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
  if (const char* folder = std::getenv("PLIANT_TEST_SHEETS"))
    write_image(std::filesystem::path(folder) / "objects.png", sheet);
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

TEST(ObjectsSheet, HoldsTheTwoHundredLargestObjectsAndALineAboutTheOthers) {
  const MadeScene scene = made_scene(two_balls(), 6, 200, 150);
  SemanticOptions options;
  options.iterations = 0;
  Segmentation segmentation = fit_semantic_field(options, scene.cloud, scene.cameras, cast_masks(scene)).segmentation;
  const auto draw = [&](size_t objects, std::vector<SheetCell>& cells) {
    while (segmentation.class_id.size() < objects) {  // objects without a Gaussian
      segmentation.class_id.insert(segmentation.class_id.begin() + 1, segmentation.class_id[1] - 1);
      segmentation.class_name.insert(segmentation.class_name.begin() + 1, "nothing");
      segmentation.classifier.insert(segmentation.classifier.begin() + kSemanticChannels, kSemanticChannels, 0.0f);
      segmentation.classifier_bias.insert(segmentation.classifier_bias.begin() + 1, -1e6f);
    }
    segmentation.class_cameras.clear();
    segmentation.class_origin.clear();
    return objects_sheet(
        segmentation, scene.cloud, scene.cameras,
        [&](int camera) { return render(scene.cloud, scene.cameras[camera]).color; }, 12, &cells);
  };
  std::vector<SheetCell> cells;
  const int full = draw(200, cells).height;
  EXPECT_EQ(cells.size(), 4u);
  const ImageF more = draw(260, cells);
  EXPECT_EQ(cells.size(), 4u);  // those that have Gaussians are still shown
  EXPECT_GT(more.height, full);
  EXPECT_LT(more.height, full + 100);
  float brightest = 0;
  for (int y = full; y < more.height; ++y)
    for (int x = 0; x < more.width; ++x) brightest = std::max(brightest, more(x, y, 0));
  EXPECT_GT(brightest, 0.6f);
}

TEST(ObjectsSheet, CellsTellWhichPixelOfWhichCameraIsShown) {
  const MadeScene scene = made_scene(two_balls(), 6, 200, 150);
  SemanticOptions options;
  options.iterations = 0;
  const auto result = fit_semantic_field(options, scene.cloud, scene.cameras, cast_masks(scene));
  // Pictures whose colours say where a pixel is: red = x, green = y, blue = camera.
  const auto coordinates = [](int camera) {
    ImageF picture(200, 150, 3);
    for (int y = 0; y < 150; ++y)
      for (int x = 0; x < 200; ++x) {
        picture(x, y, 0) = (x + 0.5f) / 200;
        picture(x, y, 1) = (y + 0.5f) / 150;
        picture(x, y, 2) = static_cast<float>(camera) / 8;
      }
    return picture;
  };
  std::vector<SheetCell> cells;
  const ImageF sheet = objects_sheet(result.segmentation, scene.cloud, scene.cameras, coordinates, 12, &cells);
  ASSERT_EQ(cells.size(), 4u);  // the overview and three objects
  for (size_t k = 1; k < cells.size(); ++k) {
    const SheetCell& cell = cells[k];
    int right = 0, looked = 0;
    for (int y = cell.y + 5; y < cell.y + cell.height - 5; y += 6)
      for (int x = cell.x + 5; x < cell.x + cell.width - 5; x += 6) {
        const double px = cell.origin_x + (x + 0.5 - cell.x) * cell.scale,
                     py = cell.origin_y + (y + 0.5 - cell.y) * cell.scale;
        if (px < 2 || py < 2 || px > 198 || py > 148) continue;
        const float* color = sheet.at(x, y);
        ++looked;  // all but outlines
        right += std::abs(200 * color[0] - px) < 1.5 && std::abs(150 * color[1] - py) < 1.5 &&
                 std::abs(8 * color[2] - cell.camera) < 0.1;
      }
    EXPECT_GT(looked, 50);
    EXPECT_GT(right, 0.75 * looked) << k;
  }
}

}  // namespace
}  // namespace pliant
