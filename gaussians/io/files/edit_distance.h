#pragma once

#include <cstddef>
#include <string>

namespace pliant {

/// Fewest characters to insert, delete or replace that turn `a` into `b` (Levenshtein 1966).
size_t edit_distance(const std::string& a, const std::string& b);

}  // namespace pliant
