// The self-test of `evaluate` holds, covers every metric of the table, and fails where an answer is missed.

#include "app/evaluate/self_test.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <set>

#include "app/evaluate/metric_table.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

using nlohmann::json;

namespace pliant {
namespace {

TEST(SelfTest, EveryMetricOfTheTableHasItsAnswer) {
  const json result = self_test();
  std::set<std::string> tried;
  for (const json& row : result["checks"]) {
    EXPECT_TRUE(row["ok"].get<bool>()) << row.dump();
    tried.insert(row["metric"].get<std::string>());
  }
  EXPECT_EQ(result["failed"], 0);
  for (const Metric& metric : metric_table()) EXPECT_TRUE(tried.count(metric.key)) << metric.key;
  const std::string table = markdown_of(self_test_tables(result)[0]);
  EXPECT_NE(table.find("| images | psnr | offset by 10 of 255 levels | 28.1308 | 28.1308 | yes |"), std::string::npos);
}

TEST(SelfTest, AMissAndAnErrorAreCounted) {
  const TemporaryFolder folder;
  SelfTest test(folder.path());
  test.check("x", "m", "right", 2, 2.01, 0.02);
  test.check("x", "m", "wrong", 2, 2.03, 0.02);
  test.check("x", "m", "unknown", 2, nullptr, 0.02);
  test.check("x", "m", "unknown as expected", nullptr, nullptr, 0);
  test.check("x", "m", "known against expectation", nullptr, 1, 0);
  test.check_metric("x", "no.such", "missing", 0, json{{"no", 1}}, 0);
  test.run("x", [](SelfTest&) { throw std::runtime_error("broken"); });
  std::string ok;
  for (const json& row : test.rows()) ok += row["ok"].get<bool>() ? 'y' : 'n';
  EXPECT_EQ(ok, "ynnynnn");
}

TEST(SelfTest, TheCommandWritesItsTables) {
  const TemporaryFolder folder;
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_quietly({"evaluate", "self-test", "--out", (folder / "out").string()}), 0);
  EXPECT_NE(testing::internal::GetCapturedStdout().find("| command |"), std::string::npos);
  for (const char* name : {"self-test.json", "self-test.md", "self-test_checks.csv"})
    EXPECT_TRUE(std::filesystem::exists(folder / "out" / name)) << name;
}

// In a folder with a name so long that no file fits in it, all that is read from files is missed.
TEST(SelfTest, OneThatFailsPrintsItsJsonAsWell) {
  const TemporaryFolder folder;
  constexpr size_t kLongest = 4095;  // PATH_MAX without the end
  std::string place = folder.path().string();
  const size_t own = ("/pliant_self_test_" + std::to_string(::getpid())).size();
  while (place.size() + own < kLongest) {
    const size_t left = kLongest - own - place.size();
    size_t letters = std::min<size_t>(200, left - 1);
    if (left - 1 - letters == 1) --letters;
    place += "/" + std::string(letters, 'x');
  }
  std::filesystem::create_directories(place);
  const char* before = std::getenv("TMPDIR");
  const std::string usual = before ? before : "";
  testing::internal::CaptureStdout();
  ::setenv("TMPDIR", place.c_str(), 1);
  EXPECT_EQ(run_quietly({"evaluate", "self-test", "--json"}), 1);
  if (before)
    ::setenv("TMPDIR", usual.c_str(), 1);
  else
    ::unsetenv("TMPDIR");
  const json result = json::parse(testing::internal::GetCapturedStdout(), nullptr, false);
  ASSERT_TRUE(result.is_object());
  EXPECT_EQ(result["kind"], "self-test");
  EXPECT_GT(result["failed"].get<int>(), 0);
}

}  // namespace
}  // namespace pliant
