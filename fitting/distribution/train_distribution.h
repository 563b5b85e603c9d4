#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "fitting/distribution/distribution_network.h"
#include "fitting/distribution/material_object.h"
#include "fitting/distribution/training_set.h"

namespace pliant {

constexpr int kMostMembers = 16;  ///< of an ensemble

struct TrainDistributionOptions {
  int objects = 8100;            ///< procedural, of the training families
  int validation_objects = 400;  ///< of the validation families
  int members = 5;               ///< networks, trained one after the other from starts of their own
  int epochs = 6;                ///< of each member
  double rate = 1e-3;            ///< of Adam, falling to a twentieth along a cosine
  double decay = 1e-2;           ///< of weights, per unit of rate (Loshchilov and Hutter 2019)
  int hidden = 96;
  int batch_objects = 16, batch_samples = 96;
  Disturbance disturbance = {0.3, 0.15, 0.3};
  uint64_t seed = 0;
  int threads = 1;  ///< results are equal for a seed and a number of threads
  double checkpoint_minutes = 2;
};

struct TrainingEpoch {
  int member = 0;
  double train = 0, validation = 0;  ///< mean negative log likelihood per sample, without calibration
  int done = 0;                      ///< epochs of all members so far, this one and those before a stop included
};

struct TrainDistributionResult {
  DistributionNetwork network;  ///< calibrated on the validation families
  std::vector<TrainingEpoch> curve;
  bool finished = false;  ///< false = `going_on` said no; what is there continues from the checkpoint
};

/// Trains on the corpus and on `more`.  With a `checkpoint` the state is written there every few minutes and at a stop,
/// and a state made with the same options is taken up: the result is that of a run without a stop.  Throws
/// Error{kUsage} for impossible options, Error{kInput} for a checkpoint of other options and where libtorch is missing.
TrainDistributionResult train_distribution(const TrainDistributionOptions& options,
                                           std::span<const MaterialObject> more = {},
                                           const std::filesystem::path& checkpoint = {},
                                           const std::function<bool(const TrainingEpoch&)>& going_on = {});

/// Curve as CSV: member, train, validation.
void write_curve(const std::filesystem::path& file, std::span<const TrainingEpoch> curve);

}  // namespace pliant
