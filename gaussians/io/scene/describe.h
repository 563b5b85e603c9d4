#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace pliant {

/// What splats, cameras, photos with cameras or a scene (folder or scene.json) of any format are: format, counts,
/// bounds, opacities, up, cameras, settings, warnings, as the commands find them.  `level` chooses the level of detail
/// of a streamed SOG.  Throws Error{kInput} for anything else.
nlohmann::json describe(const std::filesystem::path& path, std::optional<int> level = {});

/// The same as indented lines for people.
std::string description_text(const nlohmann::json& description);

}  // namespace pliant
