#include "app/evaluate/study/study_statistics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "app/report/tables.h"

using nlohmann::json;

namespace pliant {
namespace {

using Group = std::vector<const Participant*>;

json choice_row(const Group& group, const std::string& question, const std::string& baseline,
                const BootstrapOptions& options) {
  std::vector<double> won;
  std::vector<int> cluster;
  int wins = 0;
  for (const Participant* participant : group)
    for (const StudyChoice& choice : participant->choices)
      if (choice.question == question && choice.baseline == baseline) {
        won.push_back(choice.ours ? 1 : 0);
        cluster.push_back(participant->number);
        wins += choice.ours;
      }
  json row = {{"question", question}, {"baseline", baseline}, {"wins", wins}, {"trials", won.size()}};
  for (const char* key : {"share", "low", "high", "wilson_low", "wilson_high", "p_value", "p_holm"}) row[key] = nullptr;
  if (won.empty()) return row;
  const int trials = static_cast<int>(won.size());
  const MeanEstimate share = bootstrap_mean(options, won, cluster);
  const Interval score = wilson(wins, trials, options.level);
  row["share"] = share.mean;
  // Student's interval of few participants may leave the range of a share; NaN stays.
  row["low"] = number_or_null(std::max(share.interval.low, 0.0));
  row["high"] = number_or_null(std::min(share.interval.high, 1.0));
  row["wilson_low"] = score.low;
  row["wilson_high"] = score.high;
  row["p_value"] = binomial_test(wins, trials);
  return row;
}

json rating_row(const Group& group, const std::string& rating, const std::string& method, const std::string& ours,
                const BootstrapOptions& options) {
  std::vector<double> scores, own, other;
  std::vector<int> cluster, pair_cluster;
  for (const Participant* participant : group) {
    std::map<std::string, double> of_ours;
    for (const StudyScore& score : participant->scores)
      if (score.rating == rating && score.method == ours) of_ours[score.scene] = score.value;
    for (const StudyScore& score : participant->scores) {
      if (score.rating != rating || score.method != method) continue;
      scores.push_back(score.value);
      cluster.push_back(participant->number);
      const auto same_scene = of_ours.find(score.scene);
      if (same_scene == of_ours.end()) continue;
      own.push_back(same_scene->second);
      other.push_back(score.value);
      pair_cluster.push_back(participant->number);
    }
  }
  json row = {{"rating", rating}, {"method", method}, {"scores", scores.size()}};
  for (const char* key : {"mean", "low", "high", "ours_minus_it", "difference_low", "difference_high"})
    row[key] = nullptr;
  if (scores.empty()) return row;
  const MeanEstimate mean = bootstrap_mean(options, scores, cluster);
  row["mean"] = mean.mean;
  row["low"] = number_or_null(mean.interval.low);
  row["high"] = number_or_null(mean.interval.high);
  if (method == ours || own.empty()) return row;
  const MeanEstimate difference = bootstrap_difference(options, own, other, pair_cluster);
  row["ours_minus_it"] = difference.mean;
  row["difference_low"] = number_or_null(difference.interval.low);
  row["difference_high"] = number_or_null(difference.interval.high);
  return row;
}

/// Adjusts the p-values of the rows from `begin` on.
void adjust(json& rows, size_t begin) {
  std::vector<double> p;
  for (size_t i = begin; i < rows.size(); ++i)
    if (rows[i]["p_value"].is_number()) p.push_back(rows[i]["p_value"]);
  const std::vector<double> adjusted = holm_adjusted(p);
  size_t next = 0;
  for (size_t i = begin; i < rows.size(); ++i)
    if (rows[i]["p_value"].is_number()) rows[i]["p_holm"] = adjusted[next++];
}

}  // namespace

json study_statistics(const StudyList& study, const std::vector<Participant>& participants,
                      const BootstrapOptions& options) {
  json out = {{"kind", "study"},           {"title", study.title},        {"study", study.id},
              {"ours", study.ours},        {"level", options.level},      {"participants", participants.size()},
              {"excluded", json::array()}, {"incomplete", json::array()}, {"choices", json::array()},
              {"ratings", json::array()}};
  const std::vector<std::string> baselines = baselines_of(study);
  size_t choices = 0, scores = 0;
  for (const StudyScene& scene : study.scenes) {
    choices += (scene.clips.size() - 1) * study.questions.size();
    scores += scene.clips.size() * study.ratings.size();
  }
  std::map<std::string, Group> groups;
  for (const Participant& participant : participants) {
    if (!participant.attentive()) {
      out["excluded"].push_back(participant.number);
      continue;
    }
    if (participant.choices.size() < choices || participant.scores.size() < scores)
      out["incomplete"].push_back(participant.number);
    groups["all"].push_back(&participant);
    groups[participant.professional ? "professionals" : "others"].push_back(&participant);
  }
  for (const char* name : {"professionals", "others"}) out[name] = groups[name].size();
  const bool both = !groups["professionals"].empty() && !groups["others"].empty();
  for (const std::string name : {"all", "professionals", "others"}) {
    if (name != "all" && !both) continue;
    const Group& group = groups[name];
    const size_t begin = out["choices"].size();
    for (const StudyQuestion& question : study.questions)
      for (const std::string& baseline : baselines) {
        json row = choice_row(group, question.name, baseline, options);
        row["group"] = name;
        out["choices"].push_back(std::move(row));
      }
    adjust(out["choices"], begin);
    std::vector<std::string> methods = {study.ours};
    methods.insert(methods.end(), baselines.begin(), baselines.end());
    for (const StudyRating& rating : study.ratings)
      for (const std::string& method : methods) {
        json row = rating_row(group, rating.name, method, study.ours, options);
        row["group"] = name;
        out["ratings"].push_back(std::move(row));
      }
  }
  return out;
}

}  // namespace pliant
