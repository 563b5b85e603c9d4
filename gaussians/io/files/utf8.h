#pragma once

#include <string>

namespace pliant {

/// `text` with U+FFFD in the place of bytes that are not UTF-8; only text that equals it can be written into JSON.
std::string as_utf8(const std::string& text);

/// Characters (code points) of a UTF-8 text.
size_t character_count(const std::string& text);

/// At most the first `most` bytes of a UTF-8 text, which end with a whole character.
std::string beginning_of(const std::string& text, size_t most);

}  // namespace pliant
