#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "gaussians/base/types.h"
#include "physics/body/samples.h"

namespace pliant {

/// What a label, a table or a person says of Young's modulus of the object as a whole [Pa].
struct YoungPrior {
  double low = 1e4, typical = 1e6, high = 1e8;
};

struct FeatureInput {
  const SolidSamples& samples;     ///< metres
  std::span<const Vec3f> colour;   ///< [M] diffuse sRGB 0..1 of the nearest surface
  std::span<const int> part = {};  ///< [M]; empty = not known, which is the same as one part
  Vec3f up = Vec3f::UnitZ();
  YoungPrior prior;
};

constexpr int kFeatures = 63;
constexpr int kFirstPartFeature = 44, kPartFeatures = 6;  ///< all 0 where parts are not known
/// Where groups of features that say similar things end: height, thickness, colour, hue, contrast, path, load, shape
/// near and around, place in layer and column, places of the colour, part, prior, size, proportions, looks of the
/// whole.
constexpr int kFeatureGroups[] = {4, 6, 9, 12, 14, 17, 19, 31, 40, 42, 44, 50, 52, 53, 59, 63};
constexpr int kPriorFeature = 50;  ///< log10 of the typical E, then the band in decades

/// A name for each feature, separated by spaces; weights carry them, so that those made for other features are refused.
std::string_view feature_names();

/// [M, kFeatures] of every sample, which do not change when the object is moved, turned about `up` or sampled more
/// densely: neighbourhoods are shares of at most a thousand samples, lengths are shares of the object's size.  Its size
/// in metres and the prior stand beside them.
std::vector<float> local_features(const FeatureInput& object);

}  // namespace pliant
