#include "segmentation/sheets/extract_sheet.h"

#include "segmentation/sheets/sides_sheet.h"

namespace pliant {

ImageF extract_sheet(const ExtractResult& result, const GaussianCloud& cloud, const Eigen::Vector3d& up,
                     const RenderOptions& options) {
  const Vec3f colors[kExtractRules] = {{0.1f, 0.9f, 0.2f}, {0.2f, 0.45f, 1.0f}, {1.0f, 0.1f, 0.1f},
                                       {1.0f, 0.1f, 0.7f}, {1.0f, 0.6f, 0.0f},  {0.1f, 0.9f, 0.9f},
                                       {0.9f, 0.9f, 0.1f}, {0.6f, 0.35f, 0.1f}, {0.7f, 0.4f, 1.0f}};
  std::vector<int> kind(cloud.size(), -1);
  std::vector<SheetKind> kinds(kExtractRules);
  for (int k = 0; k < kExtractRules; ++k)
    kinds[k] = {k ? name_of(static_cast<ExtractRule>(k)) : "object", colors[k], 0};
  for (int p : result.object) kind[p] = 0;
  for (size_t p = 0; p < cloud.size(); ++p) {
    if (result.rule[p] != ExtractRule::kNone) kind[p] = static_cast<int>(result.rule[p]);
    if (kind[p] >= 0) ++kinds[kind[p]].count;
  }
  const ExtractSummary& s = result.summary;
  const std::string contact = !s.support             ? "no support"
                              : result.contact.found ? "contact with the support found"
                                                     : "no plane under the object";
  return sides_sheet(cloud, sheet_sides(cloud.select(result.object), up), kind, kinds,
                     std::to_string(result.object.size()) + " Gaussians in the object, " +
                         std::to_string(result.background.size()) + " in the background, " +
                         std::to_string(result.dropped.size()) + " in neither; " + contact,
                     options);
}

}  // namespace pliant
