#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/report/tables.h"

namespace pliant {

/// Answers of `evaluate` on inputs for which they are known in closed form.
class SelfTest {
 public:
  explicit SelfTest(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// A new place for the files of a case.
  std::filesystem::path place(const std::string& name) const;
  /// Compares a metric of a result, or a number; what is not known (null) is known as that by an `expected` of null.
  void check(const std::string& command, const std::string& metric, const std::string& input,
             const nlohmann::json& expected, const nlohmann::json& found, double tolerance);
  void check_metric(const std::string& command, const std::string& metric, const std::string& input,
                    const nlohmann::json& expected, const nlohmann::json& result, double tolerance);
  /// Runs checks; an exception in them is a miss.
  void run(const std::string& command, const std::function<void(SelfTest&)>& checks);

  const nlohmann::json& rows() const { return rows_; }

 private:
  std::filesystem::path folder_;
  nlohmann::json rows_ = nlohmann::json::array();
};

// The checks of each command.
void check_images(SelfTest& test);
void check_segmentation(SelfTest& test);
void check_lerf_mask(SelfTest& test);
void check_nvos(SelfTest& test);
void check_repair(SelfTest& test);
void check_material(SelfTest& test);
void check_trajectory(SelfTest& test);
void check_motion(SelfTest& test);
void check_slices(SelfTest& test);
void check_statistics(SelfTest& test);
void check_compare(SelfTest& test);

/// Runs every check in a temporary folder.  checks: rows of command, metric, input, expected, found, tolerance, ok;
/// failed: how many are not.
nlohmann::json self_test();

std::vector<TextTable> self_test_tables(const nlohmann::json& result);

}  // namespace pliant
