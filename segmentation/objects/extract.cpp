#include "segmentation/objects/extract.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"
#include "segmentation/objects/extract_steps.h"

namespace pliant {
namespace {

/// Opacity that each rule moved, as a share of `whole`.
std::array<double, kExtractRules> opacity_shares(const GaussianCloud& cloud, const std::vector<ExtractRule>& rule,
                                                 double whole) {
  std::array<double, kExtractRules> share = {};
  for (size_t p = 0; p < rule.size(); ++p)
    if (rule[p] != ExtractRule::kNone)
      share[static_cast<int>(rule[p])] += sigmoid(cloud.opacity_logit[p]) / std::max(whole, 1e-12);
  return share;
}

}  // namespace

const char* name_of(ExtractRule rule) {
  static const char* const kNames[kExtractRules] = {
      "", "probability", "outlier", "floater", "to support", "from support", "enclosed", "island", "hull"};
  return kNames[static_cast<int>(rule)];
}

size_t ExtractSummary::moved_by(ExtractRule rule) const {
  const size_t moved[kExtractRules] = {
      0, below_probability, outliers, floaters, contact_to_support, contact_to_object, enclosed, islands, hull};
  return moved[static_cast<int>(rule)];
}

std::string ExtractSummary::describe() const {
  return std::to_string(candidates) + " candidates; removed: " + std::to_string(below_probability) +
         " below the probability threshold, " + std::to_string(outliers) + " outliers, " + std::to_string(floaters) +
         " floaters (" + std::to_string(dropped) + " of both dropped), " + std::to_string(contact_to_support) +
         " to the support; added: " + std::to_string(contact_to_object) + " from the support, " +
         std::to_string(enclosed) + " enclosed by its own, " + std::to_string(islands) +
         " in components touching only it, " + std::to_string(hull) + " inside its hull";
}

ExtractResult extract(const ExtractOptions& options, const GaussianCloud& cloud, const Segmentation& segmentation) {
  CHECK(segmentation.label.size() == cloud.size());
  const int cls = class_of_id(segmentation, options.object);
  if (cls < 0) {
    std::string known;
    for (size_t c = 0; c < segmentation.class_id.size(); ++c)
      known += (c ? ", " : "") + std::to_string(segmentation.class_id[c]) + " " + segmentation.class_name[c];
    throw usage_error("--object", "",
                      "names id " + std::to_string(options.object) + ", which the segmentation does not have",
                      "choose one of: " + known);
  }
  ExtractResult result;
  ExtractSummary& summary = result.summary;

  // Probability.
  std::vector<float> probability(cloud.size());
  parallel_for(
      static_cast<std::ptrdiff_t>(cloud.size()),
      [&](std::ptrdiff_t p) { probability[p] = class_probabilities(segmentation, p)[cls]; }, 1024);
  std::vector<Place> place(cloud.size(), Place::kBackground);
  std::vector<ExtractRule>& rule = result.rule;
  rule.assign(cloud.size(), ExtractRule::kNone);
  double whole = 0;
  for (size_t p = 0; p < cloud.size(); ++p) {
    if (probability[p] >= options.probability) {
      place[p] = Place::kObject;
      ++summary.candidates;
      whole += sigmoid(cloud.opacity_logit[p]);
    } else if (segmentation.label[p] == options.object) {
      rule[p] = ExtractRule::kProbability;
      ++summary.below_probability;
    }
  }
  const auto nothing_left = [&] {
    return input_error("object " + std::to_string(options.object), segmentation.class_name[cls],
                       "has no Gaussians left: " + summary.describe(),
                       "lower the probability threshold or check the masks");
  };
  if (summary.candidates == 0) throw nothing_left();

  // Outliers, then floaters; what has no background near is dropped, because left behind it would hang in the air.
  std::vector<int> members = indices_of(place, Place::kObject);
  std::vector<int> others = indices_of(place, Place::kBackground), taken;
  std::vector<uint8_t> marked;
  const float spacing = mark_outliers(cloud, members, options.outlier_neighbours, options.outlier_sigma, marked);
  auto take_marked = [&](ExtractRule why, size_t& count) {
    std::vector<int> kept;
    for (size_t i = 0; i < members.size(); ++i) {
      (marked[i] ? taken : kept).push_back(members[i]);
      if (marked[i]) rule[members[i]] = why;
    }
    count = members.size() - kept.size();
    members = std::move(kept);
  };
  take_marked(ExtractRule::kOutlier, summary.outliers);
  const float link = 3 * spacing;
  mark_floaters(cloud, members, link, options.floater_share, marked);
  take_marked(ExtractRule::kFloater, summary.floaters);
  const std::vector<int> nearest = k_nearest(positions(cloud, others), positions(cloud, taken), 1);
  for (size_t i = 0; i < taken.size(); ++i) {
    const bool background_near =
        nearest[i] >= 0 && (cloud.position[others[nearest[i]]] - cloud.position[taken[i]]).norm() <= link;
    place[taken[i]] = background_near ? Place::kBackground : Place::kDropped;
    summary.dropped += !background_near;
  }

  // Contact with the support.
  const std::vector<int> background = indices_of(place, Place::kBackground);
  const bool named = options.support && *options.support != options.object;  // nothing stands on itself
  summary.support = named ? options.support : find_support(options, cloud, segmentation, members, background);
  if (summary.support && class_of_id(segmentation, *summary.support) < 0)
    throw usage_error("support", "",
                      "is id " + std::to_string(*summary.support) + ", which the segmentation does not have",
                      "give an id of the scene");
  std::vector<int> support;
  for (int p : background)
    if (summary.support == segmentation.label[p]) support.push_back(p);
  const GaussianCloud support_cloud = cloud.select(support);
  const std::vector<Vec3f> object_points = positions(cloud, members);
  result.contact = contact_region(object_points, support_cloud.position, options.up);
  const bool sure =
      options.supports ? result.contact.found : stands_on(result.contact, object_points, support_cloud.position);
  if (!named && !sure) {
    summary.support.reset();
    result.contact = contact_region(object_points, {}, options.up);
  }
  if (result.contact.found) {
    settle_contact(cloud, segmentation, *summary.support, named, link, result.contact, place, rule, summary);
    result.contact =
        contact_region(cloud.select(indices_of(place, Place::kObject)).position, support_cloud.position, options.up);
  }
  if (options.enclosed) summary.enclosed = take_enclosed(cloud, place, rule);
  if (options.island_share > 0)
    summary.islands =
        take_islands(cloud, segmentation, options.object, result.contact, link, options.island_share, place, rule);
  if (options.hull) summary.hull = take_hull(cloud, result.contact, place, rule);
  summary.opacity_share = opacity_shares(cloud, rule, whole);
  result.object = indices_of(place, Place::kObject);
  result.background = indices_of(place, Place::kBackground);
  result.dropped = indices_of(place, Place::kDropped);
  if (result.object.empty()) throw nothing_left();
  return result;
}

}  // namespace pliant
