#pragma once

#include <string>

namespace pliant {

/// Code points of a UTF-8 text; bytes that are not UTF-8 become U+FFFD.
std::u32string to_code_points(const std::string& utf8);
std::string to_utf8(const std::u32string& text);

bool is_punctuation(char32_t c);  ///< ASCII other than letters, digits, space and control; elsewhere categories P*
bool is_mark(char32_t c);         ///< category Mn
bool is_space(char32_t c);        ///< blank, tab, line ends, category Zs
bool is_control(char32_t c);      ///< categories Cc and Cf that are not spaces, and U+FFFD

/// The letter in lower case, canonically decomposed, without its marks; of Latin, Greek, Cyrillic and kana, others as
/// they are.
char32_t plain_letter(char32_t c);

}  // namespace pliant
