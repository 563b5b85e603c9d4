// report.html: times of all stages, and a command that a shell reads as it was typed.

#include "app/commands/report.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/run/options.h"
#include "gaussians/io/files/files.h"
#include "tests/temporary_folder.h"

namespace pliant {

TEST(RunReport, TotalIsTheTimeOfAllStages) {
  using nlohmann::json;
  const TemporaryFolder folder;
  json stages = json::object();
  int seconds = 1, total = 0;
  for (const char* name :
       {"label", "segment", "extract", "repair", "fill", "seed", "fit", "simulate", "render", "page"}) {
    const json nothing = json::object();
    stages[name] = {{"options", nothing}, {"scene", nothing},    {"found", nothing},
                    {"inputs", nothing},  {"outputs", {"x"}},    {"summary", nothing},
                    {"wall_s", seconds},  {"peak_memory_mb", 1}, {"seed", 1}};
    total += seconds;
    seconds *= 2;
  }
  stages["simulate"]["summary"]["motion"] = json::object();
  write_text(folder / "run.json", json({{"scene", {{"source", "x"}}}, {"stages", stages}}).dump());
  write_text(folder / "interactions.json", "[]");
  write_report(RunDirectory::open(folder.path()), Scene(), "pliant run x");
  const std::string report = read_text(folder / "report.html");
  EXPECT_NE(report.find(fmt::format("<td>total</td><td>{:.1f}</td>", static_cast<double>(total))), std::string::npos)
      << report;
}

TEST(QuotedWord, IsReadByAShellAsItIs) {
  const std::vector<std::string> words = {"run a", "potted palm", "it's", "",  "$HOME", "a;b", "*",    "~",
                                          "a\nb",  "\"",          "\\",   "#", "`ls`",  "é",   "--x=1"};
  std::string line = "printf '%s\\0'", expected, read;
  for (const std::string& word : words) {
    line += " " + quoted_word(word);
    expected += word + '\0';
  }
  FILE* shell = popen(line.c_str(), "r");
  ASSERT_TRUE(shell);
  for (int c; (c = std::fgetc(shell)) != EOF;) read += static_cast<char>(c);
  EXPECT_EQ(pclose(shell), 0);
  EXPECT_EQ(read, expected);
  EXPECT_EQ(quoted_word("--video=a_b/c-1.mp4"), "--video=a_b/c-1.mp4");
}

}  // namespace pliant
