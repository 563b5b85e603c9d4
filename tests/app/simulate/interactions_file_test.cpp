// What a person wrote into interactions.json of a run directory is not lost.

#include "app/simulate/interactions_file.h"

#include "tests/app/simulate/bar_run.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

using nlohmann::json;

class InteractionsFile : public BarRun {
 protected:
  static json gust(double wind) {
    const json row = {{"type", "gust"}, {"region", "all"}, {"wind", {wind, 0, 0}}, {"drag", 2}, {"duration", 0.03}};
    return json::array({row});
  }
  /// What `simulate` with this file of interactions says.
  std::string said(const std::string& interactions, const std::string& duration = "0.05") const {
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_pliant({"simulate", run(), "--poisson", "0.3", "--density", "500", "--young", "1e5", "--fps", "60",
                          "--duration", duration, "--interactions", interactions}),
              0);
    return testing::internal::GetCapturedStderr();
  }
  fs::path file(const std::string& ending = "") const { return folder_ / ("run/interactions.json" + ending); }
};

TEST_F(InteractionsFile, OfTheSameLoadsStaysAsItWasWrittenAndOfOthersIsMovedAside) {
  make(true);
  const std::string by_hand = R"([ {"duration":3e-2, "type" :"gust","region":"all",

"wind":[1,0,0.0],"drag":2} ])";
  write_text(file(), by_hand);
  EXPECT_EQ(said(file().string()).find("interactions.json.1"), std::string::npos);
  EXPECT_EQ(read_text(file()), by_hand);
  EXPECT_NE(said(file().string()).find("simulate: unchanged"), std::string::npos);
  said(file().string(), "0.1");
  EXPECT_EQ(read_text(file()), by_hand);
  EXPECT_FALSE(fs::exists(file(".1")));

  EXPECT_NE(said(script(gust(2))).find("interactions.json.1"), std::string::npos);
  EXPECT_EQ(read_text(file(".1")), by_hand);
  EXPECT_EQ(json::parse(read_text(file())), gust(2));
  said(file(".1").string());
  EXPECT_EQ(json::parse(read_text(file())), json::parse(by_hand));
  EXPECT_FALSE(fs::exists(file(".2"))) << "what the program itself wrote is replaced";

  write_text(file(), gust(3).dump());
  said(script(gust(4)));
  EXPECT_EQ(read_text(file(".2")), gust(3).dump());
}

TEST_F(InteractionsFile, ThatIsNotJsonIsMovedAside) {
  make(true);
  write_text(file(), "[{\"type\": ");
  said(script(gust(1)));
  EXPECT_EQ(read_text(file(".1")), "[{\"type\": ");
  EXPECT_EQ(json::parse(read_text(file())), gust(1));
}

}  // namespace
}  // namespace pliant
