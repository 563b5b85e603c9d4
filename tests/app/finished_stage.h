#pragma once

#include <nlohmann/json.hpp>

namespace pliant {

/// What run.json says of a stage that is done.
inline nlohmann::json finished_stage(const nlohmann::json& summary,
                                     const nlohmann::json& outputs = nlohmann::json::array()) {
  const nlohmann::json none = nlohmann::json::object();
  return {{"options", none}, {"scene", none},      {"found", none},
          {"inputs", none},  {"outputs", outputs}, {"summary", summary}};
}

}  // namespace pliant
