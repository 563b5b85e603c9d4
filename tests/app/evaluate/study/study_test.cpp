// A study from its list to its statistics: what the page shows in a browser, and what follows from known answers.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "app/evaluate/study/study_page.h"
#include "app/evaluate/study/study_statistics.h"
#include "app/evaluate/study/study_tables.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/video.h"
#include "tests/app/page/browser.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

class Study : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"ours", "a", "b", "broken"}) {
      VideoWriter writer(folder_ / (std::string(name) + ".mp4"), 30, 64, 48);
      for (int f = 0; f < 6; ++f) writer.write(ImageF(64, 48, 3, 0.1f * static_cast<float>(f)));
      writer.close();
    }
    list_ = {{"title", "Which moves <better>?"},
             {"seed", 5},
             {"ours", "ours"},
             {"scenes",
              {{{"name", "carnation"}, {"clips", {{"ours", "ours.mp4"}, {"A", "a.mp4"}, {"B", "b.mp4"}}}},
               {{"name", "rose"}, {"reference", "b.mp4"}, {"clips", {{"ours", "ours.mp4"}, {"A", "a.mp4"}}}}}},
             {"checks", {{{"good", "ours.mp4"}, {"broken", "broken.mp4"}}}}};
  }
  fs::path write_list() const {
    write_json(folder_ / "study.json", list_);
    return folder_ / "study.json";
  }

  /// A participant's file; `prefers(scene, baseline)` says whether ours is chosen.
  template <class F>
  json answers_of(const StudyList& study, int number, bool professional, F&& prefers, int our_score = 6) const {
    json out = {
        {"kind", "study-answers"}, {"study", study.id}, {"participant", number}, {"professional", professional}};
    json& rows = out["answers"] = json::array();
    for (const StudyScene& scene : study.scenes)
      for (const auto& [method, clip] : scene.clips) {
        rows.push_back({{"kind", "rating"},
                        {"scene", scene.name},
                        {"method", method},
                        {"rating", "quality"},
                        {"value", method == "ours" ? our_score : 4}});
        if (method == "ours") continue;
        for (const StudyQuestion& q : study.questions)
          rows.push_back({{"kind", "choice"},
                          {"scene", scene.name},
                          {"shown", {method, "ours"}},
                          {"question", q.name},
                          {"chosen", prefers(scene.name, method) ? "ours" : method}});
      }
    for (const StudyQuestion& q : study.questions)
      rows.push_back({{"kind", "check"},
                      {"scene", "check 1"},
                      {"shown", {"good", "broken"}},
                      {"question", q.name},
                      {"chosen", "good"}});
    return out;
  }
  fs::path save(const json& answers) const {
    const fs::path file = folder_ / fmt::format("answers/{}.json", answers["participant"].get<int>());
    fs::create_directories(file.parent_path());
    write_json(file, answers);
    return file;
  }

  TemporaryFolder folder_;
  json list_;
};

TEST_F(Study, WhatTheListLeavesOutIsAskedAsInThePapers) {
  const StudyList study = read_study(write_list());
  ASSERT_EQ(study.questions.size(), 2u);
  EXPECT_EQ(study.questions[0].name, "motion");
  ASSERT_EQ(study.ratings.size(), 1u);
  EXPECT_EQ(baselines_of(study), (std::vector<std::string>{"A", "B"}));
  // The identity follows the clips' content.
  fs::copy_file(folder_ / "b.mp4", folder_ / "a.mp4", fs::copy_options::overwrite_existing);
  fs::resize_file(folder_ / "a.mp4", fs::file_size(folder_ / "b.mp4") - 1);
  EXPECT_NE(read_study(folder_ / "study.json").id, study.id);
}

TEST_F(Study, UselessListsAreRefusedByTheirKey) {
  const auto refuse = [&](const json::json_pointer& at, const json& value, const std::vector<std::string>& words) {
    const json before = list_;
    list_[at] = value;
    expect_error(Failure::kUsage, words, [&] { read_study(write_list()); });
    list_ = before;
  };
  refuse("/scnes"_json_pointer, 1, {"scnes", "scenes"});
  refuse("/scenes"_json_pointer, json::array(), {"scenes", "empty"});
  refuse("/scenes/0/clips/A"_json_pointer, "none.mp4", {"scenes[0].clips.A", "does not exist"});
  refuse("/scenes/0/clips/A"_json_pointer, "a.avi", {"a.avi", ".mp4"});
  refuse("/scenes/1/name"_json_pointer, "carnation", {"carnation", "twice"});
  refuse("/ours"_json_pointer, "mine", {"mine"});
  refuse("/seed"_json_pointer, 0.5, {"seed", "0.5"});
  refuse("/ratings"_json_pointer, json::array({{{"name", "q"}, {"text", "?"}, {"lowest", 3}, {"highest", 2}}}),
         {"highest"});
  refuse("/questions"_json_pointer, json::array(), {"checks", "questions"});
  list_["questions"] = list_["ratings"] = json::array();
  expect_error(Failure::kUsage, {"questions", "ask something"}, [&] { read_study(write_list()); });
}

TEST_F(Study, ThePageFetchesNothingAndItsPolicyNamesItsScriptAndStyle) {
  const std::string page = study_page(read_study(write_list()));
  EXPECT_EQ(page.find("http://"), std::string::npos);
  EXPECT_EQ(page.find("https://"), std::string::npos);
  EXPECT_NE(page.find("default-src 'none'; script-src 'sha256-"), std::string::npos);
  EXPECT_EQ(page.find("unsafe-inline"), std::string::npos);
  EXPECT_EQ(page.find("<better>?</title>"), std::string::npos);
  EXPECT_EQ(page.find("/*SCRIPT*/"), std::string::npos);
}

TEST_F(Study, InABrowserAParticipantAnswersEverythingAndSavesIt) {
  if (!browser_missing().empty()) GTEST_SKIP() << browser_missing();
  const StudyList study = read_study(write_list());
  ASSERT_EQ(
      run_quietly({"evaluate", "study", (folder_ / "study.json").string(), "--out", (folder_ / "study.html").string()}),
      0);
  const json answer = evaluate_in_page(R"((async () => {
    const $ = (id) => document.getElementById(id);
    const violations = [];
    document.addEventListener('securitypolicyviolation', (event) => violations.push(event.violatedDirective));
    const order = (n) => JSON.stringify(pliantStudy.trialsOf(n).map((t) => [t.kind, t.scene, t.shown]));
    const orders = [order(1), order(1), order(2), order(3)];
    $('participant').value = '17';
    $('professional').click();
    document.querySelector('#begin button').click();
    const out = {title: document.title, focus: document.activeElement.id, orders, hints: [], unnamed: []};
    document.querySelector('#answers button').click();
    out.hints.push($('hint').textContent);
    for (let trial = 0; !$('trial').hidden && trial < 50; ++trial) {
      for (const set of document.querySelectorAll('fieldset')) {
        if (!set.querySelector('legend').textContent) out.unnamed.push('fieldset');
        set.querySelector('input').click();
      }
      for (const control of document.querySelectorAll('#trial :is(button, input, video, progress)'))
        if (!(control.labels?.length || control.textContent || control.getAttribute('aria-label'))) out.unnamed.push(control.outerHTML);
      document.querySelector('#answers button').click();
      if (trial === 0) out.hints.push($('hint').textContent);
      await Promise.all([...document.querySelectorAll('video')].map((v) => v.ended || new Promise((done) => {
        v.addEventListener('ended', done);
        v.addEventListener('error', done);
      })));
      const before = $('trial-title').textContent;
      document.querySelector('#answers button').click();
      if ($('trial-title').textContent === before && !$('trial').hidden) await new Promise((done) => setTimeout(done, 20));
    }
    const link = new Promise((done) => {
      const click = HTMLAnchorElement.prototype.click;
      HTMLAnchorElement.prototype.click = function() { done(this.download); };
    });
    $('save').click();
    return {...out, file: await link, saved: $('saved').textContent, answers: pliantStudy.answers, violations};
  })())",
                                       (folder_ / "study.html").string(), folder_.path());
  ASSERT_TRUE(answer.contains("value")) << answer.dump();
  const json& value = answer["value"];
  EXPECT_TRUE(answer["said"].empty()) << answer["said"].dump();
  EXPECT_TRUE(value["violations"].empty()) << value["violations"].dump();
  EXPECT_TRUE(value["unnamed"].empty()) << value["unnamed"].dump();
  EXPECT_EQ(value["title"], "Which moves <better>?");
  EXPECT_EQ(value["focus"], "trial-title");
  EXPECT_EQ(value["hints"][0], "Please answer every question.");
  EXPECT_EQ(value["hints"][1], "Please watch to the end once.");
  EXPECT_EQ(value["file"], "answers_17.json");
  EXPECT_EQ(value["orders"][0], value["orders"][1]) << "the order follows from the number";
  EXPECT_NE(value["orders"][0], value["orders"][2]);
  EXPECT_NE(value["orders"][2], value["orders"][3]);
  const std::vector<Participant> read = read_answers(study, {save(value["answers"])});
  EXPECT_TRUE(read[0].professional);
  EXPECT_EQ(read[0].number, 17);
  EXPECT_EQ(read[0].choices.size(), 3u * 2);
  EXPECT_EQ(read[0].scores.size(), 5u);
  EXPECT_EQ(read[0].checks, 2);
}

TEST_F(Study, InABrowserMethodsWithTheSameFileAreToldApart) {
  if (!browser_missing().empty()) GTEST_SKIP() << browser_missing();
  list_["scenes"] = {{{"name", "carnation"}, {"clips", {{"ours", "ours.mp4"}, {"A", "ours.mp4"}}}}};
  list_["checks"] = json::array();
  write_text(folder_ / "study.html", study_page(read_study(write_list())));
  const json answer = evaluate_in_page(
      R"(Array.from({length: 20}, (unused, n) => pliantStudy.trialsOf(n).find((t) => t.kind === 'choice').methods.join()))",
      (folder_ / "study.html").string(), folder_.path());
  ASSERT_TRUE(answer.contains("value")) << answer.dump();
  const auto orders = answer["value"].get<std::set<std::string>>();
  EXPECT_EQ(orders, (std::set<std::string>{"ours,A", "A,ours"}));
}

TEST_F(Study, FewParticipantsHaveWideIntervalsWithinTheirRange) {
  const StudyList study = read_study(write_list());
  std::vector<fs::path> files;
  for (int i = 1; i <= 4; ++i)
    files.push_back(save(answers_of(study, i, false, [&](const std::string& scene, const std::string& method) {
      return method == "A" || (scene == "carnation" && i <= 2);
    })));
  const json found = study_statistics(study, read_answers(study, files), {});
  for (const json& row : found["choices"]) {
    if (row["baseline"] == "A") {
      EXPECT_TRUE(row["low"].is_null() && row["high"].is_null()) << "four equal answers tell no spread";
    } else {
      EXPECT_EQ(row["low"], 0);
      EXPECT_EQ(row["high"], 1);
    }
  }
}

TEST_F(Study, KnownAnswersGiveKnownStatistics) {
  const StudyList study = read_study(write_list());
  // 12 of 15 prefer ours to A in the first scene and all in the second; half prefer it to B.
  std::vector<fs::path> files;
  for (int i = 1; i <= 15; ++i)
    files.push_back(save(answers_of(
        study, i, i <= 3,
        [&](const std::string& scene, const std::string& method) {
          return method == "A" ? scene == "rose" || i <= 12 : i % 2 == 0;
        },
        i % 2 ? 5 : 6)));
  const json found = study_statistics(study, read_answers(study, files), {});
  const auto row = [&](const std::string& array, const std::string& group, const std::string& key,
                       const std::string& name) {
    for (const json& r : found[array])
      if (r["group"] == group && r[key] == name) return r;
    ADD_FAILURE() << group << " " << name;
    return json();
  };
  const json over_a = row("choices", "all", "baseline", "A"), over_b = row("choices", "all", "baseline", "B");
  EXPECT_EQ(over_a["wins"], 27);
  EXPECT_EQ(over_a["trials"], 30);
  EXPECT_NEAR(over_a["p_value"].get<double>(), binomial_test(27, 30), 1e-15);
  EXPECT_NEAR(over_a["wilson_low"].get<double>(), wilson(27, 30).low, 1e-15);
  EXPECT_GT(over_a["low"].get<double>(), 0.7);
  EXPECT_EQ(over_b["wins"], 7);
  EXPECT_LT(over_b["low"].get<double>(), 0.5);
  EXPECT_GT(over_b["high"].get<double>(), 0.5);
  // Four tests: the smallest p-values count fourfold.
  EXPECT_NEAR(over_a["p_holm"].get<double>(), 4 * over_a["p_value"].get<double>(), 1e-12);
  EXPECT_EQ(row("choices", "professionals", "baseline", "A")["trials"], 6);
  EXPECT_EQ(row("choices", "others", "baseline", "A")["trials"], 24);
  const json quality = row("ratings", "all", "method", "A");
  EXPECT_EQ(quality["mean"], 4);
  EXPECT_NEAR(quality["ours_minus_it"].get<double>(), (8 * 1 + 7 * 2) / 15.0, 1e-12);
  EXPECT_EQ(found["professionals"], 3);
  EXPECT_TRUE(found["excluded"].empty() && found["incomplete"].empty());
  EXPECT_NE(markdown_of(study_tables(found)[1]).find("27 of 30"), std::string::npos);
  for (const auto& [level, words] : {std::pair{0.95, "(95 % intervals"}, {0.975, "(97.5 % intervals"}}) {
    json other = found;
    other["level"] = level;
    for (const size_t table : {1, 2})
      EXPECT_NE(study_tables(other)[table].title.find(words), std::string::npos) << study_tables(other)[table].title;
  }

  // The command writes the same, and takes level and resamples.
  const auto tables = [&](const std::string& name, const std::vector<std::string>& options) {
    std::vector<std::string> words = {
        "evaluate", "study", (folder_ / "study.json").string(), "--answers", (folder_ / "answers").string(),
        "--json",   "--out", (folder_ / name).string()};
    words.insert(words.end(), options.begin(), options.end());
    testing::internal::CaptureStdout();
    EXPECT_EQ(run_quietly(words), 0);
    testing::internal::GetCapturedStdout();
    return read_json(folder_ / name / "study.json");
  };
  EXPECT_EQ(tables("usual", {}), found);
  EXPECT_TRUE(fs::exists(folder_ / "usual/study_choices.csv") && fs::exists(folder_ / "usual/study_ratings.csv"));
  EXPECT_GT(tables("level", {"--level", "0.6"})["choices"][0]["low"], found["choices"][0]["low"]);
  EXPECT_NE(tables("few", {"--resamples", "100"})["choices"][0]["low"], found["choices"][0]["low"]);
}

TEST_F(Study, WhoChoosesBrokenClipsIsLeftOutAndWhoStopsEarlyIsListed) {
  const StudyList study = read_study(write_list());
  const auto always = [](const std::string&, const std::string&) { return true; };
  json careless = answers_of(study, 1, false, always), early = answers_of(study, 2, false, always);
  for (json& answer : careless["answers"])
    if (answer["kind"] == "check") answer["chosen"] = "broken";
  early["answers"].erase(early["answers"].begin());
  const json found = study_statistics(study, read_answers(study, {save(careless), save(early)}), {});
  EXPECT_EQ(found["excluded"], json::array({1}));
  EXPECT_EQ(found["incomplete"], json::array({2}));
  EXPECT_EQ(found["choices"][0]["trials"], 2);
  EXPECT_TRUE(found["choices"][0]["low"].is_null()) << "one participant has no spread";
}

TEST_F(Study, AnswersThatAreNoneOfTheStudyAreRefused) {
  const StudyList study = read_study(write_list());
  const json good = answers_of(study, 1, false, [](const std::string&, const std::string&) { return true; });
  const auto refuse = [&](const json::json_pointer& at, const json& value, const std::vector<std::string>& words) {
    json bad = good;
    bad[at] = value;
    const fs::path file = save(bad);
    expect_error(Failure::kInput, words, [&] { read_answers(study, {file}); });
  };
  EXPECT_EQ(read_answers(study, {save(good)}).size(), 1u);
  refuse("/study"_json_pointer, "0123", {"study", "0123", "another study"});
  refuse("/professional"_json_pointer, "yes", {"professional"});
  refuse("/answers/0/method"_json_pointer, "C", {"answers[0].method", "'C'"});
  refuse("/answers/0/value"_json_pointer, 8, {"answers[0].value", "8", "1 to 7"});
  refuse("/answers/0/kind"_json_pointer, "guess", {"kind", "guess"});
  refuse("/answers/1/scene"_json_pointer, "tulip", {"scene", "tulip"});
  refuse("/answers/1/chosen"_json_pointer, "B", {"chosen", "'B'"});
  refuse("/answers/1/shown"_json_pointer, json::array({"A"}), {"shown"});
  refuse("/answers/2"_json_pointer, good["answers"][1], {"twice"});
  save(good);
  json second = good;
  write_json(folder_ / "answers/copy.json", second);
  expect_error(Failure::kInput, {"participant", "two files"}, [&] { read_answers(study, {folder_ / "answers"}); });
  EXPECT_EQ(run_quietly({"evaluate", "study", (folder_ / "study.json").string(), "--level", "0.9"}), 2);
}

}  // namespace
}  // namespace pliant
