#include "fitting/distribution/distribution_loss.h"

#include "fitting/fields/torch_advice.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/module.h"

namespace pliant {

#ifdef PLIANT_TORCH
bool can_train_networks() { return true; }
#else
bool can_train_networks() { return false; }
#endif

std::unique_ptr<DistributionLoss> make_distribution_loss(const DistributionNetwork& network, int threads,
                                                         bool in_double) {
  using Factory = DistributionLoss* (*)(const DistributionNetwork&, int, bool);
  CHECK(threads > 0);
  static const auto factory = reinterpret_cast<Factory>(module_function(
      "pliant_distribution.so", "pliant_make_distribution_loss", kTorchAdvice + "use the bundled network"));
  return std::unique_ptr<DistributionLoss>(factory(network, threads, in_double));
}

}  // namespace pliant
