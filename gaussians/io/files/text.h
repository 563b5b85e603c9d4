#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// `text` without the characters of `space` at either end.
std::string trimmed(std::string_view text, std::string_view space = " \t\r\n");

/// What stands between the separators, one piece more than there are of them; pieces may be empty.
std::vector<std::string> split(std::string_view text, char separator);

/// With A..Z as a..z; other bytes, such as those of UTF-8, stay.
std::string lower_case(std::string_view text);

/// Extension of a path in lower case with its dot: ".png" of "photos/A.PNG", empty where there is none.
std::string lower_extension(const std::filesystem::path& path);

}  // namespace pliant
