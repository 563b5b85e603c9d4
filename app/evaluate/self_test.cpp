#include "app/evaluate/self_test.h"

#include <unistd.h>

#include <cmath>

#include "app/evaluate/metric_table.h"
#include "app/evaluate/metrics.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

/// A folder that disappears with it.
class Scratch {
 public:
  Scratch() : path_(fs::temp_directory_path() / ("pliant_self_test_" + std::to_string(::getpid()))) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

fs::path SelfTest::place(const std::string& name) const {
  fs::create_directories((folder_ / name).parent_path());
  return folder_ / name;
}

void SelfTest::check(const std::string& command, const std::string& metric, const std::string& input,
                     const json& expected, const json& found, double tolerance) {
  const bool ok = expected.is_null()
                      ? found.is_null()
                      : found.is_number() && std::abs(found.get<double>() - expected.get<double>()) <= tolerance;
  rows_.push_back({{"command", command},
                   {"metric", metric},
                   {"input", input},
                   {"expected", expected},
                   {"found", found},
                   {"tolerance", tolerance},
                   {"ok", ok}});
}

void SelfTest::check_metric(const std::string& command, const std::string& metric, const std::string& input,
                            const json& expected, const json& result, double tolerance) {
  const json* found = find_value(result, metric);
  check(command, metric, input, expected, found ? *found : json("missing"), tolerance);
}

void SelfTest::run(const std::string& command, const std::function<void(SelfTest&)>& checks) {
  try {
    checks(*this);
  } catch (const std::exception& error) {
    check(command, "", error.what(), 0, "an error", 0);
  }
}

json self_test() {
  const Scratch scratch;
  SelfTest test(scratch.path());
  test.run("images", check_images);
  test.run("segmentation", check_segmentation);
  test.run("lerf-mask", check_lerf_mask);
  test.run("nvos", check_nvos);
  test.run("repair", check_repair);
  test.run("material", check_material);
  test.run("trajectory", check_trajectory);
  test.run("motion", check_motion);
  test.run("slices", check_slices);
  test.run("study", check_statistics);
  test.run("compare", check_compare);
  json out = {{"kind", "self-test"}, {"checks", test.rows()}, {"failed", 0}};
  for (const json& row : test.rows())
    if (!row["ok"].get<bool>()) out["failed"] = out["failed"].get<int>() + 1;
  return out;
}

std::vector<TextTable> self_test_tables(const json& result) {
  TextTable table{
      "Metrics on inputs with known answers", {"command", "metric", "input", "expected", "found", "ok"}, {}};
  const auto text = [](const json& value) {
    return value.is_string() ? value.get<std::string>() : number_text(value, 6);
  };
  for (const json& row : result["checks"])
    table.rows.push_back({row["command"], row["metric"], row["input"], text(row["expected"]), text(row["found"]),
                          row["ok"].get<bool>() ? "yes" : "NO"});
  return {table};
}

}  // namespace pliant
