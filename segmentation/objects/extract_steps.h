#pragma once

#include <span>

#include "gaussians/base/gaussian_cloud.h"
#include "segmentation/graph/contact.h"
#include "segmentation/objects/extract.h"

namespace pliant {

// The steps of `extract`: what is taken from the candidates, and what the background gives back.

enum class Place : uint8_t { kBackground, kObject, kDropped };

std::vector<Vec3f> positions(const GaussianCloud& cloud, const std::vector<int>& indices);
std::vector<int> indices_of(const std::vector<Place>& place, Place which);

/// Distance at which two Gaussians touch: `link`, or as far as they reach, five times that at most.
float touching_distance(const GaussianCloud& cloud, int a, int b, float link);

/// The part of each member, as the index of one of its members: parts are connected by neighbours that touch.
std::vector<int> parts_of(const GaussianCloud& cloud, const std::vector<int>& members, float link);

/// Statistical outlier removal: marks points whose mean neighbour distance exceeds mean + sigma * deviation and whose
/// own extent does not bridge that distance.  Returns the median of the mean distances.
float mark_outliers(const GaussianCloud& cloud, const std::vector<int>& members, int k, float sigma,
                    std::vector<uint8_t>& outlier);

/// Marks members in parts smaller than `share` of the largest that touch no larger part.
void mark_floaters(const GaussianCloud& cloud, const std::vector<int>& members, float link, float share,
                   std::vector<uint8_t>& floater);

/// The commonest id, other than the object's and of `options.supports` if given, among the Gaussians nearest to the
/// object's lowest twentieth.
std::optional<uint32_t> find_support(const ExtractOptions& options, const GaussianCloud& cloud,
                                     const Segmentation& segmentation, const std::vector<int>& object,
                                     std::vector<int> background);

/// Whether the object stands on the plane of the contact: it does not pass through the object, and it goes on beyond
/// the object's lowest part.
bool stands_on(const ContactRegion& contact, std::span<const Vec3f> object, std::span<const Vec3f> support);

/// Settles Gaussians near the contact plane: the object's below it go to the support where the support is close, the
/// support's above it that lie among the object's go to the object.
/// A support that the scene names is a surface; one that was only found may be the rest of the world.
void settle_contact(const GaussianCloud& cloud, const Segmentation& segmentation, uint32_t support_id, bool named,
                    float link, const ContactRegion& contact, std::vector<Place>& place, std::vector<ExtractRule>& rule,
                    ExtractSummary& summary);

/// Background Gaussians most of whose neighbours are the object's belong to it: specks that would stay behind in the
/// air when it moves.  Repeated until nothing changes.
size_t take_enclosed(const GaussianCloud& cloud, std::vector<Place>& place, std::vector<ExtractRule>& rule);

/// Small parts of the background that touch the object and nothing else would hang in the air when it moves; they are
/// given to it, unless they lie below the contact or are most of what bears their label.
size_t take_islands(const GaussianCloud& cloud, const Segmentation& segmentation, uint32_t object_id,
                    const ContactRegion& contact, float link, float share, std::vector<Place>& place,
                    std::vector<ExtractRule>& rule);

/// Gives background inside the convex hull of the object, and above its contact, to it.
size_t take_hull(const GaussianCloud& cloud, const ContactRegion& contact, std::vector<Place>& place,
                 std::vector<ExtractRule>& rule);

}  // namespace pliant
