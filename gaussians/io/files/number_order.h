#pragma once

#include <string>

namespace pliant {

/// Whether a comes before b when runs of digits are compared as numbers.
bool number_order(const std::string& a, const std::string& b);

}  // namespace pliant
