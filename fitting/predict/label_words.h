#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// A word of a label: lower case, letters and digits of ASCII, singular.
struct LabelWord {
  std::string word;
  bool after_break = false;  ///< a comma, bracket or the like stands before it
};

/// The words of a text without articles, of its first 256 characters and at most 32.  Hyphens and underscores part
/// words; what is neither letter nor digit of ASCII is left out.
std::vector<LabelWord> label_words(std::string_view text);
/// The same words joined by spaces: two names that people would call one have the same key.
std::string label_key(std::string_view text);

}  // namespace pliant
