#pragma once

#include <string>

#include "gaussians/base/random.h"

namespace pliant {

/// The text with one to three places changed: a byte replaced, a few bytes cut, a character of JSON added, or a part
/// of it repeated.
inline std::string damaged(std::string text, Random& random) {
  const std::string_view json = "0123456789-+eE.,:[]{}\"";
  const auto below = [&](size_t n) { return static_cast<size_t>(random.uniform() * static_cast<double>(n)); };
  const size_t changes = 1 + below(3);
  for (size_t c = 0; c < changes && !text.empty(); ++c) {
    const size_t at = below(text.size());
    if (const double what = random.uniform(); what < 0.4)
      text[at] = static_cast<char>(below(256));
    else if (what < 0.6)
      text.erase(at, 1 + below(8));
    else if (what < 0.8)
      text.insert(at, 1, json[below(json.size())]);
    else
      text.insert(at, text.substr(below(text.size()), 20));
  }
  return text;
}

}  // namespace pliant
