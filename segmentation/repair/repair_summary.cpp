#include <cstdio>
#include <numeric>

#include "segmentation/repair/repair.h"

namespace pliant {

size_t RepairSummary::before() const { return std::accumulate(hole_before.begin(), hole_before.end(), size_t(0)); }
size_t RepairSummary::after() const { return std::accumulate(hole_after.begin(), hole_after.end(), size_t(0)); }

std::string RepairSummary::describe() const {
  char text[256];
  std::snprintf(text, sizeof(text),
                "hole of %zu pixels in %zu views filled with %zu Gaussians on %zu planes and %zu placed view by view; "
                "%zu pixels left; %.1f s",
                before(), views.size(), plane_gaussians, planes, view_gaussians, after(), seconds);
  return text;
}

std::string RepairSummary::describe_shadow() const {
  char text[256] = "";
  if (shadow == Shadow::Verdict::kPlain)
    std::snprintf(text, sizeof(text), "contact shadow with %.0f %% of the brightness around the object: %s",
                  100 * shadow_darkest,
                  shadow_lifted ? ("removed from " + std::to_string(shadow_gaussians) + " Gaussians").c_str()
                                : "kept, as requested");
  else if (shadow == Shadow::Verdict::kDoubtful)
    std::snprintf(text, sizeof(text), "the support is darker around the object, but %s: left unchanged",
                  shadow_doubt.c_str());
  return text;
}

}  // namespace pliant
