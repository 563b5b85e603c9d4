#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "app/report/tables.h"

namespace pliant {

constexpr double kUsualBand = 0.68;

struct CalibrationOptions {
  std::optional<double> band;  ///< probability that low and high were stated for, kUsualBand if none is given; not with
                               ///< sigma: Error{kUsage}
  uint64_t seed = 1;           ///< halves the rows
};

/// Whether stated uncertainties hold the truth as often as they say (app/statistics/calibration.h), at 68 % and 90 %.
/// A CSV file with the columns estimate, truth and either sigma or low, high; with a column quantity, each is judged by
/// itself, and all together.  At least 8 rows each.  levels: a row for each quantity and level.
nlohmann::json evaluate_calibration(const std::filesystem::path& table, const CalibrationOptions& options);

std::vector<TextTable> calibration_tables(const nlohmann::json& calibration);

}  // namespace pliant
