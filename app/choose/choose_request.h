#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "app/choose/choose_page.h"
#include "gaussians/base/error.h"

namespace pliant {

/// What a client of the choice of an object asks for, see chooser.h.
struct ChooseRequest {
  enum class Kind { kSelect, kHover, kFind, kMake, kName, kCancel };
  Kind kind = Kind::kCancel;
  Marks marks;
  int camera = 0;
  Vec2f pixel = Vec2f::Zero();  ///< of the camera
  uint32_t object = 0;
  std::string label;  ///< or the name
};

/// Throws Error{kUsage} where the text is anything else.
ChooseRequest parse_choose_request(std::string_view text);

/// Its key in the message, which says to all clients what is under way.
const char* name_of(ChooseRequest::Kind kind);

/// An Error{kUsage} to be thrown: what is wrong with a request, or with `field` of it.
Error refused_request(const std::string& field, const std::string& problem);

}  // namespace pliant
