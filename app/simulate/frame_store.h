#pragma once

#include <filesystem>
#include <string>

#include "physics/simulate/simulate.h"

namespace pliant {

/// Streams frames to a folder, each with the summary up to it, and picks up after the last whole one when the same
/// computation was interrupted.
class FrameStore {
 public:
  /// What another computation left in the folder is removed; `key` tells them apart.
  FrameStore(std::filesystem::path folder, const std::string& key);

  /// State and summary of the last whole frame, or `otherwise` and an empty summary.
  SimulationState resume(const SimulationState& otherwise, SimulateSummary& summary) const;
  void add(const SimulationState& state, const SimulateSummary& summary);
  SimulationState frame(int index) const;
  void remove();

 private:
  std::filesystem::path folder_;
};

}  // namespace pliant
