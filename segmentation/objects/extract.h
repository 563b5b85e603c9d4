#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "gaussians/base/gaussian_cloud.h"
#include "segmentation/graph/contact.h"
#include "segmentation/labels/segmentation.h"

namespace pliant {

/// Rules that cut one object out of a labelled scene.
struct ExtractOptions {
  uint32_t object = 0;              ///< id to cut out
  std::optional<uint32_t> support;  ///< id it stands on; none or `object` = sought around its lower end, see `supports`
  /// Ids that are supports, among which it is sought; nullopt = any other id, if the object stands on its plane.
  std::optional<std::vector<uint32_t>> supports;
  Vec3f up = Vec3f::UnitZ();
  float probability = 0.5f;     ///< least class probability of the object's Gaussians
  int outlier_neighbours = 8;   ///< mean distance to so many neighbours ...
  float outlier_sigma = 3;      ///< ... above mean + so many standard deviations is an outlier
  bool enclosed = true;         ///< background among the object's Gaussians is given to it
  float floater_share = 0.02f;  ///< connected parts below this share of the largest part are floaters
  float island_share = 0.02f;   ///< parts of the background below this share of the object are given to it when they
                                ///< touch nothing else; 0 = never
  bool hull = false;            ///< background inside the object's convex hull, above the contact, is given to it
};

/// What moved a Gaussian last; kNone = it is where its probability puts it.
enum class ExtractRule : uint8_t {
  kNone,
  kProbability,
  kOutlier,
  kFloater,
  kToSupport,
  kFromSupport,
  kEnclosed,
  kIsland,
  kHull
};
constexpr int kExtractRules = 9;
const char* name_of(ExtractRule rule);

/// How many Gaussians each rule took.
struct ExtractSummary {
  size_t candidates = 0;          ///< probability >= threshold
  size_t below_probability = 0;   ///< labelled as the object, but with a lower probability: background
  size_t outliers = 0;            ///< too far from the other candidates
  size_t floaters = 0;            ///< in small disconnected parts
  size_t dropped = 0;             ///< of the last two, those with no background near: in neither result
  size_t contact_to_support = 0;  ///< below the contact plane: given to the support
  size_t contact_to_object = 0;   ///< labelled support, but above the plane and among the object's: given to it
  size_t enclosed = 0;            ///< background by the rules above, but with mostly the object around: given to it
  size_t islands = 0;             ///< small parts of the background that only the object holds: given to it
  size_t hull = 0;                ///< background inside the object's convex hull: given to it
  /// Opacity of the Gaussians that a rule moved, by ExtractRule, as a share of that of all candidates.
  std::array<double, kExtractRules> opacity_share = {};
  std::optional<uint32_t> support;          ///< id of the support; none = not found
  size_t moved_by(ExtractRule rule) const;  ///< the count above that is this rule's; 0 for kNone
  std::string describe() const;             ///< one sentence
};

struct ExtractResult {
  std::vector<int> object, background, dropped;  ///< indices into the scene, ascending, together all of it
  std::vector<ExtractRule> rule;                 ///< [N]
  ContactRegion contact;
  ExtractSummary summary;
};

/// Cuts `options.object` out.  Throws Error{kUsage} when the id does not exist, Error{kInput} when nothing is left.
ExtractResult extract(const ExtractOptions& options, const GaussianCloud& cloud, const Segmentation& segmentation);

}  // namespace pliant
