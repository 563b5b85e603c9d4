#pragma once

#include <span>
#include <string>
#include <vector>

#include "fitting/distribution/distribution_loss.h"
#include "fitting/distribution/material_object.h"
#include "fitting/distribution/object_corpus.h"

namespace pliant {

/// Volume-weighted means of an object.
MaterialMeans means_of(const MaterialObject& object);
/// [M, 3] log10(E / mean E), log10(rho / mean rho), nu - mean nu.
std::vector<float> targets_of(const MaterialObject& object, const MaterialMeans& means);

/// Objects as the network takes them, of kContextSamples samples each.
struct TrainingSet {
  std::vector<float> features;  ///< [objects, kContextSamples, kFeatures], not normalised
  std::vector<float> target;    ///< [objects, kContextSamples, 3]
  std::vector<int> family;      ///< [objects] number of the family; -1 = given besides
  size_t objects() const { return target.size() / (3 * kContextSamples); }
};

/// Whether a member of an ensemble is trained without a family, which then judges that member: family f is left out by
/// member f modulo their number.  A single member leaves out none.
bool leaves_out(int members, int member, int family);

struct TrainingSetOptions {
  int objects = 3600;  ///< in turn of each family
  uint64_t seed = 0;   ///< object k is of seed + k
  bool vague = true;   ///< the prior is off by .15 decades and its band from .3 to 2.5, as priors are
  int threads = 1;
};
/// The objects of those families, and those given besides.
TrainingSet make_training_set(const TrainingSetOptions& options, std::span<const std::string> families,
                              std::span<const MaterialObject> more = {});

/// What a pass does to the features of an object, so that families are not learned by heart.
struct Disturbance {
  double hidden_parts = 0;   ///< share of objects whose parts are not known
  double hidden_groups = 0;  ///< share of groups of features that are as those of the average object
  double offset = 0;         ///< deviation of what is added to each normalised feature of all samples
};
/// [objects of the batch, samples]: those samples of each object, in a random order.
TrainingBatch batch_of(const DistributionNetwork& network, const TrainingSet& set, std::span<const int> objects,
                       int samples, const Disturbance& disturbance, uint64_t seed);

}  // namespace pliant
