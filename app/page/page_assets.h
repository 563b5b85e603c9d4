#pragma once

#include <string_view>

namespace pliant {

// What a clip.html is made of, compiled into the program.

std::string_view page_template();  ///< HTML with marks where the rest goes
std::string_view page_style();
std::string_view page_script();    ///< the modules of app/page/web in one
std::string_view solver_module();  ///< WebAssembly; empty where it was not built

}  // namespace pliant
