#include "app/segment/prompted_masks.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "app/segment/photo_or_render.h"
#include "gaussians/base/error.h"
#include "gaussians/io/images/image_io.h"
#include "segmentation/models/make_models.h"
#include "segmentation/select/selection.h"
#include "segmentation/sheets/objects_sheet.h"

namespace pliant {
namespace {

constexpr int kStrokePoints = 5;  ///< of a stroke that the segmenter is told, spread evenly along it

/// Points at equal distances along the polyline, its ends among them.
std::vector<Vec2f> spread_along(const std::vector<Vec2f>& line, int count) {
  std::vector<float> length = {0};
  for (size_t k = 1; k < line.size(); ++k) length.push_back(length.back() + (line[k] - line[k - 1]).norm());
  if (length.back() <= 0) return {line.front()};
  std::vector<Vec2f> points;
  for (int i = 0; i < count; ++i) {
    const float at = length.back() * static_cast<float>(i) / static_cast<float>(count - 1);
    const size_t k =
        std::clamp<size_t>(std::lower_bound(length.begin(), length.end(), at) - length.begin(), 1, line.size() - 1);
    const float step = length[k] - length[k - 1];
    points.push_back(line[k - 1] + (line[k] - line[k - 1]) * (step > 0 ? (at - length[k - 1]) / step : 0));
  }
  return points;
}

MaskPrompt prompt_in(const Gesture& gesture, int camera) {
  MaskPrompt prompt;
  for (const BoxPrompt& box : gesture.boxes)
    if (box.camera == camera) prompt.box = MaskPrompt::Box{box.x0, box.y0, box.x1, box.y1};
  for (const StrokePrompt& stroke : gesture.strokes)
    if (stroke.camera == camera)
      for (const Vec2f& x : spread_along(stroke.points, kStrokePoints))
        prompt.points.push_back({x.x(), x.y(), stroke.foreground});
  return prompt;
}

}  // namespace

std::vector<int> marked_cameras(const Gesture& gesture) {
  std::set<int> cameras;
  for (const BoxPrompt& box : gesture.boxes) cameras.insert(box.camera);
  for (const StrokePrompt& stroke : gesture.strokes) cameras.insert(stroke.camera);
  return {cameras.begin(), cameras.end()};
}

MaskSet prompted_masks(const Context& context, const RunDirectory& run, const Scene& scene, const Gesture& gesture,
                       const ModelChoice& models) {
  const std::unique_ptr<PromptableSegmenter> segmenter = make_segmenter(models);
  const std::filesystem::path folder = run / "prompted";
  std::filesystem::create_directories(folder);
  MaskSet masks;
  masks.names = {{SelectionShape::kObject, "object"}, {SelectionShape::kRest, "rest"}};
  for (const int c : marked_cameras(gesture)) {
    const std::string& name = scene.cameras[c].name;
    const MaskPrompt prompt = prompt_in(gesture, c);
    if (!prompt.box && std::none_of(prompt.points.begin(), prompt.points.end(),
                                    [](const MaskPrompt::Point& p) { return p.foreground; }))
      throw usage_error("--stroke", "bg," + name, "is the only prompt there, and a segmenter needs one on the object",
                        "add a --click, --box or --stroke fg in '" + name + "'");
    const ImageF picture = photo_or_render(scene, c);
    segmenter->encode(picture);
    const SegmentedMask mask = segmenter->segment(prompt).front();
    IdImage ids(picture.width, picture.height, 1);
    for (size_t i = 0; i < ids.data.size(); ++i)
      ids.data[i] = mask.logits.data[i] > 0 ? SelectionShape::kObject : SelectionShape::kRest;
    const auto pixels = std::count(ids.data.begin(), ids.data.end(), SelectionShape::kObject);
    if (pixels == 0)
      throw usage_error("--segmenter", models.segmenter, "finds nothing at the prompt in '" + name + "'",
                        "mark another place, or give a --box");
    context.progress.say(fmt::format("segment: the segmenter's mask in '{}' has {} pixels (predicted overlap {:.2f})",
                                     name, pixels, mask.predicted_iou));
    write_image(folder / (name + ".jpg"), overlay_ids(picture, ids));
    masks.views.push_back({c, std::move(ids)});
  }
  return masks;
}

}  // namespace pliant
