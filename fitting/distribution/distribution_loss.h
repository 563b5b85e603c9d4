#pragma once

#include <memory>
#include <span>
#include <vector>

#include "fitting/distribution/distribution_network.h"

namespace pliant {

/// Objects of equally many samples.
struct TrainingBatch {
  int objects = 0, samples = 0;
  std::vector<float> features;  ///< [objects, samples, features] normalised
  std::vector<float> target;    ///< [objects, samples, 3] log10(E / mean E), log10(rho / mean rho), nu - mean nu
};

/// Mean negative log likelihood of a batch per sample: that of z, and a tenth of those of density and Poisson's ratio.
class DistributionLoss {
 public:
  virtual ~DistributionLoss() = default;
  /// The loss, and its derivative by the parameters unless `gradient` is empty.
  virtual double value(std::span<const float> parameters, const TrainingBatch& batch,
                       std::span<float> gradient) const = 0;
  /// [objects * samples, kOutputs]
  virtual std::vector<float> outputs(std::span<const float> parameters, const TrainingBatch& batch) const = 0;
};

/// Whether this program was built with libtorch.
bool can_train_networks();
/// Loads what training needs, so that its lack is said before any work.  Throws Error{kInput} when libtorch is not
/// there.
void require_network_training();

/// libtorch's derivatives; the module is loaded by the first call.  `network` gives sizes and the wide Gaussian.  Equal
/// for a number of threads.  `in_double` is for the check of its derivatives.  Throws Error{kInput} when libtorch is
/// not there.
std::unique_ptr<DistributionLoss> make_distribution_loss(const DistributionNetwork& network, int threads,
                                                         bool in_double = false);

}  // namespace pliant
