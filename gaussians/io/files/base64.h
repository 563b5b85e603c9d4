#pragma once

#include <string>

namespace pliant {

/// Bytes in the alphabet of RFC 4648, with padding.
std::string base64(const std::string& bytes);

}  // namespace pliant
