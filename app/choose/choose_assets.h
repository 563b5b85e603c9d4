#pragma once

#include <string_view>

namespace pliant {

// What the pages of `web` are made of, compiled into the program.

std::string_view choose_template();  ///< HTML with marks where the rest goes
std::string_view choose_style();
std::string_view choose_script();  ///< choose*.js in one
std::string_view pages_style();    ///< which the page of the choice and that for a file share

}  // namespace pliant
