#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace pliant {

/// The JSON object of a message from a browser or a program, nested at most 16 deep.  Throws Error{kUsage} pointing at
/// `described`, the header that says what messages are, where it is anything else; so do all below.
nlohmann::json parse_message(std::string_view text, const std::string& described);

/// `value`, which `field` of a message has, where it is what the name says.
int64_t whole_number(const nlohmann::json& value, const std::string& field, int64_t least, int64_t most);
double finite_number(const nlohmann::json& value, const std::string& field);  ///< of magnitude below 1e6
bool truth_value(const nlohmann::json& value, const std::string& field);
std::string short_text(const nlohmann::json& value, const std::string& field, size_t longest);  ///< bytes

}  // namespace pliant
