#include "gaussians/io/files/utf8.h"

#include <nlohmann/json.hpp>

namespace pliant {
using nlohmann::json;

std::string as_utf8(const std::string& text) {
  return json::parse(json(text).dump(-1, ' ', false, json::error_handler_t::replace));
}

}  // namespace pliant
