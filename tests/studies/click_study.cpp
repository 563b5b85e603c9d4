// One click on each thing of a demo scene: click_study SCENE_FOLDER [ID_COUNT]
// The click is on the deepest pixel of the thing's mask in cameras 0, 5 and 11; IoU of a rendered membership above 0.5
// with the true masks, over 8 photos.  Only ids up to ID_COUNT (4) are things; the rest are table and wall.

#include <cstdio>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "gaussians/io/scene/scene.h"
#include "gaussians/render/render.h"
#include "segmentation/labels/mask_set.h"
#include "segmentation/select/gesture.h"

using namespace pliant;

namespace {

/// Centre of the pixel farthest from the border of a mask.
Vec2f deepest(const IdImage& ids, uint32_t id) {
  cv::Mat mask(ids.height + 2, ids.width + 2, CV_8U, cv::Scalar(0)), depth;
  for (int y = 0; y < ids.height; ++y)
    for (int x = 0; x < ids.width; ++x) mask.at<uint8_t>(y + 1, x + 1) = ids(x, y) == id;
  cv::distanceTransform(mask, depth, cv::DIST_L2, 5);
  cv::Point at;
  cv::minMaxLoc(depth, nullptr, nullptr, nullptr, &at);
  return Vec2f(at.x - 0.5f, at.y - 0.5f);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: %s SCENE_FOLDER [ID_COUNT]\n", argv[0]), 2;
  const Scene scene = load_scene(argv[1]);
  const PreparedScene prepared = prepare_scene({}, scene.cloud, scene.cameras);
  const MaskSet masks = load_masks(scene.settings.masks, scene.settings.labels, scene.cameras);
  const uint32_t things = argc > 2 ? static_cast<uint32_t>(std::atoi(argv[2])) : 4;
  const size_t step = std::max<size_t>(1, masks.views.size() / 8);
  for (uint32_t id = 1; id <= things; ++id)
    for (size_t view : {0, 5, 11}) {
      if (view >= masks.views.size()) continue;
      Gesture gesture;
      gesture.strokes.push_back({masks.views[view].camera, true, {deepest(masks.views[view].ids, id)}, 8});
      GestureOptions options;
      options.up = scene.up.cast<float>();
      const GestureResult result =
          select_by_gesture(options, gesture, std::nullopt, scene.cloud, scene.cameras, prepared);
      std::vector<float> member(scene.cloud.size());
      for (size_t p = 0; p < member.size(); ++p) member[p] = result.selected(p);
      double sum = 0, least = 1;
      int pictures = 0;
      for (size_t v = 0; v < masks.views.size(); v += step) {
        const RenderResult picture = render(scene.cloud, scene.cameras[masks.views[v].camera], {}, member, 1);
        size_t both = 0, either = 0;
        for (size_t i = 0; i < picture.features.data.size(); ++i) {
          const bool ours = picture.features.data[i] > 0.5f, truth = masks.views[v].ids.data[i] == id;
          both += ours && truth;
          either += ours || truth;
        }
        if (either == 0) continue;
        const double iou = static_cast<double>(both) / static_cast<double>(either);
        sum += iou;
        least = std::min(least, iou);
        ++pictures;
      }
      std::printf("%-10s camera %zu: mean %.3f min %.3f, %zu Gaussians, %.2f s\n", masks.name_of(id).c_str(), view,
                  sum / std::max(1, pictures), least, result.summary.selected, result.summary.seconds);
      std::fflush(stdout);
    }
}
