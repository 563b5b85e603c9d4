#pragma once

#include <string>

#include "app/evaluate/study/study_list.h"

namespace pliant {

/// The page of a study: one HTML file with all clips in it, which works from the disk and without a network, and lets
/// through nothing but itself (Content-Security-Policy with the hashes of its script and style).  Each pair of our clip
/// and another method's is a two-alternative forced choice, then each clip alone is scored; order and sides are drawn
/// from the study's seed and the participant's number.  Answers are saved as JSON.
std::string study_page(const StudyList& study);

}  // namespace pliant
