#pragma once

#include <string_view>

namespace pliant {

/// Files of the study's page, in `web`, that are compiled into the program.
std::string_view study_template();
std::string_view study_style();
std::string_view study_script();

}  // namespace pliant
