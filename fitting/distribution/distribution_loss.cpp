#include "fitting/distribution/distribution_loss.h"

#include "fitting/fields/torch_advice.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/module.h"

namespace pliant {
namespace {

using LossFactory = DistributionLoss* (*)(const DistributionNetwork&, int, bool);

LossFactory loss_factory() {
  static const auto factory = reinterpret_cast<LossFactory>(module_function(
      "pliant_distribution.so", "pliant_make_distribution_loss", kTorchAdvice + "use the bundled network"));
  return factory;
}

}  // namespace

#ifdef PLIANT_TORCH
bool can_train_networks() { return true; }
#else
bool can_train_networks() { return false; }
#endif

void require_network_training() { loss_factory(); }

std::unique_ptr<DistributionLoss> make_distribution_loss(const DistributionNetwork& network, int threads,
                                                         bool in_double) {
  CHECK(threads > 0);
  return std::unique_ptr<DistributionLoss>(loss_factory()(network, threads, in_double));
}

}  // namespace pliant
