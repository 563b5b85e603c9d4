#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "app/run/options.h"
#include "app/run/progress.h"

namespace pliant {

/// train-predictor: the network that distributes a material over an object, trained anew.
struct TrainPredictor {
  int count, members, epochs;        ///< of the shipped recipe unless told
  std::vector<std::string> runs;     ///< run directories whose fits join
  std::vector<std::string> objects;  ///< folders of splats with material fields, which join too
  TrainPredictor();
};
OptionTable options_of(TrainPredictor& training);

/// Writes predictor.safetensors, curve.csv and figures.json (by family, of families that training never sees) into
/// `out`.  A training that was stopped goes on from `out`/checkpoint.safetensors.
nlohmann::json run_training(const Context& context, const TrainPredictor& training, const std::string& out);

}  // namespace pliant
