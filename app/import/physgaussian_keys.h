#pragma once

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "gaussians/base/error.h"
#include "gaussians/base/types.h"
#include "gaussians/io/files/json_file.h"

namespace pliant {

/// JSON object of such a configuration, which must outlive this.  A value that is not there stays as it is; one out of
/// its bounds is an Error{kUsage} with its name.
class PhysGaussianKeys {
 public:
  explicit PhysGaussianKeys(const JsonObject& object) : object_(object) {}

  bool has(const std::string& key) const { return object_.has(key); }
  void number(const std::string& key, double& value, double low = -INFINITY, double high = INFINITY) const {
    value = object_.number(key, value);
    if (!(value >= low && value <= high))
      throw object_.complaint(key, "is " + std::to_string(value),
                              "it must lie between " + std::to_string(low) + " and " + std::to_string(high));
  }
  void positive(const std::string& key, double& value) const {
    number(key, value);
    if (!(value > 0)) throw object_.complaint(key, "is " + std::to_string(value), "it must be positive");
  }
  void whole(const std::string& key, int& value, int low, int high) const {
    double number_value = value;
    number(key, number_value, low, high);
    if (number_value != std::floor(number_value))
      throw object_.complaint(key, "is " + std::to_string(number_value), "it must be an integer");
    value = static_cast<int>(number_value);
  }
  /// true, false, or a number as PhysGaussian's files have it.
  void flag(const std::string& key, bool& value, const nlohmann::json& parent) const {
    if (!parent.contains(key)) return;
    value = parent[key].is_boolean() ? parent[key].get<bool>() : object_.number(key) != 0;
  }
  void vector(const std::string& key, Vec3d& value) const {
    if (!has(key)) return;
    const std::vector<double> v = object_.numbers(key, 3);
    value = Vec3d(v[0], v[1], v[2]);
  }
  void half_extent(const std::string& key, Vec3d& value) const {
    vector(key, value);
    if (!(value.minCoeff() > 0))
      throw object_.complaint(key, "has a side that is not positive", "give three half extents");
  }
  void six(const std::string& key, std::optional<std::array<double, 6>>& value, const nlohmann::json& parent) const {
    if (!parent.contains(key) || parent[key].is_null()) return;
    const std::vector<double> v = object_.numbers(key, 6);
    for (int a = 0; a < 3; ++a)
      if (!(v[2 * a] < v[2 * a + 1]))
        throw object_.complaint(key, "is empty along axis " + std::to_string(a), "give x0, x1, y0, y1, z0, z1");
    value = {v[0], v[1], v[2], v[3], v[4], v[5]};
  }
  const JsonObject& object() const { return object_; }

 private:
  const JsonObject& object_;
};

}  // namespace pliant
