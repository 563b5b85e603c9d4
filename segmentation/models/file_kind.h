#pragma once

#include <string>
#include <string_view>

namespace pliant {

/// What a file that is not a network is, by its first bytes, with its article: "a PNG image", "a text".  Empty where
/// they say nothing.
std::string kind_of_file(std::string_view bytes);

}  // namespace pliant
