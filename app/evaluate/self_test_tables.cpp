#include <cmath>

#include "app/evaluate/compare.h"
#include "app/evaluate/self_test.h"
#include "app/evaluate/study/study_statistics.h"
#include "app/statistics/calibration.h"
#include "gaussians/io/files/json_file.h"

using nlohmann::json;

namespace pliant {

void check_statistics(SelfTest& test) {
  // Eight of ten participants prefer ours and score it 5 instead of 3.
  StudyList study;
  study.ours = "ours";
  study.questions = {{"motion", ""}};
  study.ratings = {{"quality", "", "", ""}};
  study.scenes = {{"scene", {}, {{"ours", "a.mp4"}, {"theirs", "b.mp4"}}}};
  std::vector<Participant> participants(10);
  for (int i = 0; i < 10; ++i) {
    participants[i].number = i + 1;
    participants[i].choices = {{"scene", "theirs", "motion", i < 8}};
    participants[i].scores = {{"scene", "ours", "quality", 5}, {"scene", "theirs", "quality", 3}};
  }
  const json found = study_statistics(study, participants, {});
  const json& choice = found["choices"][0];
  test.check("study", "share", "8 of 10", 0.8, choice["share"], 1e-12);
  test.check("study", "wilson_low", "8 of 10 (Wilson 1927)", 0.4901625, choice["wilson_low"], 1e-6);
  test.check("study", "wilson_high", "8 of 10 (Wilson 1927)", 0.9433178, choice["wilson_high"], 1e-6);
  test.check("study", "p_value", "8 of 10: 112 of 1024 outcomes", 112 / 1024.0, choice["p_value"], 1e-12);
  test.check("study", "mean", "all scores 5", 5, found["ratings"][0]["mean"], 0);
  test.check("study", "ours_minus_it", "all scores 5 and 3", 2, found["ratings"][1]["ours_minus_it"], 0);
  test.check("calibration", "high", "0 of 20 (Clopper and Pearson 1934)", 1 - std::pow(0.025, 1 / 20.0),
             clopper_pearson(0, 20).high, 1e-12);
  // Errors on a regular grid of -1 to 1 sigma.
  std::vector<StatedBand> bands;
  for (int i = 0; i < 200; ++i) bands.push_back({0, 1, 1, (i - 99.5) / 100});
  test.check("calibration", "coverage", "errors evenly in 1 sigma, 50 %", 0.67, coverage(bands, 0.5).share, 1e-12);
  test.check("calibration", "coverage", "the same, bands of half the width", 0.34, coverage(bands, 0.5, 0.5).share,
             1e-12);
}

void check_compare(SelfTest& test) {
  const auto write = [&](const std::string& file, double psnr) {
    write_json(test.place("compare/" + file), {{"psnr", psnr}});
  };
  write("ours/a.json", 30);
  write("ours/b.json", 32);
  write("theirs/a.json", 28);
  const json found =
      compare_methods({{"ours", test.place("compare/ours")}, {"theirs", test.place("compare/theirs")}}, {});
  test.check("compare", "mean", "30 and 32 dB", 31, found["means"][0]["mean"], 1e-12);
  test.check("compare", "mean", "28 dB and a missing result: 0 dB", 14, found["means"][1]["mean"], 1e-12);
  test.check("compare", "failures", "a missing result", 1, found["means"][1]["failures"], 0);
  test.check("compare", "difference", "2 and 32 dB", 17, found["differences"][0]["difference"], 1e-12);
}

}  // namespace pliant
