#pragma once

#include <string>

namespace pliant {

/// `text` with U+FFFD in the place of bytes that are not UTF-8; only text that equals it can be written into JSON.
std::string as_utf8(const std::string& text);

}  // namespace pliant
