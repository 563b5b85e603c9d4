#include "segmentation/sheets/sides_sheet.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"
#include "gaussians/base/orbit.h"

namespace pliant {
namespace {

constexpr int kWidth = 400, kHeight = 320, kColumns = 4, kLine = 26;

}  // namespace

std::vector<Camera> sheet_sides(const GaussianCloud& object, const Eigen::Vector3d& up) {
  OrbitOptions orbit;
  orbit.views = 2 * kColumns;
  orbit.width = kWidth;
  orbit.height = kHeight;
  orbit.elevations = {15, 30};
  orbit.field_of_view = 30;
  orbit.margin = 1.5;
  return orbit_cameras(orbit, object, up);
}

std::vector<SheetCell> side_cells(const std::vector<Camera>& sides) {
  std::vector<SheetCell> cells;
  for (int k = 0; k < static_cast<int>(sides.size()); ++k)
    cells.push_back({k % kColumns * kWidth, k / kColumns * kHeight, sides[k].width, sides[k].height, k, 0, 0, 1});
  return cells;
}

ImageF sides_sheet(const GaussianCloud& cloud, const std::vector<Camera>& sides, const std::vector<int>& kind,
                   const std::vector<SheetKind>& kinds, const std::string& caption, const RenderOptions& options) {
  CHECK(kind.size() == cloud.size() && sides.size() == 2 * kColumns);
  const int shown = static_cast<int>(kinds.size()), lines = (shown + kColumns - 1) / kColumns;
  std::vector<float> features(cloud.size() * kinds.size(), 0.0f);
  for (size_t p = 0; p < cloud.size(); ++p)
    if (kind[p] >= 0) features[p * kinds.size() + kind[p]] = 1;

  ImageF sheet(kColumns * kWidth, 2 * kHeight + (1 + lines) * kLine, 3, 0.08f);
  for (const SheetCell& cell : side_cells(sides)) {
    const RenderResult picture = render(cloud, sides[cell.camera], options, features, shown);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        Vec3f color(picture.color(x, y, 0), picture.color(x, y, 1), picture.color(x, y, 2));
        float covered = 0;
        Vec3f tint = Vec3f::Zero();
        for (int k = 0; k < shown; ++k) {
          covered += picture.features(x, y, k);
          tint += picture.features(x, y, k) * kinds[k].color;
        }
        color = 0.55f * (1 - covered) * color + 0.5f * covered * color + 0.5f * tint;
        for (int k = 0; k < 3; ++k) sheet(cell.x + x, cell.y + y, k) = std::clamp(color[k], 0.0f, 1.0f);
      }
  }
  cv::Mat canvas(sheet.height, sheet.width, CV_32FC3, sheet.data.data());
  for (int k = 0; k < shown; ++k) {
    const cv::Scalar ink(kinds[k].color.x(), kinds[k].color.y(), kinds[k].color.z());
    const int x = 8 + k % kColumns * kWidth, y = 2 * kHeight + 8 + k / kColumns * kLine;
    cv::rectangle(canvas, cv::Rect(x, y, 14, 14), ink, cv::FILLED);
    cv::putText(canvas, kinds[k].name + ": " + std::to_string(kinds[k].count), {x + 22, y + 12},
                cv::FONT_HERSHEY_SIMPLEX, 0.5, ink, 1, cv::LINE_AA);
  }
  cv::putText(canvas, caption, {8, 2 * kHeight + lines * kLine + 16}, cv::FONT_HERSHEY_SIMPLEX, 0.5,
              cv::Scalar::all(0.8), 1, cv::LINE_AA);
  return sheet;
}

}  // namespace pliant
