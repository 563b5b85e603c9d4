// What run.json records of a stage's key, and what differs between two such records.

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/run/run_directory.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

bool is_digest(const json& value) { return value.is_string() && value.get_ref<const std::string&>().size() == 64; }

}  // namespace

std::string first_difference(const json& before, const json& now, const std::string& kind) {
  const auto text = [](const json& object, const std::string& key) {
    return !object.contains(key) ? "absent" : is_digest(object[key]) ? "there" : object[key].dump();
  };
  for (const json* names : {&now, &before})
    for (const auto& [key, value] : names->items()) {
      if (before.contains(key) && now.contains(key) && before[key] == now[key]) continue;
      if (before.contains(key) && now.contains(key) && is_digest(before[key]))
        return fmt::format("{} '{}' has changed", kind, key);
      return fmt::format("{} '{}' was {}, now {}", kind, key, text(before, key), text(now, key));
    }
  return "";
}

json record_of(const StageKey& key, uint64_t seed) {
  json inputs = json::object();
  for (const auto& [role, file] : key.inputs) inputs[role] = hash_of_input(file);
  return {{"seed", seed}, {"options", key.options}, {"scene", key.scene}, {"found", key.found}, {"inputs", inputs}};
}

void leave_out_paths(json& record) {
  const json::json_pointer video("/scene/video"), inputs("/inputs");
  if (record.contains(video) && record[video].is_object()) record[video].erase("file");
  if (!record.contains(inputs) || !record[inputs].is_object() || record[inputs].contains("splats")) return;
  json& files = record[inputs];
  std::vector<std::string> roles;
  for (const auto& [role, hash] : files.items())
    if (role.starts_with("splats ")) roles.push_back(role);
  if (roles.size() != 1) return;
  files["splats"] = files[roles[0]];
  files.erase(roles[0]);
}

std::string first_difference(const json& before, const json& now) {
  constexpr std::pair<const char*, const char*> kKinds[] = {
      {"options", "option"}, {"scene", "scene setting"}, {"found", "earlier result"}, {"inputs", "input"}};
  if (before.value("seed", json()) != now["seed"])
    return fmt::format("option 'seed' was {}, now {}", before.value("seed", json()).dump(), now["seed"].dump());
  for (const auto& [key, kind] : kKinds)
    if (std::string changed = first_difference(before.value(key, json::object()), now[key], kind); !changed.empty())
      return changed;
  return "";
}

std::string hash_of_input(const fs::path& path) {
  if (!fs::is_directory(path)) return sha256_of_file(path);
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(path))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::string text;
  for (const fs::path& file : files) text += fs::relative(file, path).string() + " " + sha256_of_file(file) + "\n";
  return sha256_of_text(text);
}

}  // namespace pliant
