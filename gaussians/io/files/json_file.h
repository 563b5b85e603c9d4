#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "gaussians/base/error.h"

namespace pliant {

/// Parses JSON of at most 500 levels.  Throws Error{kInput} naming `file`, `field` and the position of what is wrong.
nlohmann::json parse_json(const std::string& text, const std::string& file, const std::string& field = "");
/// Parses a JSON file.  Throws Error{kInput} naming the file and the position of what is wrong.
nlohmann::json read_json(const std::filesystem::path& file);
/// Writes indented JSON, atomically.
void write_json(const std::filesystem::path& file, const nlohmann::json& value);

/// Reader of one JSON object whose complaints name the file, the key and the value found.  `field` is the path of the
/// object inside the file, empty for the top.
class JsonObject {
 public:
  /// `failure` is the kind of its complaints: usage for files that people write, input for those of other programs.
  JsonObject(const nlohmann::json& value, std::string file, std::string field = "", Failure failure = Failure::kUsage);

  bool has(const std::string& key) const;
  std::vector<std::string> keys() const;
  double number(const std::string& key) const;  ///< finite
  double number(const std::string& key, double otherwise) const;
  bool flag(const std::string& key) const;
  std::string text(const std::string& key) const;
  std::vector<double> numbers(const std::string& key, size_t count) const;  ///< exactly `count`, finite
  const nlohmann::json& array(const std::string& key) const;
  JsonObject object(const std::string& key) const;
  /// Throws an Error naming the nearest known key when a key is not in `known`.
  void refuse_unknown(const std::vector<std::string>& known) const;

  /// An Error about the value of `key`.
  Error complaint(const std::string& key, const std::string& problem, const std::string& remedy) const;
  const std::string& file() const { return file_; }
  std::string path_of(const std::string& key) const { return field_.empty() ? key : field_ + "." + key; }

 private:
  const nlohmann::json& at(const std::string& key) const;

  const nlohmann::json* value_;
  std::string file_, field_;
  Failure failure_;
};

}  // namespace pliant
