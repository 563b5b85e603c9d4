#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "app/evaluate/metrics.h"

namespace pliant {

/// A number that `evaluate` reports, and how to read it.
struct Metric {
  std::string key;    ///< in the result; keys of nested objects are joined by a dot
  std::string title;  ///< for tables
  std::string unit;   ///< may be empty
  bool higher_is_better = false;
  double failure = 0;  ///< what a missing prediction scores at best: the worst value, where there is one
};

/// Every metric by which results are compared.
const std::vector<Metric>& metric_table();

/// A metric of the table by its key, or any other as KEY:higher or KEY:lower.  Of a nested key whose last part is in
/// the table, such as unseen.frequency_error, unit and failure are those of the table.  Throws Error{kUsage} for
/// `option`, also for the wrong direction of what is in the table.
Metric metric_named(const std::string& text, const std::string& option);

/// The value of a key in a result, or null where the result lacks it.  A PSNR that is null because the pictures are
/// identical counts as kPsnrOfIdentical.
nlohmann::json metric_value(const nlohmann::json& result, const std::string& key);

}  // namespace pliant
