#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace pliant {

/// What a splat file, a camera file (.json) or a scene (folder or scene.json) is: format, counts, bounds, opacities,
/// up (of splats only when a support plane is evident), cameras, settings, warnings.  Throws Error{kInput} for anything else.
nlohmann::json describe(const std::filesystem::path& path);

/// The same as indented lines for people.
std::string description_text(const nlohmann::json& description);

}  // namespace pliant
