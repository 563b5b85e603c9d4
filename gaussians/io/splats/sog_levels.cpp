#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/splats/sog.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr int kMostLevels = 64;
constexpr int kDeepestTree = 64;

/// lod-meta.json: which SOG files make up each level of detail.
class LevelFile {
 public:
  explicit LevelFile(const fs::path& file)
      : file_(file), json_(read_json(file)), top_(json_, file.string(), "", Failure::kInput) {
    if (top_.has("version") && top_.number("version") != 1)
      throw top_.complaint("version", "is " + json_["version"].dump(), "version 1 is read");
    const double levels = top_.number("lodLevels");
    if (!(levels >= 1 && levels <= kMostLevels))
      throw complain("lodLevels", "is " + std::to_string(levels), "it must be from 1 to 64");
    levels_ = static_cast<int>(levels);
    for (const nlohmann::json& name : top_.array("filenames")) names_.push_back(path_of("filenames", name));
    const auto environment = json_.find("environment");
    if (environment != json_.end() && !environment->is_null()) environment_ = path_of("environment", *environment);
    promised_.resize(levels_);
    walk(top_.object("tree"), 0);
  }

  int levels() const { return levels_; }

  /// The SOG files of a level with the Gaussians that the tree declares of each.
  const std::map<size_t, uint64_t>& of(int level) const { return promised_[level]; }
  const fs::path& name(size_t index) const { return names_[index]; }

  /// The SOG of what surrounds every level; empty when there is none.
  const fs::path& environment() const { return environment_; }

  bool complete(int level) const {
    std::error_code ignored;
    for (const auto& [index, count] : of(level)) {
      if (!fs::is_regular_file(names_[index], ignored)) return false;
    }
    return !of(level).empty();
  }

  Error complain(const std::string& key, const std::string& problem, const std::string& remedy) const {
    return input_error(file_.string(), key, problem, remedy);
  }

 private:
  /// A file that is named, below the same folder.
  fs::path path_of(const std::string& key, const nlohmann::json& name) const {
    const fs::path path = name.is_string() ? fs::path(name.get<std::string>()).lexically_normal() : fs::path();
    if (path.empty() || path.is_absolute() || *path.begin() == "..") {
      throw complain(key, "holds " + name.dump().substr(0, 60), "names must be those of files below the same folder");
    }
    return file_.parent_path() / path;
  }

  void walk(const JsonObject& node, int depth) {
    if (depth > kDeepestTree) throw complain("tree", "is deeper than 64 nodes", "the file is damaged");
    if (node.has("children")) {
      const nlohmann::json& children = node.array("children");
      for (size_t i = 0; i < children.size(); ++i) {
        walk(JsonObject(children[i], file_.string(), node.path_of("children") + "[" + std::to_string(i) + "]",
                        Failure::kInput),
             depth + 1);
      }
    }
    if (!node.has("lods")) return;
    const JsonObject lods = node.object("lods");
    for (int level = 0; level < levels_; ++level) {
      const std::string key = std::to_string(level);
      if (!lods.has(key)) continue;
      const JsonObject entry = lods.object(key);
      const double index = entry.number("file"), count = entry.number("count");
      if (!(index >= 0 && index < static_cast<double>(names_.size()) && index == std::floor(index))) {
        throw complain(entry.path_of("file"), "is " + std::to_string(index), "it must be an index into filenames");
      }
      if (!(count >= 0 && count <= INT32_MAX))
        throw complain(entry.path_of("count"), "is " + std::to_string(count), "it must be a count");
      promised_[level][static_cast<size_t>(index)] += static_cast<uint64_t>(count);
    }
  }

  fs::path file_;
  nlohmann::json json_;
  JsonObject top_;
  int levels_ = 0;
  std::vector<fs::path> names_;
  fs::path environment_;
  std::vector<std::map<size_t, uint64_t>> promised_;
};

}  // namespace

GaussianCloud read_sog_levels(const fs::path& file, int level, ReadReport* report) {
  const LevelFile levels(file);
  ReadReport found;
  found.files = {file};
  int first = level, last = level;
  if (level == kAllLevels) {
    first = 0;
    last = levels.levels() - 1;
  } else if (level == kFinestLevel) {
    for (first = 0; first < levels.levels() && !levels.complete(first);) ++first;
    if (first == levels.levels())
      throw levels.complain("filenames", "no level has all its files", "fetch the folder again");
    if (first > 0)
      found.warnings.push_back("levels of detail 0 to " + std::to_string(first - 1) + " have no files; level " +
                               std::to_string(first) + " is read");
    last = first;
  } else if (level < 0 || level >= levels.levels()) {
    throw levels.complain("lodLevels", "level " + std::to_string(level) + " was requested",
                          "levels 0 to " + std::to_string(levels.levels() - 1) + " exist");
  }
  GaussianCloud cloud;
  const auto append = [&](const fs::path& name) {
    ReadReport part;
    cloud.append(read_sog(name, &part));
    found.rows += part.rows;
    found.dropped += part.dropped;
    found.antialiased = found.antialiased || part.antialiased;
    found.files.insert(found.files.end(), part.files.begin(), part.files.end());
    for (const std::string& warning : part.warnings) found.warnings.push_back(name.string() + ": " + warning);
    return part.rows;
  };
  for (int at = first; at <= last; ++at) {
    for (const auto& [index, promised] : levels.of(at)) {
      if (const size_t rows = append(levels.name(index)); rows != promised) {
        throw levels.complain("tree",
                              "declares " + std::to_string(promised) + " Gaussians in " + levels.name(index).string() +
                                  ", which contains " + std::to_string(rows),
                              "the files do not belong together");
      }
    }
  }
  std::error_code ignored;
  if (fs::is_regular_file(levels.environment(), ignored))
    append(levels.environment());
  else if (!levels.environment().empty())
    found.warnings.push_back("the environment " + levels.environment().string() + " does not exist; it is left out");
  found.levels = levels.levels();
  found.level = level == kAllLevels ? kAllLevels : first;
  found.format = "streamed SOG, " + (level == kAllLevels ? "all levels" : "level " + std::to_string(first)) + " of " +
                 std::to_string(levels.levels()) + ", SH degree " + std::to_string(cloud.sh_degree);
  if (report) *report = std::move(found);
  return cloud;
}

}  // namespace pliant
