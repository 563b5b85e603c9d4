#include "segmentation/lift/selection_sheet.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/orbit.h"

namespace pliant {
namespace {

constexpr int kWidth = 400, kHeight = 320, kColumns = 4, kLine = 26;
constexpr int kShown = 4;  // channels: object, and what cut, parts and refinement removed
const Vec3f kColor[kShown] = {{0.1f, 0.9f, 0.2f}, {0.2f, 0.45f, 1.0f}, {1.0f, 0.6f, 0.0f}, {1.0f, 0.1f, 0.6f}};

/// Channel in which a Gaussian is shown, -1 = as it is.
int channel_of(SelectionRule rule) {
  switch (rule) {
    case SelectionRule::kKept:
      return 0;
    case SelectionRule::kCut:
      return 1;
    case SelectionRule::kPart:
      return 2;
    case SelectionRule::kRefined:
      return 3;
    default:
      return -1;
  }
}

}  // namespace

ImageF selection_sheet(const GestureResult& result, const GaussianCloud& cloud, const Eigen::Vector3d& up,
                       const RenderOptions& options) {
  std::vector<float> shown(cloud.size() * kShown, 0.0f);
  std::vector<int> object;
  for (size_t p = 0; p < cloud.size(); ++p) {
    if (const int channel = channel_of(result.rule[p]); channel >= 0) shown[p * kShown + channel] = 1;
    if (result.selected(p)) object.push_back(static_cast<int>(p));
  }
  OrbitOptions orbit;
  orbit.views = 2 * kColumns, orbit.width = kWidth, orbit.height = kHeight, orbit.elevations = {15, 30};
  orbit.field_of_view = 30, orbit.margin = 1.5;
  const std::vector<Camera> sides = orbit_cameras(orbit, cloud.select(object), up);

  ImageF sheet(kColumns * kWidth, 2 * kHeight + 2 * kLine, 3, 0.08f);
  for (size_t v = 0; v < sides.size(); ++v) {
    const RenderResult picture = render(cloud, sides[v], options, shown, kShown);
    const int x0 = static_cast<int>(v) % kColumns * kWidth, y0 = static_cast<int>(v) / kColumns * kHeight;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        Vec3f color(picture.color(x, y, 0), picture.color(x, y, 1), picture.color(x, y, 2));
        float covered = 0;
        Vec3f tint = Vec3f::Zero();
        for (int k = 0; k < kShown; ++k)
          covered += picture.features(x, y, k), tint += picture.features(x, y, k) * kColor[k];
        color = 0.55f * (1 - covered) * color + 0.5f * covered * color + 0.5f * tint;
        for (int k = 0; k < 3; ++k) sheet(x0 + x, y0 + y, k) = std::clamp(color[k], 0.0f, 1.0f);
      }
  }
  cv::Mat canvas(sheet.height, sheet.width, CV_32FC3, sheet.data.data());
  const GestureResult::Summary& s = result.summary;
  const std::pair<std::string, size_t> legend[kShown] = {{"object", s.selected},
                                                         {"removed by the cut", s.cut},
                                                         {"separate parts", s.part},
                                                         {"removed by refinement", s.refined}};
  for (int k = 0; k < kShown; ++k) {
    const cv::Scalar ink(kColor[k].x(), kColor[k].y(), kColor[k].z());
    cv::rectangle(canvas, cv::Rect(8 + k * kWidth, 2 * kHeight + 8, 14, 14), ink, cv::FILLED);
    cv::putText(canvas, legend[k].first + ": " + std::to_string(legend[k].second), {30 + k * kWidth, 2 * kHeight + 20},
                cv::FONT_HERSHEY_SIMPLEX, 0.5, ink, 1, cv::LINE_AA);
  }
  const std::string caption =
      std::to_string(s.outside) + " Gaussians outside the boxes' frusta or the shape (darkened), " +
      std::to_string(s.added) + " added by refinement over " + std::to_string(s.refine_views.size()) + " views, " +
      std::to_string(s.seeds) + " fixed by strokes and clicks";
  cv::putText(canvas, caption, {8, 2 * kHeight + kLine + 16}, cv::FONT_HERSHEY_SIMPLEX, 0.5, cv::Scalar::all(0.8), 1,
              cv::LINE_AA);
  return sheet;
}

}  // namespace pliant
