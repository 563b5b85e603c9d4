#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "app/report/tables.h"

namespace pliant {

/// The result of study_statistics to read.
std::vector<TextTable> study_tables(const nlohmann::json& statistics);

}  // namespace pliant
