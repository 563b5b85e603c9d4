#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "app/evaluate/study/study_answers.h"
#include "app/statistics/bootstrap.h"

namespace pliant {

/// Statistics of a study, for all participants and, where there are both, for professionals and others apart; who fails
/// the checks is left out and listed.
///   choices: a row for each group, question and baseline: wins of ours, trials, share, wilson_low/high and
///   p_value (exact two-sided test against 1/2), which take trials as independent; p_holm, adjusted for all rows of the
///   group; low, high: clustered bootstrap over participants
///   ratings: a row for each group, rating and method: mean with clustered bootstrap interval, scores; difference of
///   ours from it within participant and scene, with its interval
nlohmann::json study_statistics(const StudyList& study, const std::vector<Participant>& participants,
                                const BootstrapOptions& options);

}  // namespace pliant
