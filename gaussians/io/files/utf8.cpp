#include "gaussians/io/files/utf8.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace pliant {
using nlohmann::json;

namespace {

/// Whether a byte goes on with a character.
bool goes_on(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

}  // namespace

std::string as_utf8(const std::string& text) {
  return json::parse(json(text).dump(-1, ' ', false, json::error_handler_t::replace));
}

size_t character_count(const std::string& text) {
  return text.size() - static_cast<size_t>(std::count_if(text.begin(), text.end(), goes_on));
}

std::string beginning_of(const std::string& text, size_t most) {
  if (text.size() <= most) return text;
  while (most > 0 && goes_on(text[most])) --most;
  return text.substr(0, most);
}

}  // namespace pliant
